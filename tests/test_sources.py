"""The files that a rule depends on."""

from avs.sources import ROOT, sources

REGISTRY = ["avs/selectors/__init__.py", "avs/selectors/base.py"]


def test_imports_are_followed_also_inside_functions():
    files = sources("avs.cli")
    assert "avs/cli.py" in files
    assert "avs/jobs.py" in files
    assert "avs/episode.py" in files  # through a function of cli.py and through avs/experiment.py
    assert "metrics/image.py" in files
    assert "avs/__init__.py" in files


def test_a_method_is_no_part_of_the_loop():
    files = sources("avs.experiment")
    assert [path for path in files if path.startswith("avs/selectors/")] == [*REGISTRY, "avs/selectors/truth.py"]
    assert not [path for path in files if path.startswith(("avs/report/", "avs/scorer/"))]


def test_a_method_depends_on_its_own_file():
    assert "avs/selectors/fisher.py" in sources("avs.selectors.fisher")
    assert "avs/selectors/farthest.py" not in sources("avs.selectors.fisher")


def test_tables_depend_on_records_not_on_reconstruction():
    files = sources("avs.report.tables")
    assert "avs/record.py" in files
    assert not [path for path in files if "gaussians" in path]
    # The printed names of methods come from the registry, which finds the methods' own files by name.
    assert [path for path in files if path.startswith("avs/selectors/")] == REGISTRY


def test_foreign_modules_have_no_files_here():
    assert sources("numpy", "some.plugin") == []


def test_every_file_exists():
    assert all((ROOT / path).is_file() for path in sources("avs.cli"))

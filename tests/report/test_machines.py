"""Episodes of several machines, or of several versions of a package, are told of beside their numbers."""

import pytest

from avs.nvs.record import EpisodeMeta
from avs.report.figures.psnr_over_views import write_psnr_over_views
from avs.report.machines import machine_notes
from avs.system.errors import UserError
from avs.system.records import write_record
from tests.report.view_synthesis_tables import TableWriter

SAID = "differs between episodes, and numbers may differ with it"


def facts(processor="Intel", cores="2", torch="2.13.0"):
    return EpisodeMeta(
        steps=[],
        total_seconds=1.0,
        peak_memory_bytes=1,
        device="cpu",
        machine={"processor": processor, "cores": cores, "system": "Linux x86_64", "python": "3.11.7"},
        packages={"torch": torch},
        revision=None,
        started="2026-01-01T00:00:00+00:00",
        finished="2026-01-01T00:00:01+00:00",
    )


@pytest.fixture
def table(tmp_path, written, episode):
    """Write the table of three episodes with these facts beside them, None for nothing; return its Markdown."""

    def write(*beside):
        episodes = [episode("random", scene) for scene in ("a", "b", "c")]

        def written_with_facts(records):
            paths = written(records)
            for path, meta in zip(paths, beside, strict=True):
                if meta is not None:
                    write_record(path.with_name("episode.meta.json"), meta)
            return paths

        return TableWriter(tmp_path, written_with_facts)(episodes, ["random"])[1]

    return write


def test_one_machine_is_not_told_of(table):
    assert SAID not in table(facts(), facts(cores="64"), None)


def test_what_differs_is_told_with_how_many_have_which(table):
    markdown = table(facts(), facts("AMD"), facts(torch="2.13.1"))
    assert f"- processor {SAID}: Intel in 2, AMD in 1\n" in markdown
    assert f"- torch {SAID}: 2.13.0 in 2, 2.13.1 in 1\n" in markdown
    assert markdown.count(SAID) == 2


def test_captions_of_figures_tell_of_it_too(tmp_path, written, episode):
    paths = written([episode("random", scene) for scene in ("a", "b")])
    for path, meta in zip(paths, (facts(), facts(torch="2.13.1")), strict=True):
        write_record(path.with_name("episode.meta.json"), meta)
    write_psnr_over_views(paths, ["random"], tmp_path / "curves")
    told = " ".join((tmp_path / "curves.md").read_text().split())
    assert told.endswith(
        "is the end of the optimisation. Torch differs between episodes, and numbers may differ with "
        "it: 2.13.0 in 1, 2.13.1 in 1."
    )


def test_damaged_facts_are_one_line(table, tmp_path):
    with pytest.raises(UserError, match=r"episode\.meta\.json"):
        table(facts(), facts().model_copy(update={"schema_version": 2}), None)


def with_numerics(meta, numerics):
    return meta.model_copy(update={"machine": meta.machine | {"numerics": numerics}})


def test_processors_do_not_matter_where_numerics_are_portable(table):
    assert SAID not in table(with_numerics(facts(), "portable"), with_numerics(facts("AMD"), "portable"), None)


def test_processors_matter_where_seconds_stand_beside_each_other(tmp_path):
    paths = [tmp_path / name / "episode.json" for name in ("a", "b")]
    for path, (processor, cores) in zip(paths, (("Intel", "2"), ("AMD", "64")), strict=True):
        write_record(path.with_name("episode.meta.json"), with_numerics(facts(processor, cores), "portable"))
    assert machine_notes(paths) == []
    told = machine_notes(paths, timed=True)
    assert [note.partition(" differs")[0] for note in told] == ["processor", "cores"]


def test_native_numerics_are_told_of(table):
    markdown = table(with_numerics(facts(), "native"), with_numerics(facts("AMD"), "native"), None)
    assert "- 2 of 2 computed with native numerics: the same run on another kind of processor gives" in markdown
    assert f"- processor {SAID}: AMD in 1, Intel in 1\n" in markdown

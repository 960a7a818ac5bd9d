"""What is missing, changed or of another configuration is made again, and no old table passes for one of this run."""

import os
import re
import shutil
import subprocess
import sys
import time

import pytest
import torch
import yaml
from factories import small_scene

from tests.workflow.project import checkout, environment, run, tiny

RESULTS = "results/tiny"
EPISODE = f"{RESULTS}/episodes/orbit/orbit_0/random/0/episode.json"
SHOWN = {"nvs_table", "scene_table", "significance_table", "psnr_over_views"}


def copy_of(finished, folder, **options):
    checkout(folder, **options)
    for name in ("results/tiny", ".snakemake"):
        shutil.copytree(finished / name, folder / name)
    return folder


@pytest.fixture
def copied(finished, tmp_path):
    """A copy of the finished run."""
    return copy_of(finished, tmp_path / "copied")


def planned(folder):
    """Return the rules that a dry run names, without the target, and what it prints beside."""
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stderr
    rules = set(re.findall(r"^(\w+) +\d+$", result.stdout, re.MULTILINE))
    return rules - {"total", "tables"}, result.stderr


def flip(path):
    """Flip a bit, and leave the file its time, as a disk that fails does."""
    status, content = path.stat(), bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))


def change(path):
    """Change one digit of the settings, by which the episode would have another length."""
    path.write_text(path.read_text().replace('"iterations": 12', '"iterations": 13'))


@pytest.mark.parametrize(
    ("name", "act", "rules"),
    [
        (f"{RESULTS}/tables/nvs_orbit.md", flip, {"nvs_table"}),
        (f"{RESULTS}/tables/nvs_orbit.tex", os.unlink, {"nvs_table"}),
        (f"{RESULTS}/figures/psnr_over_views_orbit.png", flip, {"psnr_over_views"}),
        (EPISODE, flip, {"episode"} | SHOWN),
        (EPISODE, os.unlink, {"episode"} | SHOWN),
        (EPISODE.replace("episode.json", "splats.ply"), flip, {"episode"} | SHOWN),
        (f"{RESULTS}/episodes", shutil.rmtree, {"episode"} | SHOWN),
        (f"{RESULTS}/settings/episode/random.json", change, {"settings", "episode"} | SHOWN),
        (f"{RESULTS}/scenes", shutil.rmtree, {"scene", "episode", "common_states", "ranking_table"} | SHOWN),
        (f"{RESULTS}/logs", shutil.rmtree, {"scene", "episode", "common_states", "ranking_table"} | SHOWN),
        (".snakemake", shutil.rmtree, set()),
    ],
)
def test_damage_is_planned_anew_and_a_dry_run_changes_nothing(copied, name, act, rules):
    act(copied / name)
    before = {path: path.stat().st_mtime_ns for path in (copied / RESULTS).rglob("*")}
    told, _ = planned(copied)
    assert told == rules
    assert {path: path.stat().st_mtime_ns for path in (copied / RESULTS).rglob("*")} == before


def test_sources_and_weights_that_change_are_seen_without_what_snakemake_keeps(finished, tmp_path, monkeypatch):
    """Other code of a table under an old time, then LPIPS's backbone where there was none."""
    copied = copy_of(finished, tmp_path / "copied", linked=("metrics",))
    shutil.rmtree(copied / ".snakemake")
    source = copied / "avs/report/tables/view_synthesis.py"
    content = source.read_text()
    source.write_text(content + "# another line\n")
    os.utime(source, (1, 1))
    assert planned(copied)[0] == {"nvs_table"}
    source.write_text(content)
    os.utime(source, (1, 1))
    monkeypatch.setenv("AVS_WEIGHTS", str(copied / "weights"))
    assert planned(copied)[0] == set()
    backbone = copied / "weights/torchvision/vgg16-397923af.pth"
    backbone.parent.mkdir(parents=True)
    backbone.write_text("weights")
    os.utime(backbone, (1, 1))
    assert planned(copied)[0] == {"episode"} | SHOWN


def test_results_without_lists_are_told_of_once(copied):
    shutil.rmtree(copied / RESULTS / "logs")
    told = planned(copied)[1]
    assert told.count("no list beside it") == 1


def test_a_changed_table_is_set_aside_and_made_again(finished, copied):
    table = copied / RESULTS / "tables" / "nvs_orbit.md"
    with open(table, "a") as stream:
        stream.write("a note by hand\n")
    line = f"{RESULTS}/tables/nvs_orbit.md: was changed after it was written; it is made again\n"
    assert line in planned(copied)[1]
    result = run(copied, "-j2", "tables")
    assert result.returncode == 0, result.stderr
    assert table.read_bytes() == (finished / RESULTS / "tables" / "nvs_orbit.md").read_bytes()
    assert (copied / RESULTS / "set_aside/tables/nvs_orbit.md").read_text().endswith("a note by hand\n")
    assert planned(copied)[0] == set()


def test_a_plan_that_is_gone_is_written_again(copied):
    plan = copied / RESULTS / "plan.json"
    before = plan.read_bytes()
    plan.unlink()
    assert len(planned(copied)[0]) == 1  # one job, since without any nothing is written
    assert not plan.exists()
    assert run(copied, "-j1", "tables").returncode == 0
    assert plan.read_bytes() == before
    assert planned(copied)[0] == set()


def test_a_table_of_no_target_is_set_aside(copied):
    (copied / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"common_states": None}))
    result = run(copied, "-j2", "tables")
    assert result.returncode == 0, result.stderr
    assert not list((copied / RESULTS / "tables").glob("ranking*"))
    assert (copied / RESULTS / "set_aside/tables/ranking_orbit.csv").is_file()
    assert (copied / RESULTS / "tables/nvs_orbit.csv").is_file()


def test_an_outdated_page_that_is_not_asked_for_is_set_aside(copied):
    result = run(copied, "-j2", "report")
    assert result.returncode == 0, result.stderr
    page, aside = copied / RESULTS / "report", copied / RESULTS / "set_aside"
    assert planned(copied)[0] == set()
    (copied / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"selectors": {"random": {"reshuffle": True}}}))
    result = run(copied, "-j2", "tables")
    assert result.returncode == 0, result.stderr
    assert f"{RESULTS}/report/index.html: is of an earlier run; set aside" in result.stderr
    assert {path.name for path in page.iterdir()} == {"scenes"}
    assert {"index.html", "index.js", "tables", "static"} <= {path.name for path in (aside / "report").iterdir()}
    assert not list((copied / RESULTS / "figures").glob("overview*"))
    assert planned(copied)[0] == set()


def run_killed(folder, spared=("report",)):
    """Run the workflow so that each job dies as it starts, as the out-of-memory killer ends one.

    Commands that are spared do not: what the workflow prints at its end is no job.
    """
    killer = folder / "killer"
    killer.mkdir(exist_ok=True)
    # Python imports it before all else.
    (killer / "sitecustomize.py").write_text(
        "import os, sys\n"
        f"if sys.orig_argv[1:3] == ['-m', 'avs'] and not set({list(spared)}) & set(sys.orig_argv):\n"
        "    os.kill(os.getpid(), 9)\n"
    )
    variables = environment() | {"PYTHONPATH": str(killer)}
    words = ["snakemake", "-j1", "tables", "--configfile", "tiny.yaml"]
    result = subprocess.run(words, cwd=folder, env=variables, capture_output=True, text=True, check=False)
    assert result.returncode == 1
    return result


def test_a_job_that_died_after_a_change_runs_again(copied):
    """Its old output is gone, and the tables that stand there are older than the change."""
    (copied / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"selectors": {"random": {"reshuffle": True}}}))
    run_killed(copied)
    assert not (copied / EPISODE).exists()
    assert not list((copied / RESULTS / "tables").glob("nvs*"))
    assert planned(copied)[0] >= {"episode"} | SHOWN


def test_tables_of_an_unfinished_run_do_not_outlive_the_settings_that_they_are_of(copied):
    """As after a run that failed, and one with other settings that was killed at its first job."""
    name = f"{RESULTS}/tables_incomplete"
    (copied / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"selectors": {"random": {"reshuffle": True}}}))
    for text in ("of an earlier run", "of a later one"):  # which takes the place of the earlier one
        (copied / name).mkdir()
        (copied / name / "nvs_orbit.md").write_text(text)
        result = run_killed(copied, spared=())
        assert f"{name}: is of an earlier run; set aside as {RESULTS}/set_aside/tables_incomplete\n" in result.stderr
        assert not (copied / name).exists()
        assert (copied / RESULTS / "set_aside/tables_incomplete/nvs_orbit.md").read_text() == text


def test_such_tables_move_too_where_a_target_is_not_asked_for_whose_settings_change(copied):
    variants = {"sensitivity": {"methods": ["random"], "variants": {"late": {"protocol": {"iterations": 14}}}}}
    (copied / "tiny.yaml").write_text(yaml.safe_dump(tiny() | variants))
    settings = copied / RESULTS / "settings/sensitivity_episode/late/random.json"
    settings.parent.mkdir(parents=True)
    settings.write_text("of other variants")
    assert planned(copied)[0] == set()
    (copied / RESULTS / "tables_incomplete").mkdir()
    assert len(planned(copied)[0]) == 1  # one job, since without any nothing moves
    assert (copied / RESULTS / "tables_incomplete").is_dir()
    assert run(copied, "-j1", "tables").returncode == 0
    assert (copied / RESULTS / "set_aside/tables_incomplete").is_dir()
    assert planned(copied)[0] == set()


def test_settings_that_changed_are_seen_whatever_the_times(copied):
    """As after a kill and a plain copy of the folder, or with a clock that was ahead: nothing is newer."""
    assert planned(copied)[0] == set()
    (copied / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"selectors": {"random": {"reshuffle": True}}}))
    assert run(copied, "-j1", "--until", "settings", "tables").returncode == 0
    shutil.rmtree(copied / ".snakemake")
    now = time.time()
    for path in (copied / "results/tiny").rglob("*"):
        os.utime(path, (now, now))
    assert planned(copied)[0] == {"episode", "common_states", "ranking_table"} | SHOWN


@pytest.mark.parametrize(
    ("options", "line"),
    [
        (["--configfile", "tiny.yaml", "--configfile", "mine.yaml"], "mine.yaml: no scale is named; give all files "),
        (["--directory", ".."], "is not the folder of the workflow, from which its paths start; add --directory "),
    ],
)
def test_a_run_that_would_not_be_the_one_that_is_meant_is_one_line(tmp_path, options, line):
    folder = checkout(tmp_path / "run")
    (folder / "mine.yaml").write_text("seeds: [0]\n")
    words = ["snakemake", "-n", "tables", *options]
    result = subprocess.run(words, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode != 0
    (fault,) = [text for text in (result.stdout + result.stderr).splitlines() if text.startswith("error: ")]
    assert line in fault


def test_the_folder_of_the_workflow_can_be_named_from_elsewhere(tmp_path):
    folder = checkout(tmp_path / "run")
    words = ["snakemake", "-n", "tables", "--snakefile", f"{folder}/Snakefile", "--directory", str(folder)]
    words += ["--configfile", f"{folder}/tiny.yaml"]
    result = subprocess.run(words, cwd=tmp_path, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_a_photograph_that_an_older_one_replaces_is_seen(tmp_path):
    """As ``cp -p`` and ``mv`` leave it: other content, and a time before that of the scene."""
    folder = checkout(tmp_path)
    small_scene(folder / "captures" / "desk", count=16, name="desk", size=(48, 32))
    (folder / "captures" / "desk" / "scene.json").unlink()
    words = (f"{RESULTS}/scenes/captures/desk/scene.json", "--config", "scenes_dir=captures")
    assert run(folder, "-j1", *words).returncode == 0
    assert "Nothing to be done" in run(folder, "-n", *words).stdout
    first, second = sorted((folder / "captures" / "desk" / "images").iterdir())[:2]
    shutil.copy2(second, first)
    os.utime(first, (1, 1))
    assert re.search(r"^scene +1$", run(folder, "-n", *words).stdout, re.MULTILINE)


def test_code_that_the_kernels_share_with_the_episodes_reruns_both(finished, tmp_path):
    """Snakemake would not look at the reasons of the episodes, were the kernels no real input of theirs."""
    copied = copy_of(finished, tmp_path / "copied", linked=("metrics",))
    assert planned(copied)[0] == set()
    with open(copied / "avs/rasterizer/adam.py", "a") as source:
        source.write("# another line\n")
    assert planned(copied)[0] >= {"kernels", "episode", "common_states", "ranking_table"} | SHOWN


def test_one_more_representation_makes_nothing_again(copied):
    """Its kernels are compiled by a job of their own."""
    values = yaml.safe_load((copied / "tiny.yaml").read_text())
    values["agnostic"] = {"representations": {"gaussians": {}, "field": {"kind": "tensorf"}}, "methods": ["random"]}
    (copied / "tiny.yaml").write_text(yaml.safe_dump(values))
    assert planned(copied)[0] == {"kernels", "settings", "agnostic_episode", "agnostic_table"}


def test_tables_of_what_is_there_leave_out_what_other_code_made(finished, tmp_path):
    """Other code of one method: its episodes that the run has not made again yet are not averaged with others."""
    copied = copy_of(finished, tmp_path / "copied", linked=("metrics",))
    source = copied / "avs/selectors/random.py"
    source.write_text(source.read_text() + "# another line\n")
    os.utime(source, (1, 1))
    episode = (copied / EPISODE).read_bytes()
    run_killed(copied)
    (copied / EPISODE).parent.mkdir(parents=True, exist_ok=True)
    (copied / EPISODE).write_bytes(episode)  # as of a job that was not yet begun
    words = [sys.executable, "-m", "avs", "report", RESULTS]
    result = subprocess.run(words, cwd=copied, env=environment(), capture_output=True, text=True, check=False)
    table = (copied / RESULTS / "tables_incomplete/nvs_orbit.md").read_text()
    assert "Incomplete: 1 of 2 episodes is missing" in table, result.stderr
    assert "Random: no episode: it was made with other code or of other files than the last run had" in table


@pytest.mark.parametrize("words", ["--ignore-incomplete", "--touch", "--allowed-rules nvs_table"])
def test_results_are_not_taken_unseen(copied, words):
    (copied / EPISODE).unlink()
    option, *others = words.split()
    result = run(copied, "-j1", "tables", option, *others)
    assert result.returncode == 1
    assert f"{option}: would take results for current that are damaged" in result.stdout + result.stderr


def test_a_report_of_snakemake_shows_current_results_alone(copied):
    (copied / EPISODE).unlink()
    result = run(copied, "-j1", "tables", "--report", "report.zip")
    assert result.returncode == 1
    assert "--report: would show results that are not current, as " in result.stdout + result.stderr
    assert EPISODE in result.stdout + result.stderr
    assert not (copied / "report.zip").exists()


@pytest.mark.skipif(torch.cuda.is_available(), reason="there is a GPU")
def test_without_a_gpu_nothing_is_removed_for_a_run_on_one(copied):
    before = {path: path.read_bytes() for path in (copied / RESULTS).rglob("*") if path.is_file()}
    result = run(copied, "-j1", "tables", "--config", "device=cuda")
    assert result.returncode == 1
    assert "device cuda: torch finds no GPU here; set device: cpu" in result.stdout + result.stderr
    assert {path: path.read_bytes() for path in (copied / RESULTS).rglob("*") if path.is_file()} == before

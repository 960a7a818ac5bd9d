"""The workflow as a user runs it: tables, reruns, kills, bad input. Each run is a real one, only small."""

import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml
from factories import small_scene

from avs.nvs.episode_settings import EpisodeSettings
from avs.system.records import read_record, write_record
from tests.workflow.project import METHODS, ROOT, checkout, environment, run, tiny


def tables(folder):
    """Return the hash of every table and figure."""
    files = sorted(path for name in ("tables", "figures") for path in (folder / "results" / "tiny" / name).iterdir())
    assert files
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def planned(result):
    """Return the number of jobs by rule that a dry run names."""
    assert result.returncode == 0, result.stderr
    return {rule: int(count) for rule, count in re.findall(r"^(\w+)\s+(\d+)$", result.stdout, re.MULTILINE)}


@pytest.fixture
def edited(finished, tmp_path):
    """A copy of the finished run whose code can be edited."""
    folder = checkout(tmp_path / "edited", linked=())
    for name in ("results/tiny", ".snakemake"):
        shutil.copytree(finished / name, folder / name)
    return folder


def test_a_run_gives_tables_and_figures(finished):
    results = finished / "results" / "tiny"
    assert {path.name for path in (results / "tables").iterdir()} >= {"nvs_orbit.csv", "nvs_orbit.md", "nvs_orbit.tex"}
    figures = {path.name for path in (results / "figures").iterdir()}
    assert figures == {f"psnr_over_views_orbit.{suffix}" for suffix in ("pdf", "png", "md")}
    rows = (results / "tables" / "nvs_orbit.csv").read_text().splitlines()
    assert rows[0] == "method,group,metric,mean,spread,scenes,seeds,published,difference,note"
    assert {row.split(",")[0] for row in rows[1:]} == set(METHODS)


@pytest.mark.parametrize("given", [(), ("--max-jobs-per-timespan", "7/1s")])
def test_the_scheduler_counts_jobs_only_when_it_is_told_to(edited, given):
    tables = edited / "results" / "tiny" / "tables"
    for path in tables.glob("nvs_orbit*"):
        path.unlink()
    done = run(edited, "-j2", *given, "--verbose", "tables")
    assert done.returncode == 0, done.stderr
    limits = re.findall(r"Submitting maximum (\d+) job", done.stdout + done.stderr)
    assert limits == (["7"] if given else [])


def test_the_plan_of_a_run_finds_all_that_its_tables_are_made_from(finished, monkeypatch):
    from avs.config.run_plan import RunPlan
    from avs.config.unfinished_run import unfinished
    from avs.system.files import file_hash
    from avs.system.records import read_record

    monkeypatch.chdir(finished)
    plan = read_record(Path("results/tiny/plan.json"), RunPlan)
    written = {str(path): file_hash(path) for path in Path("results/tiny/settings").rglob("*.json")}
    assert plan.settings == written
    run = unfinished(plan)
    (table,) = run.tables
    assert {wanted.method for wanted in table.episodes} == set(METHODS)
    for wanted in table.episodes:
        assert wanted.path.exists()
        assert wanted.scene.exists()
        assert len(wanted.logs) == 3  # of the episode, the scene and the kernels
        assert all(log.exists() for log in wanted.logs)


def test_a_second_run_has_nothing_to_do(finished):
    result = run(finished, "-j2", "tables")
    assert result.returncode == 0
    assert "Nothing to be done" in result.stderr + result.stdout
    assert "| Method |" not in result.stdout


def test_each_episode_logs_one_line_a_step(finished):
    log = (finished / "results/tiny/logs/episodes/orbit/orbit_0/random/0.log").read_text().splitlines()
    assert [line.split(": ")[1].split(",")[0] for line in log if "PSNR" in line] == [
        "step 1 of 2",
        "step 2 of 2",
        "end",
    ]


def test_a_replay_gives_the_same_curve(finished, tmp_path):
    from avs.nvs.record import Episode
    from avs.system.records import read_record

    record = finished / "results/tiny/episodes/orbit/orbit_0/random/0/episode.json"
    scene = finished / "results/tiny/scenes/orbit/orbit_0"
    words = [sys.executable, "-m", "avs", "replay", str(scene), str(record), "--out", str(tmp_path)]
    result = subprocess.run(words, cwd=ROOT, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    first, second = read_record(record, Episode), read_record(tmp_path / "episode.json", Episode)
    assert second.curve == first.curve
    assert second.selected == first.selected


def test_editing_a_selector_reruns_its_own_episodes_and_what_follows(edited):
    with open(edited / "avs" / "selectors" / "farthest.py", "a") as stream:
        stream.write("\n# an edit\n")
    jobs = planned(run(edited, "-n", "tables"))
    of_episodes = dict.fromkeys(("nvs_table", "scene_table", "significance_table", "psnr_over_views"), 1)
    expected = {"episode": 1, "common_states": 1, "ranking_table": 1, "tables": 1, **of_episodes}
    assert jobs == expected | {"total": sum(expected.values())}


def test_touching_a_file_reruns_nothing(edited):
    (edited / "avs" / "nvs" / "loop.py").touch(exist_ok=True)
    assert "Nothing to be done" in run(edited, "-n", "tables").stdout


@pytest.mark.parametrize(
    ("edit", "jobs"),
    [
        # what the episodes of the method are told, and what the common states are
        ({"selectors": {"random": {"reshuffle": True}}}, {"settings": 2, "episode": 1, "common_states": 1}),
        # the four tables and the figure are told the seeds of what they hold
        ({"seeds": [0, 1]}, {"settings": 5, "episode": 2, "common_states": 1}),
    ],
)
def test_a_change_of_configuration_reruns_what_reads_it(edited, edit, jobs):
    (edited / "tiny.yaml").write_text(yaml.safe_dump(tiny() | edit))
    result = planned(run(edited, "-n", "tables"))
    rules = ("settings", "scene", "episode", "common_states")
    assert {rule: result.get(rule, 0) for rule in rules} == dict.fromkeys(rules, 0) | jobs


def test_a_method_that_follows_another_waits_for_its_episode(tmp_path):
    folder = checkout(tmp_path)
    (folder / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"methods": ["activenerf-views"]}))
    assert planned(run(folder, "-n", "tables"))["episode"] == 2


VARIED = {
    "methods": ["random", "farthest"],
    "variants": {
        "few": {"representation": {"densification": {"max_gaussians": 99}}},
        "late": {"protocol": {"iterations": 14}},
    },
}


def test_variants_of_the_settings_are_a_target_of_their_own(edited):
    (edited / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"sensitivity": VARIED}))
    assert "sensitivity" not in run(edited, "-n", "tables").stdout
    jobs = planned(run(edited, "-n", "sensitivity"))
    assert jobs == {"settings": 5, "sensitivity_episode": 4, "sensitivity_table": 1, "sensitivity": 1, "total": 11}


def test_variants_are_tabulated_with_the_run(edited):
    # Random also ran as a method of the run: its episodes are those of the base, and are not made again.
    (edited / "tiny.yaml").write_text(yaml.safe_dump(tiny() | {"sensitivity": VARIED | {"with_tables": True}}))
    result = run(edited, "-j1", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    tables = edited / "results" / "tiny" / "tables"
    rows = (tables / "sensitivity_orbit.csv").read_text().splitlines()
    assert [row.split(",")[:2] for row in rows[1:]] == [
        [setting, method] for setting in ("base", "few", "late") for method in ("random", "farthest")
    ]
    shutil.rmtree(edited / "results" / "tiny" / "sensitivity" / "late")
    words = [sys.executable, "-m", "avs", "report", "results/tiny"]
    told = subprocess.run(words, cwd=edited, env=environment(), capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stderr
    table = (edited / "results" / "tiny" / "tables_incomplete" / "sensitivity_orbit.md").read_text()
    assert table.startswith("Incomplete: 2 of 6 means are missing.")
    assert "| no episode |" in table


def test_without_variants_the_target_says_what_to_add(edited):
    result = run(edited, "-j1", "sensitivity")
    assert result.returncode != 0
    assert "names no variants of the settings; add some" in result.stdout + result.stderr


def test_a_killed_run_resumes_to_the_same_tables(finished, tmp_path):
    folder = checkout(tmp_path)
    words = ["snakemake", "-j1", "tables", "--configfile", "tiny.yaml"]
    process = subprocess.Popen(words, cwd=folder, env=environment(), stdout=-3, stderr=-3, start_new_session=True)
    episodes = folder / "results" / "tiny" / "episodes"
    _wait(lambda: any(episodes.rglob("splats.ply")) or process.poll() is not None)
    children = _descendants(process.pid)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    _wait(lambda: not any(Path(f"/proc/{pid}/exe").exists() for pid in children), seconds=2)
    assert not any(Path(f"/proc/{pid}/exe").exists() for pid in children), "a job outlived its run"
    result = run(folder, "resume", "-j1", "tables", command=(sys.executable, "-m", "avs"))
    assert result.returncode == 0, result.stdout + result.stderr
    assert tables(folder) == tables(finished)
    assert (folder / "results" / "tiny" / "tables" / "nvs_orbit.md").read_text() in result.stdout


def test_resume_refuses_while_a_run_is_alive(finished):
    stand_in = [sys.executable, "-c", "import time; time.sleep(60)", "snakemake"]
    process = subprocess.Popen(["bash", "-c", 'exec -a snakemake "$@"', "_", *stand_in], cwd=finished)
    try:
        time.sleep(0.5)
        result = run(finished, "resume", "tables", command=(sys.executable, "-m", "avs"))
    finally:
        process.kill()
        process.wait()
    assert result.returncode == 2
    assert "a run is alive" in result.stderr


def test_a_damaged_capture_ends_its_own_jobs_only(tmp_path):
    folder = checkout(tmp_path / "run")
    captures = tmp_path / "captures"
    for number, name in enumerate(("good", "bad")):
        small_scene(captures / name, count=16, name=name, darkest=40 + number)
    image = captures / "bad" / "images" / "005.png"
    image.write_bytes(image.read_bytes()[:60])
    values = tiny() | {"methods": ["farthest"], "scenes_dir": str(captures)}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    result = run(folder, "-j2", "tables")
    assert result.returncode == 1
    lines = [line for line in (result.stdout + result.stderr).splitlines() if line.startswith("error: ")]
    assert any("005.png" in line and line.count("; ") >= 1 for line in lines), result.stderr
    results = folder / "results" / "tiny"
    assert (results / "episodes/captures/good/farthest/0/episode.json").exists()
    assert not (results / "scenes/captures/bad").exists() or not list((results / "scenes/captures/bad").iterdir())
    assert not list((results / "tables").glob("*")) if (results / "tables").exists() else True

    # What is there is tabulated and printed, and says what is not there and why.
    table = (results / "tables_incomplete" / "nvs_captures.md").read_text()
    assert table in result.stdout
    assert table.startswith("Incomplete: 1 of 2 episodes is missing. Left out, because no method has one there: bad.")
    (fault,) = {line.removeprefix("error: ") for line in lines if "005.png" in line}
    assert f"- bad: {fault}\n" in table
    ranking = (results / "tables_incomplete" / "ranking_captures.csv").read_text().splitlines()
    assert {line.split(",")[0] for line in ranking[1:]} == {"farthest"}

    # With the capture corrected, the same line completes the run: its tables replace the incomplete ones.
    small_scene(tmp_path / "again", count=16, name="bad", darkest=41)
    shutil.copy(tmp_path / "again" / "images" / "005.png", image)
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    table = (results / "tables" / "nvs_captures.md").read_text()
    assert table in result.stdout
    assert "2 scenes (bad, good)" in table
    assert "Incomplete" not in result.stdout
    assert not (results / "tables_incomplete").exists()

    # Damaged again, the run fails, and no table of the earlier run is left that could be taken for its own.
    image.write_bytes(image.read_bytes()[:60])
    result = run(folder, "-j2", "tables")
    assert result.returncode == 1
    assert not list((results / "tables").glob("*"))  # Snakemake takes the empty folder away
    aside = "results/tiny/set_aside/tables/nvs_captures.md"
    assert f"results/tiny/tables/nvs_captures.md: is of an earlier run; set aside as {aside}\n" in result.stderr
    assert (folder / aside).read_text() == table


def test_a_data_set_that_is_not_there_keeps_no_other_from_its_tables(tmp_path):
    folder = checkout(tmp_path)
    values = tiny()
    values["datasets"]["mine"] = {"source": "captures", "folder": "nowhere"}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values))
    result = run(folder, "-n", "tables")
    assert result.returncode == 0, result.stderr
    assert result.stderr.count("left out: mine: nowhere: there is no such folder; give the folder that holds") == 1
    assert "orbit_0" in result.stdout
    assert "mine" not in result.stdout


@pytest.mark.parametrize(
    ("option", "line"),
    [
        ("mehtods=[random]", "error: configuration: mehtods: unknown key; did you mean methods?"),
        ("scenes_dir=nowhere", "error: nowhere: "),
    ],
)
def test_a_faulty_configuration_is_one_line(tmp_path, option, line):
    folder = checkout(tmp_path)
    words = ["snakemake", "-n", "tables", "--configfile", "tiny.yaml", "--config", option]
    result = subprocess.run(words, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode != 0
    errors = [text for text in (result.stdout + result.stderr).splitlines() if text.startswith("error: ")]
    assert len(errors) == 1
    assert errors[0].startswith(line)


def test_a_gpu_that_is_not_there_is_one_line(finished, tmp_path):
    import torch

    if torch.cuda.is_available():
        pytest.skip("there is a GPU here")
    settings = tmp_path / "settings.json"
    told = read_record(finished / "results/tiny/settings/episode/random.json", EpisodeSettings)
    write_record(settings, told.model_copy(update={"device": "cuda"}))
    scene = finished / "results/tiny/scenes/orbit/orbit_0"
    words = [
        sys.executable,
        "-m",
        "avs",
        "episode",
        str(scene),
        "0",
        "--settings",
        str(settings),
        "--out",
        str(tmp_path),
    ]
    result = subprocess.run(words, cwd=ROOT, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr == "error: device cuda: torch finds no GPU here; set device: cpu, or run where there is one\n"


def _descendants(pid):
    children = Path(f"/proc/{pid}/task").glob("*/children")
    found = [int(child) for path in children for child in path.read_text().split()]
    return found + [other for child in found for other in _descendants(child)]


def _wait(condition, seconds=120):
    end = time.monotonic() + seconds
    while time.monotonic() < end and not condition():
        time.sleep(0.02)

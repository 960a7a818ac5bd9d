"""How far a run has come: states of jobs from their logs, times from what Snakemake keeps, and what is printed."""

import json
import os
from pathlib import Path

import pytest
import yaml

from avs.config.configuration import load
from avs.config.run_plan import RunPlan
from avs.config.run_progress import JobStatus, job_statuses, mean_seconds, status_lines, time_left
from avs.system.ledger import Origin, write_ledger
from tests.workflow.project import ROOT

BEGUN = 1_000.0


@pytest.fixture
def plan(tmp_path, monkeypatch):
    """Five jobs: one has ended, one runs, one failed, one is of an earlier run, and one has not begun."""
    monkeypatch.chdir(tmp_path)
    logs = [f"results/ci/logs/episodes/orbit/{name}.log" for name in ("done", "runs", "failed", "earlier")]
    for log in logs:
        Path(log).parent.mkdir(parents=True, exist_ok=True)
        Path(log).write_text("step 1\n")
        os.utime(log, (BEGUN + 1, BEGUN + 1))
    Path(logs[2]).write_text("step 1\nerror: x.png: is truncated; replace it\n")
    os.utime(logs[3], (BEGUN - 1, BEGUN - 1))
    written = Path("episode.json")
    written.write_text("{}")
    write_ledger(Path(logs[0]), [written], Origin("stamp"))
    stamps = dict.fromkeys([*logs, "results/ci/logs/kernels.log"], "stamp")
    config = load(yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text()))
    nothing = {"scenes": {}, "timed": None, "published_times": (), "records": {}, "logs": {}}
    return RunPlan(results="results/ci", config=config, stamps=stamps, **nothing)


def states(statuses):
    return {each.log.stem: each.state for each in statuses}


def test_states_follow_from_logs_and_lists(plan):
    found = job_statuses(plan, BEGUN, is_alive=True)
    expected = {"done": "done", "runs": "running", "failed": "failed", "earlier": "to come", "kernels": "to come"}
    assert states(found) == expected
    assert {each.kind for each in found} == {"episodes", "kernels"}
    assert states(job_statuses(plan, BEGUN, is_alive=False)) == expected | {"runs": "stopped"}


def test_jobs_that_wait_for_one_that_failed_are_not_in_the_time_left(plan):
    failed, earlier = (f"results/ci/logs/episodes/orbit/{name}.log" for name in ("failed", "earlier"))
    held = plan.model_copy(update={"waits_for": {earlier: (failed,), "results/ci/logs/kernels.log": (earlier,)}})
    found = job_statuses(held, BEGUN, is_alive=True)
    assert {each.log.stem for each in found if each.is_held} == {"earlier", "kernels"}
    assert time_left(found, {"episodes": 60.0}) == (30.0, 0)  # half of the one that runs
    lines = status_lines(found, {"episodes": 60.0}, is_alive=True)
    assert "2 of those to come wait for a job that failed, and are not counted below" in lines


def test_what_was_made_of_other_files_is_to_come(plan):
    other = plan.model_copy(update={"stamps": dict.fromkeys(plan.stamps, "another stamp")})
    assert states(job_statuses(other, BEGUN, is_alive=True))["done"] == "to come"


def test_what_follows_a_job_that_has_not_ended_is_to_come_though_it_ended_once(plan):
    done, runs, failed = (f"results/ci/logs/episodes/orbit/{name}.log" for name in ("done", "runs", "failed"))
    for earlier in (runs, failed):
        found = job_statuses(plan.model_copy(update={"waits_for": {done: (earlier,)}}), BEGUN, is_alive=True)
        assert states(found)["done"] == "to come"
        assert {each.log.stem for each in found if each.is_held} == ({"done"} if earlier == failed else set())
    lines = status_lines(found, {"episodes": 60.0}, is_alive=True)
    assert "1 of those to come wait for a job that failed, and are not counted below" in lines


def test_the_time_left_is_that_of_jobs_of_the_same_kind(tmp_path):
    for number, seconds in enumerate((10, 30)):
        for output in ("a", "b"):  # two files of one job count once
            told = {"log": [f"results/ci/logs/episodes/{number}.log"], "starttime": 5, "endtime": 5 + seconds}
            (tmp_path / f"{number}{output}").write_text(json.dumps(told))
    (tmp_path / "broken").write_text("{")
    (tmp_path / "without").write_text(json.dumps({"log": [], "starttime": 0, "endtime": 1}))
    other = {"log": ["results/small/logs/episodes/7.log"], "starttime": 0, "endtime": 1000}
    (tmp_path / "other").write_text(json.dumps(other))
    results = Path("results/ci")
    seconds = mean_seconds(results, tmp_path)
    assert seconds == {"episodes": 20.0}
    assert mean_seconds(results, tmp_path / "nowhere") == {}
    kinds = [("episodes", "done"), ("episodes", "running"), ("episodes", "to come"), ("tables", "to come")]
    statuses = [JobStatus(kind, Path("x.log"), state) for kind, state in kinds]
    assert time_left(statuses, seconds) == (30.0, 1)
    assert time_left([*statuses, statuses[1]], seconds) == (20.0, 1), "two run at a time"


def test_the_table_names_what_failed_and_when_it_will_end(plan):
    lines = status_lines(job_statuses(plan, BEGUN, is_alive=True), {"episodes": 600.0}, is_alive=True)
    assert lines[0].split() == ["done", "running", "failed", "to", "come", "mean"]
    assert lines[1].split() == ["episodes", "1", "1", "1", "1", "10", "min"]
    assert "failed: results/ci/logs/episodes/orbit/failed.log: x.png: is truncated; replace it" in lines
    assert lines[-1].endswith("at least 15 min left (1 jobs of kinds that have not run yet are not counted).")
    done = [JobStatus("episodes", Path("x.log"), "done")]
    assert status_lines(done, {}, is_alive=False)[-1] == "All jobs are done."

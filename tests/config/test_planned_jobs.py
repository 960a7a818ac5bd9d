"""What tables of an unfinished run are made from: any record whose weights are made anew does not count."""

from pathlib import Path

import pytest
import yaml

from avs.config.configuration import load
from avs.config.jobs import settings_of
from avs.config.planned_jobs import planned_jobs
from avs.config.report_jobs import ScorerTableJob
from avs.config.run_plan import RunPlan
from avs.config.slam_config import SlamFigureJob
from avs.config.unfinished_run import unfinished
from avs.system.code_inputs import digest
from avs.system.ledger import Origin, write_ledger
from avs.system.records import read_settings, write_record
from tests.workflow.project import ROOT

FIT = "logs/fit.log"
PLACES = {
    "episode": "{dataset}-{scene}-{method}-{seed}",
    "common_states": "{dataset}-{scene}-{seed}",
    "held_out_scores": "{dataset}-{scene}",
    "runtime": "{dataset}-{scene}-{method}",
    "sensitivity_episode": "{variant}-{dataset}-{scene}-{method}-{seed}",
    "agnostic_episode": "{representation}-{dataset}-{scene}-{method}-{seed}",
    "coverage": "{dataset}-{scene}-{method}-{seed}",
    "exploration": "{building}-{method}-{seed}",
}
CONFIG = yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text())


def told_records(run):
    """Return all records that the tables of a run are made from."""
    episodes = [each for table in run.tables for each in (*table.episodes, *table.states)]
    varied = [each for table in run.sensitivity for episodes in table.settings.values() for each in episodes]
    agnostic = [each for table in run.agnostic for episodes in table.representations.values() for each in episodes]
    coverage = [each for table in run.coverage for each in table.records]
    others = [*run.times.records, *run.scorers.records, *run.explorations.records]
    return [*episodes, *varied, *agnostic, *coverage, *others]


def made_from(path):
    return digest.__wrapped__(str(path))


@pytest.fixture
def plan(tmp_path, monkeypatch):
    """A run of ci in which each record was made from one file that another job fitted; all jobs have ended."""
    monkeypatch.chdir(tmp_path)
    values = CONFIG | {"sensitivity": CONFIG["sensitivity"] | {"with_tables": True}}
    config = load(values)
    Path("logs").mkdir()
    Path("settings.json").write_text("400 steps")
    Path("weights").write_text("trained in 400 steps")
    write_ledger(Path(FIT), [Path("weights")], Origin("sources", {"settings.json": made_from("settings.json")}))
    scenes = {name: (f"{name}_0",) for name in config.datasets}
    nothing = RunPlan(
        results="results/ci",
        config=config,
        scenes=scenes,
        studied={"orbit": ("orbit_0",)},
        timed=("orbit", "orbit_0"),
        published_times=(),
        records={"scene": "{dataset}-{scene}.json"} | {rule: f"{rule}-{place}" for rule, place in PLACES.items()},
        logs={rule: f"logs/{rule}-{place}.log" for rule, place in PLACES.items()},
    )
    records = told_records(unfinished(nothing))
    for each in records:
        each.path.write_text("a record")
        write_ledger(each.logs[0], [each.path], Origin("sources", {"weights": made_from("weights")}))
    logs = [FIT, *(str(each.logs[0]) for each in records)]
    return nothing.model_copy(
        update={"stamps": dict.fromkeys(logs, "sources"), "waits_for": dict.fromkeys(logs[1:], (FIT,))}
    )


def test_every_table_knows_the_jobs_behind_its_records(plan):
    records = told_records(unfinished(plan))
    assert {each.path.name.partition("-")[0] for each in records} == PLACES.keys()
    assert all(each.logs[1:] == (Path(FIT),) for each in records)
    assert all(each.stale is None for each in records)


def test_no_record_counts_whose_weights_are_made_anew(plan):
    """The settings have changed, and the fit has begun again: its old file is gone."""
    Path("weights").unlink()
    Path("settings.json").write_text("500 steps")
    reasons = {each.stale for each in told_records(unfinished(plan))}
    assert reasons == {"it was made from files that are gone, or are being made again"}


def test_no_record_counts_whose_weights_are_still_to_be_made_anew(plan):
    """Not even the file of the changed settings is there yet."""
    planned = plan.model_copy(update={"settings": {"settings.json": "digest of 500 steps"}})
    reasons = {each.stale for each in told_records(unfinished(planned))}
    assert reasons == {"it was made with other settings than the last run had"}


def test_settings_have_the_order_in_which_their_job_reads_them(plan, tmp_path):
    jobs = planned_jobs(plan)
    for name, kind in (("scorer_table", ScorerTableJob), ("slam_figure", SlamFigureJob)):
        written = settings_of(plan.config, name)
        write_record(tmp_path / "told.json", written)
        read = read_settings(tmp_path / "told.json", kind)
        assert jobs.settings(name, kind).model_dump_json() == read.model_dump_json()
    assert list(jobs.settings("scorer_table", ScorerTableJob).scenes) == sorted(plan.config.distortions.held_out)
    assert list(plan.config.distortions.held_out) != sorted(plan.config.distortions.held_out)

"""A job is stale for its own sources, its settings, or any job before it; what is stale does not count in a table."""

from pathlib import Path

import pytest

from avs.system.code_inputs import digest_now
from avs.system.ledger import Origin, ledger_of, write_ledger
from avs.system.stale_jobs import linked, stale_jobs, why_left_out

SETTINGS = "settings/fit.json"
WAITS_FOR = {"table.log": ("scores.log", "kernels.log"), "scores.log": ("fit.log", "renders.log"), "fit.log": ()}
STAMPS = {name: f"sources of {name}" for name in ("fit.log", "renders.log", "scores.log", "table.log")}
OTHER_CODE = "it was made with other code or of other files than the last run had"
OTHER_FILES = "it was made from other files than are there now"
OTHER_SETTINGS = "it was made with other settings than the last run had"
GONE = "it was made from files that are gone, or are being made again"


def ended(log, *read):
    """Let a job end that wrote a file of its own name."""
    written = Path(log).with_suffix(".out")
    written.write_text(f"of {log}")
    origin = Origin(STAMPS[log], {path: digest_now(path) for path in read})
    write_ledger(Path(log), [written], origin)


@pytest.fixture
def run(tmp_path, monkeypatch):
    """A run of four jobs, all ended: a fit and renderings, scores made of both, and a table."""
    monkeypatch.chdir(tmp_path)
    Path(SETTINGS).parent.mkdir()
    Path(SETTINGS).write_text("400 steps")
    ended("renders.log")
    ended("fit.log", SETTINGS)
    ended("scores.log", "fit.out", "renders.out")
    ended("table.log", "scores.out")


def stale(**changes):
    return stale_jobs(**{"stamps": STAMPS, "waits_for": WAITS_FOR, "settings": {}} | changes)


def test_nothing_is_stale_of_a_run_that_has_ended_nor_where_nothing_is_known(run):
    assert stale() == {}
    assert stale(settings={SETTINGS: digest_now(SETTINGS)}) == {}
    ledger_of(Path("fit.log")).unlink()
    assert stale(stamps={}) == {}


def test_other_sources_reach_all_that_follows_and_nothing_else(run):
    followers = ("scores.log", "table.log")
    assert stale(stamps=STAMPS | {"fit.log": "other code"}) == dict.fromkeys(("fit.log", *followers), OTHER_CODE)
    assert stale(stamps=STAMPS | {"table.log": "other code"}) == {"table.log": OTHER_CODE}
    Path("renders.out").write_text("other renderings, which nothing but the scores has read")
    assert stale() == dict.fromkeys(followers, OTHER_FILES)


def test_settings_count_before_their_file_is_written_and_after(run):
    following = ("fit.log", "scores.log", "table.log")
    assert stale(settings={SETTINGS: "digest of 500 steps"}) == dict.fromkeys(following, OTHER_SETTINGS)
    Path(SETTINGS).unlink()
    assert stale(settings={SETTINGS: "digest of 500 steps"}) == dict.fromkeys(following, OTHER_SETTINGS)
    Path(SETTINGS).write_text("500 steps")
    assert stale() == dict.fromkeys(following, OTHER_FILES)


def test_what_follows_a_job_that_runs_again_does_not_count(run):
    """Its old files are gone, and what it will write is not known yet."""
    Path("fit.out").unlink()
    assert stale() == dict.fromkeys(("scores.log", "table.log"), GONE)
    ledger_of(Path("fit.log")).unlink()
    assert stale() == {"fit.log": OTHER_CODE} | dict.fromkeys(("scores.log", "table.log"), GONE)


def test_a_look_sees_what_has_changed_since_the_last_one(run):
    assert stale() == {}
    Path("fit.out").write_text("fitted again")
    assert set(stale()) == {"scores.log", "table.log"}
    ended("scores.log", "fit.out", "renders.out")
    assert stale() == {}


def test_the_nearest_jobs_come_first_and_each_once():
    links = {"a": ("b", "c"), "b": ("d",), "c": ("d", "b")}
    assert linked(["a"], links) == ("b", "c", "d")
    assert linked(["d"], links) == ()


def test_what_is_stale_or_of_no_part_of_the_run_or_changed_is_left_out(run):
    fit = Path("fit.log")
    assert why_left_out(fit, STAMPS, {}) is None
    assert why_left_out(fit, STAMPS, {"fit.log": OTHER_CODE}) == OTHER_CODE
    assert why_left_out(fit, {}, {}) is None
    assert "no part of the last run" in why_left_out(fit, {"scores.log": ""}, {})
    Path("fit.out").write_text("another file, whole in itself, copied over it")
    assert why_left_out(fit, STAMPS, {}) == "fit.out holds something else than its job wrote"

"""Tables of an unfinished run: the gaps and their causes, records that do not count, what cannot be tabulated."""

import csv

import pytest

from avs.report.incomplete import write_incomplete_tables
from avs.report.incomplete_scorers import WantedHeldOut, WantedScorers
from avs.report.wanted_records import (
    UnfinishedRun,
    WantedEpisode,
    WantedRecord,
    WantedStates,
    WantedTable,
    WantedTimes,
)
from avs.scene.scene import SceneFile
from avs.scene.similarity import IDENTITY
from avs.system.reasons import Reason
from avs.system.records import write_record
from tests.report.state_records import ONE, make_states, scored, state
from tests.report.test_scorer_agreement import record as held_out_record
from tests.report.timing_records import make_record

METHODS = ("random", "fisherrf", "ours-repvit")
SCENES = ("attic", "cellar")
SEEDS = (0, 1)


class Results:
    """The folder of a run of three methods on two scenes with two seeds."""

    def __init__(self, folder, make_episode):
        self.folder = folder
        self.make_episode = make_episode
        for scene in SCENES:
            self.put_scene(scene)

    def put_scene(self, scene):
        told = {"name": scene, "dataset": "orbit", "source": "", "licence": "", "notes": []}
        held = {
            "test": [],
            "extent": 1.0,
            "to_capture": IDENTITY,
            "images": {},
            "files": {},
            "content_hash": f"hash of {scene}",
        }
        write_record(self.folder / "scenes" / scene / "scene.json", SceneFile(**told, **held))

    def path(self, method, scene, seed):
        return self.folder / "episodes" / method / scene / f"{seed}.json"

    def put(self, method, scene, seed, **changes):
        write_record(self.path(method, scene, seed), self.make_episode(method, scene, seed, **changes))

    def put_all(self, without=()):
        for method in METHODS:
            for scene in SCENES:
                for seed in SEEDS:
                    if not {(method, scene, seed), (method, scene), (method,), (scene,), (seed,)} & set(without):
                        self.put(method, scene, seed)

    def put_states(self, scene, seed, **changes):
        record = make_states([state()], [scored("random", ONE)], scene, seed, **changes)
        write_record(self.folder / "states" / scene / f"{seed}.json", record)

    def log(self, name, text):
        path = self.folder / "logs" / f"{name}.log"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)

    def write(self, methods=METHODS, times=None, absent=None, ranked=False, scorers=None):
        protocol = self.make_episode("random").protocol
        wanted = tuple(
            WantedEpisode(
                method=method,
                path=self.path(method, scene, seed),
                scene=self.folder / "scenes" / scene / "scene.json",
                logs=tuple(self.folder / "logs" / f"{name}.log" for name in (f"{method}-{scene}-{seed}", scene)),
                cell=(scene, seed),
                settings={"protocol": protocol},
            )
            for method in methods
            for scene in SCENES
            for seed in SEEDS
        )
        states = tuple(
            WantedStates(
                path=self.folder / "states" / scene / f"{seed}.json",
                scene=self.folder / "scenes" / scene / "scene.json",
                logs=tuple(self.folder / "logs" / f"{name}.log" for name in (f"states-{scene}-{seed}", scene)),
                cell=(scene, seed),
                settings={"protocol": {"iterations": 100}},
            )
            for scene in SCENES
            for seed in SEEDS
        )
        tables = (WantedTable("orbit", (*methods, *(absent or {})), wanted, None, states if ranked else ()),)
        run = UnfinishedRun("ours-repvit", absent or {}, tables, times, scorers=scorers)
        return write_incomplete_tables(run, self.folder / "tables_incomplete")

    def rows(self):
        with open(self.folder / "tables_incomplete" / "nvs_orbit.csv", newline="") as stream:
            return {(row["method"], row["metric"]): row for row in csv.DictReader(stream)}


@pytest.fixture
def results(tmp_path, episode):
    return Results(tmp_path, episode)


def test_a_row_without_a_complete_seed_is_empty_and_says_why(results):
    results.put_all(without=[("fisherrf", "cellar")])
    results.log("fisherrf-cellar-0", "step 1\nerror: cellar: out of memory; buy some\n")
    results.log("fisherrf-cellar-1", "step 1\n")
    (table,), left_out = results.write()
    assert left_out == []
    assert table.startswith("Incomplete: 2 of 12 episodes are missing. Active view selection")
    assert "| FisherRF | no episode of cellar | – | – |" in table  # noqa: RUF001
    causes = "cellar with seed 0: cellar: out of memory; buy some; cellar with seed 1: its job began and did not end"
    assert f"- FisherRF: no episode of cellar: {causes}\n" in table
    row = results.rows()["fisherrf", "psnr"]
    assert (row["mean"], row["note"]) == ("", f"no episode of cellar: {causes}")
    assert results.rows()["random", "psnr"]["seeds"] == "2"


def test_a_mean_of_fewer_seeds_says_which_and_why(results):
    results.put_all(without=[("fisherrf", "cellar", 1), ("random", "cellar", 1)])
    (table,), _ = results.write()
    said = "mean of seed 0 only, not to be ranked, no episode of cellar with seed 1: its job has not run"
    assert f"- Random, FisherRF: {said}\n" in table
    assert results.rows()["random", "psnr"]["seeds"] == "1"
    assert results.rows()["random", "psnr"]["note"].endswith(said)


def test_a_scene_and_a_seed_without_any_episode_are_left_out_with_a_word(results):
    results.put_all(without=[("cellar",), (1,)])
    results.log("cellar", "error: cellar/a.png: damaged; copy it again\n")
    (table,), _ = results.write()
    assert table.startswith("Incomplete: 9 of 12 episodes are missing. Left out, because no method has one there: ")
    assert "has one there: cellar, seed 1. Active" in table
    assert "- cellar: cellar/a.png: damaged; copy it again\n" in table
    assert results.rows()["random", "psnr"]["scenes"] == "1"
    assert "no episode of" not in table


def test_a_method_without_any_episode_says_why(results):
    results.put_all(without=[("fisherrf",)])
    for scene in SCENES:
        for seed in SEEDS:
            results.log(f"fisherrf-{scene}-{seed}", "Traceback (most recent call last):\nValueError: three\n")
    (table,), _ = results.write(absent={"musiq": Reason(cause="weights musiq absent", remedy="fetch them")})
    assert "| 3D-based | FisherRF | no episode | – | – |" in table  # noqa: RUF001
    assert "- FisherRF: no episode: ValueError: three\n" in table
    assert "- MUSIQ: weights musiq absent: fetch them\n" in table
    assert table.startswith("Incomplete: 4 of 12 episodes")


def test_records_of_other_settings_and_scenes_do_not_count(results):
    results.put_all()
    results.put("random", "attic", 0, protocol={"iterations": 7})
    results.put("fisherrf", "attic", 0, scene_hash="another")
    results.path("fisherrf", "attic", 1).write_text("{")
    (table,), _ = results.write()
    assert table.startswith("Incomplete: 3 of 12 episodes are missing.")
    assert "no episode of attic with seed 0: it was run with another protocol" in table
    assert "it was run on an earlier version of the scene" in table
    assert "is not a JSON object" in table


def test_a_complete_run_has_the_complete_table(results, written, tmp_path):
    from avs.report.tables.view_synthesis import write_nvs_table

    results.put_all()
    (table,), left_out = results.write()
    paths = sorted((tmp_path / "episodes").rglob("*.json"))
    write_nvs_table(paths, METHODS, "orbit", None, tmp_path / "complete", {}, "ours-repvit")
    assert table == (tmp_path / "complete.md").read_text()
    assert left_out == []


def test_the_tables_of_scenes_and_of_significance_tell_of_the_gap_too(results, tmp_path):
    results.put_all(without=[("fisherrf", "cellar")])
    results.write()
    for name in ("scenes_orbit", "significance_orbit"):
        text = (tmp_path / "tables_incomplete" / f"{name}.md").read_text()
        assert text.startswith("Incomplete: 2 of 12 episodes are missing.")
        assert "FisherRF: no episode of cellar: its job has not run" in text
    pairs = (tmp_path / "tables_incomplete" / "significance_orbit_pairs.csv").read_text()
    assert "random,ours-repvit" in pairs
    assert "fisherrf" not in pairs


def test_what_cannot_be_tabulated_is_a_line(results, tmp_path):
    results.log("attic", "error: attic/a.png: damaged; copy it again\n")
    (tmp_path / "tables_incomplete").mkdir()
    (tmp_path / "tables_incomplete" / "nvs_orbit.md").write_text("of an earlier run")
    tables, left_out = results.write()
    assert tables == []
    assert left_out == [
        "left out: tables of orbit: no episode yet; attic/a.png: damaged; copy it again; its job has not run"
    ]
    assert not (tmp_path / "tables_incomplete").exists()


def test_selection_times_name_the_methods_that_are_not_timed(results, tmp_path):
    results.put_all()
    records = []
    for method in METHODS:
        path, log = tmp_path / "runtime" / f"{method}.json", tmp_path / "logs" / f"time-{method}.log"
        records.append(WantedRecord(method, path, tmp_path / "scenes" / "attic" / "scene.json", (log,)))
        if method != "random":
            write_record(path, make_record(method))
    results.log("time-random", "error: random: too slow; wait\n")
    _, left_out = results.write(times=WantedTimes("orbit", METHODS, "attic", tuple(records), {}, ()))
    assert left_out == []
    text = (tmp_path / "tables_incomplete" / "runtime.md").read_text()
    assert text.startswith("Incomplete: 1 method not timed. Selection times on the scene attic")
    assert "- Random: not timed: random: too slow; wait\n" in text
    for record in records[1:]:
        record.path.unlink()
    _, left_out = results.write(times=WantedTimes("orbit", METHODS, "attic", tuple(records), {}, ()))
    assert left_out[0].startswith("left out: table of selection times: no method is timed yet; random: too slow")


def test_a_ranking_names_the_common_states_that_are_missing_and_why(results, tmp_path):
    results.put_all()
    for scene, seed in (("attic", 0), ("attic", 1), ("cellar", 1)):
        results.put_states(scene, seed, protocol={"iterations": 7 if seed else 100})
    results.log("states-cellar-0", "random: scored\nerror: cellar/b.png: damaged; copy it again\n")
    _, left_out = results.write(ranked=True)
    assert left_out == []
    text = (tmp_path / "tables_incomplete" / "ranking_orbit.md").read_text()
    assert text.startswith("Incomplete: 3 of 4 records of common states are missing. Rank correlation")
    assert "- cellar with seed 0: cellar/b.png: damaged; copy it again\n" in text
    assert "- attic with seed 1: it was run with another protocol\n" in text
    assert "| Random | **0.80**" in text


def test_a_ranking_without_any_record_is_a_line_and_the_other_table_is_there(results):
    results.put_all()
    tables, left_out = results.write(ranked=True)
    assert len(tables) == 1
    assert left_out == ["left out: ranking of orbit: no record yet; its job has not run"]


def test_the_table_of_scorers_is_whole_or_left_out_with_the_reason(results):
    results.put_all()
    scenes = {"a_held_out": ("a_1", "a_2")}
    wanted = [
        WantedHeldOut(results.folder / "held_out" / f"{name}.json", (results.folder / "logs" / f"{name}.log",))
        for name in ("a_1", "a_2")
    ]
    scorers = WantedScorers(tuple(wanted), scenes, ("statistics",), {})
    predictor = {"statistics": ("regression", "lowest", lambda ssim, moment: ssim)}
    write_record(wanted[0].path, held_out_record("a_1", **predictor))
    _, left_out = results.write(scorers=scorers)
    assert left_out == ["left out: table of scorers: 1 of 2 held-out scenes have no scores; its job has not run"]
    write_record(wanted[1].path, held_out_record("a_2", **predictor))
    _, left_out = results.write(scorers=scorers)
    assert left_out == []
    assert (results.folder / "tables_incomplete" / "scorer.md").is_file()

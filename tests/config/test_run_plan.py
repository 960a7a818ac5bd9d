"""The plan of a run on disk: its entries keep their order, and it is of the folder that it lies in."""

from pathlib import Path

import pytest
import yaml

from avs.config.configuration import load
from avs.config.method_weights import absent_methods
from avs.config.run_episodes import episodes_of_run
from avs.config.run_plan import PLAN_NAME, RunPlan, read_plan
from avs.system.errors import UserError
from avs.system.records import write_record

ROOT = Path(__file__).parents[2]


@pytest.fixture
def plan(tmp_path, monkeypatch):
    """The plan of a run of ci, on disk, in the folder of its results."""
    monkeypatch.chdir(tmp_path)
    config = load(yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text()))
    scenes = {name: (f"{name}_0",) for name in config.datasets}
    plan = RunPlan(
        results="results/ci",
        config=config,
        scenes=scenes,
        studied={"walkthrough": ("walkthrough_0",), "handheld": ("handheld_0",)},
        timed=None,
        published_times=(),
        records={},
        logs={},
    )
    Path("results/ci").mkdir(parents=True)
    write_record(Path("results/ci") / PLAN_NAME, plan)
    return plan


def test_entries_keep_the_order_of_the_configuration_which_is_that_of_rows(plan):
    read = read_plan(Path("results/ci"))
    assert read.model_dump() == plan.model_dump()
    assert list(plan.config.datasets) != sorted(plan.config.datasets)
    assert list(read.config.datasets) == list(plan.config.datasets) == list(read.scenes)
    assert list(read.studied) == ["walkthrough", "handheld"]
    assert list(read.config.slam.methods) == list(plan.config.slam.methods) != sorted(plan.config.slam.methods)


def test_what_a_run_had_is_known_where_it_is_looked_at_without(plan, monkeypatch, tmp_path):
    had = plan.model_copy(update={"weights_at_hand": ("niqe", "musiq"), "programs": ("mine",)})
    write_record(Path("results/ci") / PLAN_NAME, had)
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "empty"))
    config = read_plan(Path("results/ci")).config
    assert "musiq" not in absent_methods(config)
    assert "maniqa" in absent_methods(config)
    installed = config.model_copy(update={"methods": ("random", "mine", "gone")})
    assert absent_methods(installed)["gone"].cause.startswith("its package is not installed here")
    assert "mine" not in absent_methods(installed)
    assert "gone" not in absent_methods(plan.config.model_copy(update={"methods": ("random", "gone")}))


def test_a_folder_that_was_renamed_is_not_read_as_the_one_that_it_was(plan, tmp_path):
    assert read_plan(tmp_path / "results" / "ci").model_dump() == plan.model_dump()
    Path("results/ci").rename("results/monday")
    with pytest.raises(
        UserError, match=r"of a run whose results are in results/ci.*; run this where results/monday is"
    ):
        read_plan(Path("results/monday"))


def test_episodes_that_an_earlier_run_had_are_none_of_the_run(plan, tmp_path):
    pattern = "results/ci/episodes/{dataset}/{scene}/{method}/{seed}/episode.json"
    write_record(Path("results/ci") / PLAN_NAME, plan.model_copy(update={"records": {"episode": pattern}}))
    places = [("orbit_0", "random", 0), ("orbit_0", "random", 7), ("orbit_9", "random", 0), ("orbit_0", "gone", 0)]
    for scene, method, seed in places:
        path = Path(pattern.format(dataset="orbit", scene=scene, method=method, seed=seed))
        path.parent.mkdir(parents=True)
        path.touch()
    own = Path("results/ci/episodes/orbit/orbit_0/random/0/episode.json")
    assert episodes_of_run(Path("results/ci")) == [own]
    Path("results").rename("moved")
    assert episodes_of_run(Path("moved/ci")) == [Path("moved") / own.relative_to("results")]
    (Path("moved/ci") / PLAN_NAME).unlink()
    assert len(episodes_of_run(Path("moved/ci"))) == len(places)

"""Methods and tables of single data sets: what follows from them, and what is refused."""

import pytest
import yaml

from avs.config.configuration import load
from avs.config.jobs import settings_of
from avs.config.paper_tables import published_scenes, side_by_side
from avs.config.scenes import scene_named, scenes_of, timed_scene
from avs.report.published import MEMORY_METHODS, read_published
from avs.system.errors import UserError
from tests.workflow.project import ROOT

ORBIT = {"source": "embedded", "pattern": "orbit", "seeds": [0]}
HALL = {"source": "embedded", "pattern": "walkthrough", "seeds": [0]}


def values(**hall):
    told = yaml.safe_load((ROOT / "workflows" / "config" / "trial.yaml").read_text())
    told |= {"methods": ["random", "farthest", "musiq", "fisherrf"], "common_states": {}, "coverage": {}}
    return told | {"datasets": {"orbit": ORBIT, "hall": HALL | hall}}


def test_a_data_set_has_its_own_rows_in_its_own_order_as_far_as_the_run_has_them():
    config = load(values(methods=["fisherrf", "random", "warprf"]))
    assert config.methods_on("orbit") == ("random", "farthest", "musiq", "fisherrf")
    assert config.methods_on("hall") == ("fisherrf", "random")
    for table in ("nvs_table", "coverage_table", "ranking_table"):
        told = settings_of(config, f"{table}/hall")
        assert (told.methods, told.absent) == (("fisherrf", "random"), {})
        assert "musiq" in settings_of(config, f"{table}/orbit").methods
    states = settings_of(config, "common_states/hall")
    assert [each.method for each in states.methods] == ["fisherrf", "random"]
    assert settings_of(config, "psnr_over_views").methods == ("random", "farthest", "musiq", "fisherrf")


def test_selections_are_timed_of_the_methods_of_the_timed_scene():
    config = load(values(methods=["fisherrf"]) | {"runtime": {"scene": "walkthrough_0"}})
    assert timed_scene(config) == ("hall", "walkthrough_0")
    told = settings_of(config, "runtime_table")
    assert (told.methods, told.scenes) == (("fisherrf",), {"hall": ("walkthrough_0",)})
    with pytest.raises(UserError, match=r"configuration: coverage\.scene: attic is no scene of this run"):
        scene_named(config, "attic", "coverage.scene")


def test_further_tables_are_those_that_a_data_set_asks_for():
    config = load(values(tables=["coverage"]))
    assert (config.with_table("ranking"), config.with_table("coverage")) == (("orbit",), ("orbit", "hall"))
    assert config.with_table("sensitivity") == ()


def test_a_scene_is_the_same_whatever_tables_make_of_it():
    plain, told = (load(values(**changes)) for changes in ({}, {"methods": ["random"], "tables": []}))
    assert settings_of(plain, "scene/hall/walkthrough_0") == settings_of(told, "scene/hall/walkthrough_0")


def test_a_data_set_without_a_method_of_the_run_is_not_evaluated():
    config = load(values(methods=["warprf"]))
    assert (config.evaluated, config.without_methods) == (("orbit",), ("hall",))
    alone = load(values() | {"datasets": {"hall": HALL | {"methods": ["warprf"]}}})
    with pytest.raises(UserError, match=r"datasets\.hall: the run has none of its methods; add one of them"):
        scenes_of(alone)


@pytest.mark.parametrize(
    ("hall", "line"),
    [
        (
            {"methods": ["fisherf"]},
            r"configuration: datasets\.hall\.methods: fisherf is no method; did you mean fisherrf\?",
        ),
        ({"methods": ["qqqqqqq"]}, r"datasets\.hall\.methods: qqqqqqq is no method; remove it"),
        ({"methods": ["random", "random"]}, r"datasets\.hall\.methods: random is there twice"),
        ({"tables": ["rank"]}, r"datasets\.hall\.tables\.0"),
    ],
)
def test_a_misspelt_name_is_one_line(hall, line):
    with pytest.raises(UserError, match=line) as caught:
        load(values(**hall))
    assert "\n" not in str(caught.value)


def test_a_data_set_for_scorers_has_no_methods():
    held = {"training": ["hall"], "held_out": ["orbit"]}
    with pytest.raises(UserError, match=r"datasets\.hall\.methods is of a data set for scorers"):
        load(values(methods=["random"]) | {"distortions": held})


@pytest.mark.parametrize("dataset", [HALL, {"source": "captures", "folder": "photographs"}])
def test_the_name_of_a_twin_is_kept_for_it(dataset):
    """Else the paper's values would stand beside other scenes as those of its twin."""
    with pytest.raises(UserError, match=r"datasets\.orbit: this name is kept for the embedded twin of Mip-NeRF360"):
        load(values() | {"datasets": {"orbit": dataset}})


def test_the_data_sets_of_one_table_are_the_papers_own_or_their_twins():
    told = {"handheld": HALL | {"pattern": "handheld"}, "walkthrough": HALL}
    config = load(values() | {"datasets": told})
    assert side_by_side(config) == ("walkthrough", "handheld")
    told |= {"mine": HALL | {"published": "realestate10k"}, "realestate10k": HALL}
    assert side_by_side(load(values() | {"datasets": told})) == ("realestate10k", "handheld")
    assert side_by_side(load(values())) == ()
    told = settings_of(config, "side_by_side_table").data_sets
    assert [each.dataset for each in told] == ["walkthrough", "handheld"]


def test_values_of_single_scenes_stand_beside_those_of_mip_nerf360_alone():
    config = load(values(published="mapfree"))
    means = "results/published/nvs_mipnerf360.csv"
    assert published_scenes(config, "orbit") == ("results/published/nvs_mipnerf360_per_scene.csv", means)
    assert published_scenes(config, "hall") == ("results/published/nvs_mapfree.csv",)
    assert published_scenes(load(values()), "hall") == ()


def test_the_table_of_memory_has_the_methods_of_the_paper():
    config = load(values() | {"methods": ["random", "fisherrf"]})
    assert settings_of(config, "runtime_summary/memory").methods == ("fisherrf",)
    assert settings_of(config, "runtime_summary/detail").methods == ("random", "fisherrf")
    paper = read_published(ROOT / "results" / "published" / "runtime_garden.csv", "garden")
    assert {method for method, _ in paper.values} == set(MEMORY_METHODS)

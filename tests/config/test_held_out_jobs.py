"""Which methods score held-out renderings, and when there is a table of them."""

import pytest
import yaml

from avs.config.configuration import load
from avs.config.held_out_jobs import held_out_job, held_out_methods, held_out_scenes, other_scene, scorer_table_job
from tests.workflow.project import ROOT


@pytest.fixture(autouse=True)
def _no_weights(tmp_path, monkeypatch):
    """Look for weights in an empty folder, so that tests are alike on every machine."""
    for name in ("TORCH_HOME", "AVS_WEIGHTS", "HF_HUB_CACHE"):
        monkeypatch.setenv(name, str(tmp_path))


def config(scale="ci", **changes):
    return load(yaml.safe_load((ROOT / "workflows" / "config" / f"{scale}.yaml").read_text()) | changes)


def test_networks_metrics_and_regressions_of_the_run_have_rows():
    job = held_out_job(config())
    assert [each.method for each in job.networks] == ["ours-lite0"]
    assert [each.method for each in job.metrics][-2:] == ["niqe", "piqe"]
    assert job.statistics.resize.pixels == 176
    table = scorer_table_job(config())
    assert {"musiq", "ours-repvit"} <= set(table.absent) < set(table.methods)
    assert "warprf" not in table.methods


@pytest.mark.parametrize("names", [["ours-lite0", "ours-diverse"], ["ours-diverse", "ours-lite0"]])
def test_methods_that_use_a_network_alike_share_a_row_whatever_their_order(names):
    same = {name: {"resize": {"pixels": 176}} for name in names}
    shared = held_out_job(config(methods=names, selectors=same))
    assert [(each.method, each.label) for each in shared.networks] == [("ours-lite0", "Ours-EfficientNet-Lite0")]
    apart = held_out_job(config(methods=names, selectors={"ours-diverse": same["ours-diverse"]}))
    assert {(each.method, each.label, each.resize.pixels) for each in apart.networks} == {
        ("ours-lite0", "Ours-EfficientNet-Lite0 (ours-lite0)", 518),
        ("ours-diverse", "Ours-EfficientNet-Lite0 (ours-diverse)", 176),
    }
    alone = held_out_job(config(methods=["ours-diverse"]))
    assert [(each.method, each.label) for each in alone.networks] == [("ours-diverse", "Ours-EfficientNet-Lite0")]


def test_a_run_without_anything_learned_has_no_table():
    assert held_out_scenes(config(methods=["random", "piqe"])) == {}
    assert held_out_scenes(config(scorer_evaluation=None)) == {}
    assert held_out_scenes(config(methods=["random", "ours-repvit"])) == {}  # its weights are absent
    assert "orbit_held_out" in held_out_scenes(config(methods=["random", "statistics"]))
    assert held_out_job(config(methods=["random", "ours-lite0"])).statistics is None


def test_the_other_scene_is_the_next_held_out_one_or_one_that_trains():
    found = config()
    places = [(name, scene) for name, scenes in held_out_scenes(found).items() for scene in scenes]
    assert [other_scene(found, *place) for place in places] == [*places[1:], places[0]]
    alone = config("check")
    assert other_scene(alone, "handheld_held_out", "handheld_106") == ("handheld_training", "handheld_100")
    assert held_out_methods(alone)

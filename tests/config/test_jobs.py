"""What each rule's jobs are told: from one configuration, in the models that the commands read."""

import json
import re

import pytest
import yaml

from avs.config.configuration import load
from avs.config.jobs import JOBS, settings_of
from avs.datasets.captures import Captures
from avs.system.errors import UserError
from avs.system.records import read_record, record_text
from tests.workflow.project import ROOT

NAMES = {
    "scene": "orbit/orbit_1",
    "episode": "fisherrf4",
    "runtime": "fisherrf4",
    "scorer_train": "dinov2",
    "nvs_table": "orbit",
    "coverage_table": "orbit",
    "ranking_table": "orbit",
    "significance_table": "orbit",
    "critical_difference": "orbit",
    "runtime_summary": "memory",
    "scene_table": "orbit",
    "common_states": "orbit",
    "sensitivity_table": "orbit",
    "sensitivity_episode": "every_point/fisherrf",
    "agnostic_episode": "tensorf/random",
    "agnostic_table": "handheld_small",
    "building": "flat",
    "exploration": "flat/nearest",
    "page_scene": "orbit",
}


@pytest.fixture(scope="module")
def config():
    return load(yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text()))


@pytest.mark.parametrize("rule", JOBS)
def test_a_command_reads_what_the_workflow_wrote(rule, config, tmp_path):
    settings = settings_of(config, f"{rule}/{NAMES.get(rule, '')}")
    path = tmp_path / "settings.json"
    path.write_text(record_text(settings))
    assert read_record(path, type(settings)) == settings


@pytest.mark.parametrize("rule", JOBS)
def test_a_damaged_file_is_one_line(rule, config, tmp_path):
    settings = settings_of(config, f"{rule}/{NAMES.get(rule, '')}")
    values = json.loads(record_text(settings))
    path = tmp_path / "settings.json"
    for text in (json.dumps(values)[:-1], json.dumps(values | {"unheard": 1}), "[]"):
        path.write_text(text)
        with pytest.raises(UserError, match=r"settings\.json: .*; delete it and run again") as caught:
            read_record(path, type(settings))
        assert "\n" not in str(caught.value)


def test_every_rule_that_reads_settings_has_its_model():
    text = "\n".join(path.read_text() for path in (ROOT / "workflows" / "rules").glob("*.smk"))
    assert set(re.findall(r"\{RESULTS\}/settings/(\w+)", text)) == JOBS.keys()


def test_a_method_is_told_its_own_loop(config):
    joint, released, common = (
        settings_of(config, f"episode/{method}").protocol for method in ("fisherrf4", "fisherrf4-released", "random")
    )
    assert joint == common.model_copy(update={"views_per_choice": 4})
    assert (released.views_per_step, released.additions) == (4, (60, 180, 360, 600))
    for method, views in (("fisherrf4", 4), ("fisherrf4-released", 4), ("random", 1)):
        assert settings_of(config, f"runtime/{method}").views_per_step == views


def test_a_table_is_told_which_captures_are_left_out_and_a_scene_nothing_of_its_neighbours(config, tmp_path):
    for name in ("good", "{bad}", "also good"):
        (tmp_path / name / "images").mkdir(parents=True)
    own = config.model_copy(update={"datasets": {"mine": Captures(folder=str(tmp_path))}})
    told = settings_of(own, "nvs_table/mine").left_out
    assert {name: reason.cause for name, reason in told.items()} == {
        "{bad}": "has a name that the workflow cannot take"
    }
    before = record_text(settings_of(own, "scene/mine/good"))
    (tmp_path / "{worse}" / "sparse").mkdir(parents=True)
    assert record_text(settings_of(own, "scene/mine/good")) == before
    assert len(settings_of(own, "nvs_table/mine").left_out) == 2


def test_an_episode_under_a_variant_differs_in_what_the_variant_names_alone(config):
    own, varied = (
        settings_of(config, f"{job}/fisherrf") for job in ("episode", "sensitivity_episode/twice_as_many_gaussians")
    )
    density = own.representation.densification.model_copy(update={"max_gaussians": 12000})
    assert varied.representation == own.representation.model_copy(update={"densification": density})
    assert varied.pictures is None  # nothing shows them
    assert varied.model_copy(update={"representation": own.representation, "pictures": own.pictures}) == own


def test_a_method_whose_views_come_at_other_moments_is_told_so():
    """By the configuration or by the method itself: its row has no rank, as equally many views are not equally fair."""
    values = yaml.safe_load((ROOT / "workflows" / "config" / "trial.yaml").read_text())
    values |= {"methods": ["random", "farthest", "fisherrf4"]}
    values |= {"method_protocols": {"random": {"additions": [1, 2, 3, 4]}}}
    config = load(values)
    own = {method: settings_of(config, f"episode/{method}").own for method in config.methods}
    assert own == {"random": ("additions",), "farthest": (), "fisherrf4": ("views_per_choice",)}
    repeated = {"refit": values["protocol"].get("refit", "continue")}
    config = load(values | {"method_protocols": {"random": {"refit": "reinit"}, "farthest": repeated}})
    own = {method: settings_of(config, f"episode/{method}").own for method in config.methods}
    assert own == {"random": ("refit",), "farthest": (), "fisherrf4": ("views_per_choice",)}

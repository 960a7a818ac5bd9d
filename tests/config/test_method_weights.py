"""Which weights a method gets: published ones, those that the run makes, or none."""

import dataclasses

import pytest
import yaml
from pydantic import create_model

from avs.config.configuration import load
from avs.config.method_weights import (
    Absent,
    Made,
    absent_methods,
    check_named_files,
    files_read,
    files_read_by_back_end,
    files_read_exploring,
    weights_of,
)
from avs.selection import registry
from avs.system.errors import UserError
from avs.system.reasons import Reason
from tests.workflow.project import ROOT


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty cache folder, the only place where weights are looked for."""
    monkeypatch.setenv("TORCH_HOME", str(tmp_path / "torch"))
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path))
    monkeypatch.setenv("HF_HUB_CACHE", str(tmp_path / "hub"))
    return tmp_path


def config(**changes):
    return load(yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text()) | changes)


def absence(name):
    return Reason(cause=f"weights {name} absent", remedy=f"python -m avs weights fetch {name}")


def put(folder, name):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()
    return path


@pytest.fixture
def reading(monkeypatch):
    """Return what registers a method ``reading`` whose setting ``table`` names a file by default."""

    def register(table):
        settings = create_model("Settings", __base__=registry.find("random").method.settings, table=(str, str(table)))
        method = dataclasses.replace(registry.find("random").method, settings=settings)
        found = dict(registry.methods()) | {"reading": dataclasses.replace(registry.find("random"), method=method)}
        monkeypatch.setattr(registry, "methods", lambda: found)

    return register


def test_a_file_that_settings_name_is_read_if_only_by_default(cache, reading):
    one, other = put(cache, "one.json"), put(cache, "other.json")
    reading(one)
    told = config(methods=["reading", "random"])
    assert files_read(told, "reading", evaluated=False) == (one,)
    changed = told.model_copy(update={"selectors": {"reading": {"table": str(other)}}})
    assert files_read(changed, "reading", evaluated=False) == (other,)
    assert files_read(changed, "random", evaluated=False) == ()
    # the settings of a program are its own
    program = told.model_copy(update={"selectors": {"mine": {"deep": [{"table": str(one)}], "word": "table"}}})
    assert files_read(program, "mine", evaluated=False) == (one,)


def test_an_explorer_reads_what_its_own_settings_name(cache, reading):
    one, other = put(cache, "one.json"), put(cache, "other.json")
    reading(one)
    values = yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text())["slam"]
    values["methods"] |= {"mine": {"kind": "selector", "method": "reading", "settings": {"table": str(other)}}}
    told = config(slam=values)
    assert files_read_exploring(told, "mine") == (other,)
    assert files_read_exploring(told, "nearest") == ()


def test_a_back_end_reads_the_weights_of_its_network(cache):
    weights = put(cache, "mast3r/model.safetensors")
    told = config(coverage={"sfm": {"back_end": "mast3r", "weights": str(cache / "mast3r")}})
    assert files_read_by_back_end(told) == (weights,)
    assert files_read_by_back_end(config()) == ()


def test_a_named_file_that_cannot_be_watched_is_one_line(cache, reading):
    reading(put(cache, "{v2}/one.json"))
    with pytest.raises(UserError, match="the workflow cannot take its name"):
        check_named_files(config(methods=["reading", "random"]))


def test_a_method_without_weights_gets_none(cache):
    assert weights_of(config(), "random") is None


def test_absent_weights_are_named_with_the_command_that_fetches_them(cache):
    assert weights_of(config(), "musiq") == Absent(absence("musiq"))
    assert "musiq" in absent_methods(config())
    assert not {"random", "niqe", "ours-lite0"} & absent_methods(config()).keys()


def test_parameters_of_niqe_are_published_or_fitted_or_absent(cache):
    alone = config(distortions=None, scorers={}, methods=["niqe"])
    assert weights_of(config(), "niqe") == Made("niqe_fit", "niqe")
    assert weights_of(alone, "niqe") == Absent(absence("niqe"))
    published = put(cache, "pyiqa/niqe_modelparameters.mat")
    assert weights_of(config(), "niqe") == weights_of(alone, "niqe") == published


def test_regressions_are_fitted_where_there_are_training_scenes(cache):
    alone = config(distortions=None, scorers={}, methods=["statistics"])
    assert weights_of(config(), "statistics") == Made("statistics_fit", "statistics")
    assert weights_of(alone, "statistics").reason.cause == "fitted to training scenes, of which the run has none"


def test_a_scorer_is_published_or_trained_on_a_pretrained_backbone_or_absent(cache):
    assert weights_of(config(), "ours-lite0") == Made("scorer_train", "lite0")
    assert weights_of(config(), "ours-repvit") == Absent(absence("repvit"))
    put(cache, "timm/repvit_m0_9.dist_450e_in1k.safetensors")
    assert weights_of(config(), "ours-repvit") == Made("scorer_train", "repvit")
    assert weights_of(config(), "ours-dinov2") == Absent(absence("crossscore"))
    put(cache, "timm/vit_small_patch14_dinov2.lvd142m.safetensors")
    assert weights_of(config(), "ours-dinov2") == Made("scorer_train", "dinov2")
    published = put(cache, "crossscore/CrossScore-v1.0.0.ckpt")
    assert weights_of(config(), "ours-dinov2") == published


def test_a_backbone_may_be_random_where_the_configuration_says_so(cache):
    values = yaml.safe_load((ROOT / "workflows" / "config" / "check.yaml").read_text())
    assert weights_of(load(values), "ours-repvit") == Made("scorer_train", "repvit")
    assert weights_of(load(values), "ours-dinov2") == Made("scorer_train", "dinov2")


def test_a_program_gets_none(cache):
    values = yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text()) | {"methods": ["mine"]}
    assert weights_of(load(values, ["mine"]), "mine") is None
    assert absent_methods(load(values, ["mine"])) == {}

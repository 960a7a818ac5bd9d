"""Which methods and scenes run under variants of the settings."""

import pytest

from avs.config.run_config import Config
from avs.config.studied import studied_methods, studied_scenes
from avs.system.errors import UserError

SCENES = {"orbit": ["orbit_0", "orbit_1"], "hall": ["hall_0"]}


def config(datasets=None, **changes):
    told = {"methods": ["random", "farthest"], "variants": {"few": {}}} | changes
    embedded = {"source": "embedded", "pattern": "orbit", "seeds": [0]}
    values = {"scale": "tiny", "seeds": [0], "methods": ["random"], "sensitivity": told}
    values["datasets"] = {name: embedded | (datasets or {}).get(name, {}) for name in SCENES}
    return Config.model_validate(values)


def test_all_scenes_or_those_named():
    assert studied_scenes(config().model_copy(update={"sensitivity": None}), SCENES) == {}
    assert studied_scenes(config(), SCENES) == SCENES
    assert studied_scenes(config(scenes=["orbit_1"]), SCENES) == {"orbit": ["orbit_1"]}
    assert studied_methods(config(), "orbit") == ("random",)


def test_a_data_set_without_such_a_table_or_method_is_left_out():
    assert studied_scenes(config({"hall": {"tables": ["coverage"]}}), SCENES) == {"orbit": SCENES["orbit"]}
    assert studied_scenes(config(methods=["farthest"]), SCENES) == {}


def test_a_scene_that_is_not_evaluated_is_one_line():
    with pytest.raises(UserError, match=r"sensitivity\.scenes: attic is not evaluated; name some of hall_0, orbit_0"):
        studied_scenes(config(scenes=["attic"]), SCENES)

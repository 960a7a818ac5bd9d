"""A data set that is not there keeps no other from its tables; what names its scenes goes with it, with the reason."""

import pytest

from avs.config.configuration import load
from avs.config.lost_data_sets import without_lost
from avs.config.scenes import scenes_of
from avs.system.errors import UserError
from tests.config.test_scenes import values

GONE = {"source": "captures", "folder": "nowhere"}


def test_of_two_data_sets_the_one_that_is_there_goes_on():
    changed = values()
    changed["datasets"]["mine"] = GONE
    config, lost = without_lost(load(changed))
    assert lost == {"mine": "nowhere: there is no such folder; give the folder that holds your captures"}
    assert "mine" not in scenes_of(config)
    assert config == load(values())


def test_what_names_a_scene_of_it_goes_with_it_and_all_else_stays():
    changed = values()
    changed["datasets"]["mine"] = GONE
    changed["runtime"] = {"scene": "garden"}
    changed["coverage"] = (changed["coverage"] or {}) | {"scene": "mine/garden"}
    changed["sensitivity"] |= {"scenes": ["orbit_0", "garden"]}
    changed["agnostic"] |= {"datasets": ["mine"]}
    config, lost = without_lost(load(changed))
    assert set(lost) == {"mine", "runtime", "coverage.scene", "agnostic"}
    assert lost["runtime"] == "its scene garden is none of those that are there"
    assert (config.runtime, config.agnostic, config.coverage.scene) == (None, None, None)
    assert config.sensitivity.scenes == ("orbit_0",)


def test_named_scenes_that_are_there_stay():
    changed = values()
    changed["datasets"]["mine"] = GONE
    changed["runtime"] = {"scene": "orbit/orbit_0"}
    config, lost = without_lost(load(changed))
    assert (set(lost), config.runtime.scene) == ({"mine"}, "orbit/orbit_0")


def test_where_nothing_is_there_the_line_stays_an_error():
    config = load(values(scenes_dir="nowhere"))
    assert without_lost(config) == (config, {})
    with pytest.raises(UserError, match="nowhere: there is no such folder"):
        scenes_of(config)
    changed = values()
    changed["datasets"]["handheld_training"] = GONE
    with pytest.raises(UserError, match="nowhere: there is no such folder"):
        scenes_of(without_lost(load(changed))[0])

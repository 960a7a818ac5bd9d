"""Back ends by name, and views that none of them could use."""

import numpy as np
import pytest
from factories import named_views, ring
from pydantic import TypeAdapter

from avs.scene.cameras import Cameras
from avs.sfm import back_end_registry as registry
from avs.system.errors import UserError

PICTURE = np.zeros((16, 24, 3), dtype=np.uint8)


def test_back_ends_are_found_by_their_files():
    assert set(registry.back_ends()) == {"colmap", "da3", "dense", "mapanything", "mast3r", "vggt"}
    for name, back_end in registry.back_ends().items():
        assert back_end.settings().back_end == name
        assert back_end.module.endswith(name)


def test_a_back_end_that_does_not_work_leaves_the_others(tmp_path, monkeypatch):
    (tmp_path / "some_back_ends").mkdir()
    for name, text in {
        "__init__": "",
        "broken": "1 / 0",
        "dense": "from avs.sfm.back_ends.dense import BACK_END",
    }.items():
        (tmp_path / "some_back_ends" / f"{name}.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(registry, "PACKAGE", "some_back_ends")
    found = registry._found.__wrapped__()
    monkeypatch.setattr(registry, "_found", lambda: found)
    assert list(registry.back_ends()) == ["dense"]
    assert registry.broken().keys() == {"some_back_ends.broken"}
    with pytest.raises(UserError, match=r"'broken' of structure from motion: is left out: .*ZeroDivisionError"):
        registry.find("broken")


def test_settings_name_their_back_end():
    assert registry.create_settings({}).back_end == "dense"
    assert registry.create_settings({"back_end": "colmap", "poses": "free"}).poses == "free"
    with pytest.raises(UserError, match="did you mean dense"):
        registry.create_settings({"back_end": "dens"})
    with pytest.raises(UserError, match=r"sfm\.stereo\.planes"):
        registry.create_settings({"stereo": {"planes": 17}})
    with pytest.raises(UserError, match="did you mean colmap"):
        registry.find("colma")


def test_the_schema_lists_all_back_ends():
    schema = TypeAdapter(registry.AnyBackEndSettings).json_schema()
    assert set(schema["discriminator"]["mapping"]) == set(registry.back_ends())


@pytest.mark.parametrize(
    ("cameras", "images", "fault"),
    [
        (ring(1), [PICTURE], "at least two"),
        (ring(2), [PICTURE, PICTURE[:8]], "has 24 x 16 pixels"),
        (ring(2), [PICTURE, PICTURE.astype(float)], "is float64"),
        (ring(3)[[0, 0]], [PICTURE] * 2, "in one place"),
    ],
)
def test_views_that_nothing_can_be_made_of_are_one_line(cameras, images, fault):
    with pytest.raises(UserError, match=fault):
        registry.reconstruct(named_views(cameras, images), registry.create_settings({}), "episode 1")


def test_a_view_twice_is_one_line():
    views = named_views(ring(3), [PICTURE] * 3)
    with pytest.raises(UserError, match=r"episode 1: view 000\.png is there twice"):
        registry.reconstruct(views[[0, 1, 0]], registry.create_settings({}), "episode 1")


def test_poses_hold_numbers():
    cameras = ring(2)
    cameras.world_to_camera[0, 0, 3] = np.nan
    with pytest.raises(ValueError, match="NaN"):
        Cameras(cameras.world_to_camera, cameras.intrinsics, cameras.sizes)


def test_another_version_is_one_line(monkeypatch):
    monkeypatch.setattr(registry, "_version", lambda project: "3.12.0")
    for name in ("dense", "colmap"):
        lacking = registry.why_not(registry.create_settings({"back_end": name}))
        assert lacking.cause == "pycolmap is installed in version 3.12.0, not 4.2"
        assert lacking.remedy == "pip install pycolmap==4.2.1"
    with pytest.raises(UserError, match=r"back end dense: pycolmap is installed in version 3\.12\.0"):
        registry.reconstruct(named_views(ring(2), [PICTURE] * 2), registry.create_settings({}), "episode 1")

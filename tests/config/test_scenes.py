"""The scenes of a run: listed by data set, none used twice, captures in place of what is evaluated."""

import json

import numpy as np
import pytest
import yaml
from factories import small_scene

from avs.config.configuration import load
from avs.config.jobs import settings_of
from avs.config.scenes import scenes_of
from avs.system.errors import UserError
from tests.workflow.project import ROOT


def values(name="ci", **changes):
    return yaml.safe_load((ROOT / "workflows" / "config" / f"{name}.yaml").read_text()) | changes


def embedded(pattern, *seeds):
    return {"source": "embedded", "pattern": pattern, "seeds": list(seeds)}


@pytest.fixture
def captures(tmp_path):
    for number, name in enumerate(("one", "two")):
        small_scene(tmp_path / "captures" / name, count=16, name=name, darkest=40 + number)
    return str(tmp_path / "captures")


def test_every_data_set_has_its_scenes_in_order():
    changed = values()
    changed["datasets"] |= {"near": embedded("orbit", 3, 1), "far": embedded("walkthrough", 1)}
    config = load(changed)
    listed = scenes_of(config)
    assert config.evaluated == ("orbit", "walkthrough", "handheld", "egocentric", "near", "far")
    assert list(listed["near"]) == ["orbit_3", "orbit_1"]
    assert list(listed["handheld_training"]) == ["handheld_100", "handheld_101", "handheld_102", "handheld_103"]


@pytest.mark.parametrize(
    ("name", "seed", "line"),
    [
        ("street", 100, "one is for training scorers, the other evaluated"),
        ("street", 106, "one is for measuring scorers, the other evaluated"),
        ("handheld_held_out", 100, "one is for training scorers, the other for measuring scorers"),
        ("handheld_held_out", 111, "both are for measuring scorers, where it would count twice"),
    ],
)
def test_a_scene_has_one_use(name, seed, line):
    changed = values()
    changed["datasets"][name] = embedded("handheld", seed) | {"capture": {"views": 16}}
    with pytest.raises(UserError, match=f"handheld_{seed} of .*: is the scene handheld_{seed} of .*: {line}") as caught:
        scenes_of(load(changed))
    assert "\n" not in str(caught.value)


def test_a_copy_of_a_capture_has_one_use_too(tmp_path):
    changed = values()
    for name in ("studied", "tested"):
        small_scene(tmp_path / name / name, count=16, name=name)
        changed["datasets"][name] = {"source": "captures", "folder": str(tmp_path / name)}
    changed["distortions"] |= {"training": ["studied"], "representations": {}}
    line = "tested of tested: is the scene studied of studied: one is for training scorers, the other evaluated"
    with pytest.raises(UserError, match=line):
        scenes_of(load(changed))


def test_a_photograph_has_one_use_too(tmp_path):
    """As in a copy that lacks some of them, or that has others beside."""
    changed = values()
    for name in ("studied", "tested"):
        small_scene(tmp_path / name / name, count=16, name=name)
        changed["datasets"][name] = {"source": "captures", "folder": str(tmp_path / name)}
    changed["distortions"] |= {"training": ["studied"], "representations": {}}
    images = sorted((tmp_path / "studied" / "studied" / "images").iterdir())
    for path in images[3:]:
        path.write_bytes(path.read_bytes() + bytes(8))
    images[0].rename(images[0].with_name("other.png"))
    line = (
        r"tested of tested: shares 000.png, 001.png, 002.png with the scene studied of studied: "
        "one is for training scorers, the other evaluated"
    )
    with pytest.raises(UserError, match=line):
        scenes_of(load(changed))
    for path in images[1:3]:
        path.unlink()
    (tmp_path / "studied" / "studied" / "images" / "other.png").unlink()
    scenes_of(load(changed))


def test_parts_of_one_video_have_one_use(tmp_path):
    """They show the same house: a scorer that was trained on one has seen the other."""
    changed = values()
    row = " ".join(["0.9", "1.6", "0.5", "0.5", "0", "0", *map(str, np.eye(4)[:3].ravel())])
    for number, (name, video) in enumerate({"studied": "house", "tested": "house", "third": "other"}.items()):
        (tmp_path / name).mkdir()
        lines = [f"https://www.youtube.com/watch?v={video}", *(f"{number + time} {row}" for time in (1000, 2000))]
        (tmp_path / name / f"{name}.txt").write_text("\n".join(lines))
        (tmp_path / "videos").mkdir(exist_ok=True)
        (tmp_path / "videos" / f"{video}.mp4").touch()
        folders = {"folder": str(tmp_path / name), "videos": str(tmp_path / "videos")}
        changed["datasets"][name] = {"source": "realestate10k"} | folders
    changed["distortions"] |= {"training": ["studied"], "representations": {}}
    line = "tested of tested: is a part of the same video as the scene studied of studied: one is for training scorers"
    with pytest.raises(UserError, match=line):
        scenes_of(load(changed))
    del changed["datasets"]["tested"]
    scenes_of(load(changed))


def test_one_folder_read_by_two_readers_has_one_use_too(tmp_path):
    """Where each reader takes other pictures of it: the second lists two of the sixteen."""
    folder = tmp_path / "both" / "garden"
    small_scene(folder, count=16, name="garden")
    frames = [{"file_path": f"images/{number:03d}.png", "transform_matrix": np.eye(4).tolist()} for number in range(2)]
    shared = {"fl_x": 9, "fl_y": 9, "cx": 9, "cy": 9, "w": 9, "h": 9}
    (folder / "transforms.json").write_text(json.dumps(shared | {"frames": frames}))
    changed = values()
    changed["datasets"] |= {
        "studied": {"source": "nerfstudio", "folder": str(tmp_path / "both"), "axes": "opengl"},
        "tested": {"source": "captures", "folder": str(tmp_path / "both")},
    }
    changed["distortions"] |= {"training": ["studied"], "representations": {}}
    line = "garden of tested: is the scene garden of studied: one is for training scorers, the other evaluated"
    with pytest.raises(UserError, match=line):
        scenes_of(load(changed))


def test_a_scene_stays_as_it_is_when_another_is_added():
    changed = values()
    before = settings_of(load(changed), "scene/orbit/orbit_0")
    changed["datasets"]["orbit"] |= {"seeds": [0, 1, 2], "published": "mipnerf360"}
    assert settings_of(load(changed), "scene/orbit/orbit_0") == before


def test_a_data_set_names_its_published_values():
    changed = values()
    changed["datasets"] |= {"rooms": embedded("walkthrough", 0) | {"published": "realestate10k"}}
    assert settings_of(load(changed), "nvs_table/rooms").published == "results/published/nvs_realestate10k.csv"
    assert settings_of(load(changed), "nvs_table/orbit").published == "results/published/nvs_mipnerf360.csv"


def test_scenes_dir_stands_in_place_of_what_is_evaluated(captures):
    config = load(values(scenes_dir=captures))
    listed = scenes_of(config)
    assert config.evaluated == ("captures",)
    scorers = config.distortions.datasets
    assert set(listed) == {*scorers, "captures"}
    assert list(listed["captures"]) == ["one", "two"]
    assert {path.name for path in listed["captures"]["one"].files()} >= {"cameras.bin", "000.png"}


def test_captures_are_prepared_as_the_configuration_says(captures):
    config = load(values("paper", scenes_dir=captures))
    assert {settings.long_side for settings in scenes_of(config)["captures"].values()} == {1600}


def test_a_folder_that_cannot_be_a_scene_is_told_in_the_table_and_keeps_no_other_from_it(captures, tmp_path):
    (tmp_path / "captures" / "three").symlink_to("two")
    config = load(values(scenes_dir=captures))
    assert list(scenes_of(config)["captures"]) == ["one", "two"]
    told = settings_of(config, "nvs_table/captures").left_out
    assert {name: reason.cause for name, reason in told.items()} == {"three": "is the same folder as two"}


def test_a_capture_may_be_called_like_an_embedded_scene(tmp_path):
    small_scene(tmp_path / "handheld_100", count=16, name="handheld_100")
    listed = scenes_of(load(values(scenes_dir=str(tmp_path))))
    assert list(listed["captures"]) == ["handheld_100"]
    assert "handheld_100" in listed["handheld_training"]


def test_what_is_transparent_lies_on_the_background_of_the_representation_unless_the_data_set_names_one(captures):
    changed = values(scenes_dir=captures)
    changed["representation"]["background"] = [0.25, 0.5, 1.0]
    assert settings_of(load(changed), "scene/captures/one").scene.background == (0.25, 0.5, 1.0)
    changed["datasets"]["captures"] = {"source": "captures", "background": [1, 1, 1]}
    assert settings_of(load(changed), "scene/captures/one").scene.background == (1, 1, 1)


def test_a_scene_is_told_what_the_reconstruction_needs_of_its_points(captures):
    changed = values(scenes_dir=captures)
    changed["representation"]["points"] = {"choice": "selected", "selected_min_views": 2}
    assert settings_of(load(changed), "scene/captures/one").points.views == 2
    changed["representation"]["points"] = {"choice": "random"}
    assert settings_of(load(changed), "scene/captures/one").points is None


def test_captures_may_have_a_folder_and_any_name(captures):
    changed = values()
    changed["datasets"]["mine"] = {"source": "captures", "folder": captures, "long_side": 100}
    assert list(scenes_of(load(changed))["mine"]) == ["one", "two"]


def test_captures_of_the_papers_name_stand_beside_its_values(captures):
    """In the place of the captures that the scale expects of scenes_dir; another name has no published values."""
    changed = values("paper")
    changed["datasets"] |= {"mipnerf360": {"source": "captures", "folder": captures, "long_side": 1600}}
    config = load(changed)
    assert config.evaluated == ("mipnerf360",)
    assert settings_of(config, "nvs_table/mipnerf360").published == "results/published/nvs_mipnerf360.csv"
    assert settings_of(load(values("paper", scenes_dir=captures)), "nvs_table/captures").published is None


@pytest.mark.parametrize(
    ("changed", "line"),
    [
        (values("small"), "captures: no folder is given; add --config scenes_dir=DIR, or name a folder"),
        (
            values(datasets={"a": embedded("orbit", 0), "b": embedded("orbit", 1)})
            | {"distortions": {"training": ["a"], "held_out": ["b"]}},
            "configuration: datasets: no data set is evaluated; add one, or --config scenes_dir=DIR",
        ),
        (values("small", scenes_dir="nowhere"), "nowhere: there is no such folder"),
    ],
)
def test_a_run_without_scenes_is_one_line(changed, line):
    with pytest.raises(UserError, match=line):
        scenes_of(load(changed))


def test_a_data_set_called_captures_cannot_hide_those_of_scenes_dir():
    changed = values(scenes_dir="anywhere")
    changed["datasets"]["captures"] = embedded("orbit", 0)
    with pytest.raises(UserError, match=r"datasets\.captures: is the name of what scenes_dir gives"):
        load(changed)

"""Mip-NeRF360 as a data set, and the configurations of the paper's data sets."""

import shutil
from pathlib import Path

import pytest
import yaml
from PIL import Image

from avs.config.configuration import load
from avs.datasets.mipnerf360 import SCENES, MipNerf360
from avs.scene.scene import read_scene
from avs.system.errors import UserError
from tests.datasets.captures_factory import make_capture

CONFIG = Path(__file__).parents[2] / "workflows" / "config"


def make(folder):
    """A scene of the archive's layout, with the smaller copies beside the full images."""
    make_capture(folder)
    for factor in (2, 4, 8):
        (folder / f"images_{factor}").mkdir()
        for path in (folder / "images").iterdir():
            with Image.open(path) as image:
                image.resize((image.width // factor, image.height // factor)).save(
                    folder / f"images_{factor}" / path.name
                )
    (folder / "poses_bounds.npy").touch()


def test_the_full_images_are_read_and_missing_scenes_named(tmp_path):
    for name in ("garden", "bicycle"):
        make(tmp_path / "data" / name)
    path = next((tmp_path / "data" / "garden" / "images").iterdir())
    Image.new("RGB", (160, 120)).save(path)  # not a copy of the other scene
    reader = MipNerf360(folder=str(tmp_path / "data"), long_side=150)
    assert list(reader.scenes()) == ["bicycle", "garden"]
    assert reader.left_out().keys() == set(SCENES) - {"bicycle", "garden"}
    assert {path.parent.name for path in reader.scenes()["garden"].files()} == {"images", "0"}
    reader.scenes()["bicycle"].prepare("mipnerf360", tmp_path / "bicycle")
    scene = read_scene(tmp_path / "bicycle")
    assert tuple(scene.cameras.sizes[0]) == (150, 112)
    assert list(scene.test) == [0, 8]


def test_smaller_copies_in_place_of_the_full_images_are_refused(tmp_path):
    make(tmp_path / "data" / "garden")
    shutil.rmtree(tmp_path / "data" / "garden" / "images")
    (tmp_path / "data" / "garden" / "images_4").rename(tmp_path / "data" / "garden" / "images")
    reader = MipNerf360(folder=str(tmp_path / "data"), long_side=100)
    with pytest.raises(
        UserError, match=r"is 40x30 pixels, but its camera 160x120: a smaller copy; put the full images"
    ):
        reader.scenes()["garden"].prepare("mipnerf360", tmp_path / "garden")


def test_the_defaults_are_the_paper_s():
    reader = MipNerf360(folder=".")
    assert (reader.long_side, reader.test_every, reader.resample, len(reader.only)) == (1600, 8, "pil", 9)


@pytest.mark.parametrize("name", sorted(path.stem for path in (CONFIG / "datasets").glob("*.yaml")))
def test_the_configuration_of_each_data_set_is_valid_beside_the_paper_s(name):
    values = yaml.safe_load((CONFIG / "paper.yaml").read_text())
    own = yaml.safe_load((CONFIG / "datasets" / f"{name}.yaml").read_text())
    values["datasets"] |= own["datasets"]
    values["distortions"] |= own.get("distortions", {})
    config = load(values)
    assert config.datasets[name].folder
    assert (name in config.evaluated) != name.endswith("_training")

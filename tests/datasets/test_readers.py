"""Readers are found by name, and each gives its scenes without reading one."""

import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from captures_factory import make_capture

from avs.datasets import reader_registry
from avs.datasets.captures import Captures
from avs.datasets.embedded import EmbeddedScenes, PatternName
from avs.datasets.embedded.capture import PATTERNS
from avs.datasets.folder_reader import FolderReader
from avs.datasets.reader_registry import readers
from avs.scene.scene import read_scene
from avs.system.errors import UserError

ROOT = Path(__file__).parents[2]
QUICK = {"views": 16, "long_side": 48, "texture_levels": 6, "gather_rays": 8, "bounces": 0, "points": 200}


def test_each_reader_has_the_name_of_its_source():
    assert {name: reader.__module__ for name, reader in readers().items()} == {
        name: f"avs.datasets.{name}"
        for name in (
            "aria_dtc",
            "captures",
            "embedded",
            "llff",
            "map_free",
            "mipnerf360",
            "nerfstudio",
            "realestate10k",
        )
    }


def test_a_reader_that_does_not_work_leaves_the_others(tmp_path, monkeypatch):
    folder = tmp_path / "some_readers"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "broken.py").write_text("import no_such_package")
    (folder / "captures.py").write_text("from avs.datasets.captures import READER")
    (folder / "captures_again.py").write_text("from avs.datasets.captures import READER")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(reader_registry, "PACKAGE", "some_readers")
    found, broken = reader_registry._found.__wrapped__()
    assert found == {"captures": Captures}
    assert broken.keys() == {"some_readers.broken", "some_readers.captures_again"}
    assert "no_such_package" in broken["some_readers.broken"]
    assert "as avs.datasets.captures does" in broken["some_readers.captures_again"]


def test_every_pattern_can_be_named():
    assert set(get_args(PatternName)) == PATTERNS.keys()


def test_finding_readers_imports_no_heavy_library():
    heavy = ("torch", "open3d", "pycolmap", "numba", "skimage", "scipy")
    code = (
        "import sys; from avs.datasets.reader_registry import readers; readers();"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_a_scene_belongs_to_the_data_set_that_the_configuration_names(tmp_path):
    settings = EmbeddedScenes(pattern="orbit", seeds=(4, 2), capture=QUICK)
    settings.scenes()["orbit_2"].prepare("small_orbits", tmp_path / "orbit_2")
    make_capture(tmp_path / "captures" / "A b")
    captures = Captures(folder=str(tmp_path / "captures"), long_side=None)
    captures.scenes()["a_b"].prepare("mine", tmp_path / "a_b")
    made = [read_scene(tmp_path / name) for name in ("orbit_2", "a_b")]
    assert [(scene.name, scene.dataset) for scene in made] == [("orbit_2", "small_orbits"), ("a_b", "mine")]


def test_scenes_are_told_apart_by_what_they_show():
    one, other = (
        EmbeddedScenes(pattern="orbit", seeds=(0, 1), capture={"views": views}).scenes() for views in (16, 32)
    )
    assert one["orbit_0"].identities() == other["orbit_0"].identities() != one["orbit_1"].identities()


def test_a_folder_is_one_scene_whichever_reader_takes_it(tmp_path):
    make_capture(tmp_path / "garden")
    (tmp_path / "link").symlink_to(tmp_path / "garden")
    kinds = {name: kind for name, kind in readers().items() if issubclass(kind, FolderReader)}
    assert len(kinds) == 7
    for folder in ("garden", "link"):
        own = {"folder": str(tmp_path / folder), "axes": "opengl", "videos": "none"}
        told = {
            name: kind(**{key: value for key, value in own.items() if key in kind.model_fields})
            for name, kind in kinds.items()
            if name != "realestate10k"
        }
        assert {each.identities()[0] for each in told.values()} == {("place", str(tmp_path.resolve() / "garden"))}


@pytest.mark.parametrize("seeds", [(1, 1), (-1,), ()])
def test_seeds_are_different_numbers(seeds):
    with pytest.raises(ValueError, match="seeds"):
        EmbeddedScenes(pattern="orbit", seeds=seeds)


def test_captures_without_a_folder_are_refused():
    with pytest.raises(UserError, match="no folder is given; add --config scenes_dir=DIR"):
        Captures().scenes()

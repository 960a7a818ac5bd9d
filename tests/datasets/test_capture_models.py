"""Which of several models is read, and models that programs other than COLMAP have written or changed."""

import shutil

import numpy as np
import pycolmap
import pytest
from captures_factory import make_capture

from avs.datasets.capture_models import choose_model
from avs.datasets.capture_settings import CaptureSettings
from avs.datasets.captures import prepare
from avs.scene.scene import read_scene
from avs.system.errors import UserError


def prepared(tmp_path):
    prepare(tmp_path / "capture", tmp_path / "toy", CaptureSettings(long_side=None))
    return read_scene(tmp_path / "toy")


def keep_images(folder, count):
    """Leave a model with its first images."""
    model = pycolmap.Reconstruction(folder)
    for identifier in sorted(model.images)[count:]:
        model.deregister_frame(model.images[identifier].frame_id)
    model.write(folder)


@pytest.fixture
def several(tmp_path):
    """A capture whose sparse/0 has 4 of 9 images; sparse/1 and sparse/10 have all."""
    make_capture(tmp_path / "capture")
    sparse = tmp_path / "capture" / "sparse"
    for name in ("1", "10"):
        shutil.copytree(sparse / "0", sparse / name)
    keep_images(sparse / "0", 4)
    return tmp_path / "capture"


def test_the_largest_model_is_used_and_the_choice_is_told(several, tmp_path):
    scene = prepared(tmp_path)
    assert len(scene.names) == 9
    told = "of several models sparse/1 is used: sparse/0 has 4 images, sparse/1 has 9 images, sparse/10 has 9 images"
    assert told in scene.notes


def test_of_equal_models_the_first_is_used(several):
    shutil.rmtree(several / "sparse" / "0")
    assert choose_model(several).folder == several / "sparse" / "1"


def test_one_damaged_model_of_several_is_told(several):
    (several / "sparse" / "10" / "images.bin").write_bytes(b"")
    with pytest.raises(UserError, match=r"sparse/10/images\.bin: is damaged"):
        choose_model(several)


@pytest.mark.parametrize("place", ["sparse", "colmap/sparse/0", "sparse/2"])
def test_a_model_is_found_where_other_programs_keep_it(place, tmp_path):
    make_capture(tmp_path / "capture")
    shutil.move(tmp_path / "capture" / "sparse" / "0", tmp_path / "model")
    (tmp_path / "capture" / "sparse").rmdir()
    (tmp_path / "capture" / place).parent.mkdir(parents=True, exist_ok=True)
    shutil.move(tmp_path / "model", tmp_path / "capture" / place)
    scene = prepared(tmp_path)
    assert len(scene.names) == 9
    assert scene.notes == ()


def test_observations_of_removed_points_are_left_out_and_counted(tmp_path):
    make_capture(tmp_path / "capture")
    before = prepared(tmp_path)
    cloud = tmp_path / "capture" / "sparse" / "0" / "points3D.bin"
    model = pycolmap.Reconstruction(cloud.parent)
    track = sum(len(model.points3D[identifier].track.elements) for identifier in (1, 5))
    for identifier in (1, 5):
        model.delete_point3D(identifier)
    model.write(tmp_path)
    shutil.copy(tmp_path / "points3D.bin", cloud)  # the cloud alone, as after cleaning it
    scene = prepared(tmp_path)
    assert len(scene.points) == len(before.points) - 2
    assert f"{track} of 108 observations are left out: they are of points that the model does not hold" in scene.notes
    removed = np.isin(before.points.observations[:, 0], [0, 4])
    assert len(scene.points.observations) == (~removed).sum()


@pytest.mark.parametrize("form", ["utf-8-sig", "crlf"])
def test_a_text_model_of_another_editor_is_read(form, tmp_path):
    make_capture(tmp_path / "capture", text=True)
    before = prepared(tmp_path)
    for path in (tmp_path / "capture" / "sparse" / "0").glob("*.txt"):
        text = path.read_text().replace("\n", "\r\n" if form == "crlf" else "\n")
        path.write_bytes(text.encode("utf-8-sig"))
    assert prepared(tmp_path).content_hash == before.content_hash


def test_a_text_model_may_write_no_point_as_an_unsigned_number(tmp_path):
    make_capture(tmp_path / "capture", text=True)
    path = tmp_path / "capture" / "sparse" / "0" / "images.txt"
    lines = path.read_text().splitlines()
    row = next(number for number, line in enumerate(lines) if not line.startswith("#")) + 1
    fields = lines[row].split()
    fields[2] = str(2**64 - 1)
    lines[row] = " ".join(fields)
    path.write_text("\n".join(lines) + "\n")
    assert "the model does not hold" not in str(prepared(tmp_path).notes)


def test_points_without_tracks_are_noted(tmp_path):
    make_capture(tmp_path / "capture", text=True)
    path = tmp_path / "capture" / "sparse" / "0" / "images.txt"
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    path.write_text("".join(f"{line}\n\n" for line in lines[::2]))
    scene = prepared(tmp_path)
    assert scene.notes == ("no image observes a point of the model",)
    assert len(scene.points) == 12


@pytest.mark.parametrize(
    ("change", "note"),
    [
        (lambda model: None, None),
        (
            lambda model: model.transform(pycolmap.Sim3d(2.0, pycolmap.Rotation3d(), np.zeros(3))),
            "images or poses, points",
        ),
        (lambda model: setattr(model.cameras[1], "width", 999), "cameras"),
    ],
)
def test_a_text_form_that_is_another_model_is_told(change, note, tmp_path):
    make_capture(tmp_path / "capture")
    folder = tmp_path / "capture" / "sparse" / "0"
    model = pycolmap.Reconstruction(folder)
    change(model)
    model.write_text(folder)
    said = "sparse/0: the .bin files are used; those of .txt beside them have other "
    assert choose_model(tmp_path / "capture").notes == ([] if note is None else [said + note])


def test_a_text_form_that_cannot_be_read_is_told(tmp_path):
    make_capture(tmp_path / "capture")
    folder = tmp_path / "capture" / "sparse" / "0"
    pycolmap.Reconstruction(folder).write_text(folder)
    (folder / "images.txt").write_text("1 2 3")
    said = "sparse/0: the .bin files are used; those of .txt beside them cannot be read"
    assert choose_model(tmp_path / "capture").notes == [said]

"""Clouds on disk."""

import numpy as np
import pytest
from factories import with_one_bit_flipped
from plyfile import PlyData

from avs.sfm.cloud import Cloud, empty_cloud
from avs.sfm.cloud_file import read_cloud, write_cloud
from avs.system.errors import UserError


def some_cloud(count=5):
    rng = np.random.default_rng(0)
    positions = rng.normal(size=(count, 3)).astype(np.float32).astype(np.float64)
    colors = rng.integers(0, 256, (count, 3), dtype=np.uint8)
    return Cloud(positions, colors, rng.uniform(size=count).astype(np.float32))


@pytest.mark.parametrize("cloud", [some_cloud(), empty_cloud()])
def test_what_was_written_is_read(cloud, tmp_path):
    distance = np.arange(len(cloud), dtype=np.float32)
    write_cloud(tmp_path / "a.ply", cloud, {"distance": distance})
    read, fields = read_cloud(tmp_path / "a.ply", "make it again")
    for name in ("positions", "colors", "confidence"):
        np.testing.assert_array_equal(getattr(read, name), getattr(cloud, name))
        assert getattr(read, name).dtype == getattr(cloud, name).dtype
    np.testing.assert_array_equal(fields["distance"], distance)
    write_cloud(tmp_path / "b.ply", read, fields)
    assert (tmp_path / "b.ply").read_bytes() == (tmp_path / "a.ply").read_bytes()


def test_another_program_reads_the_same(tmp_path):
    cloud = some_cloud()
    write_cloud(tmp_path / "a.ply", cloud, {"distance": cloud.confidence})
    vertices = PlyData.read(tmp_path / "a.ply")["vertex"]
    np.testing.assert_array_equal(np.stack([vertices[axis] for axis in "xyz"], axis=1), cloud.positions)
    np.testing.assert_array_equal(vertices["green"], cloud.colors[:, 1])
    np.testing.assert_array_equal(vertices["distance"], cloud.confidence)


def test_every_damaged_byte_is_seen(tmp_path):
    path = tmp_path / "a.ply"
    write_cloud(path, some_cloud(2))
    content = path.read_bytes()
    for damaged in [*with_one_bit_flipped(content), content[:-1], content + b"x", b""]:
        path.write_bytes(damaged)
        with pytest.raises(UserError, match="make it again"):
            read_cloud(path, "make it again")


def test_a_missing_file_is_one_line(tmp_path):
    with pytest.raises(UserError, match="no such file"):
        read_cloud(tmp_path / "a.ply", "make it again")


def test_fields_that_do_not_fit_are_refused(tmp_path):
    for fields in ({"x": np.zeros(5, np.float32)}, {"distance": np.zeros(4, np.float32)}):
        with pytest.raises(ValueError, match="does not fit"):
            write_cloud(tmp_path / "a.ply", some_cloud(), fields)


def test_a_cloud_holds_numbers():
    with pytest.raises(ValueError, match="NaN"):
        Cloud(np.full((1, 3), np.nan), np.zeros((1, 3), np.uint8), np.zeros(1, np.float32))
    with pytest.raises(ValueError, match="shape"):
        Cloud(np.zeros((1, 3)), np.zeros((2, 3), np.uint8), np.zeros(1, np.float32))

import numpy as np
import pytest
import torch
from plyfile import PlyData

from avs.representations.gaussians.ply import read_ply, write_ply
from avs.system.errors import UserError


def gaussians(count=7, coefficients=16):
    generator = torch.Generator().manual_seed(1)
    shapes = {"means": (3,), "scales": (3,), "quats": (4,), "opacities": (), "sh": (coefficients, 3)}
    return {name: torch.randn(count, *shape, generator=generator) for name, shape in shapes.items()}


@pytest.mark.parametrize("coefficients", [1, 4, 9, 16])
def test_round_trip_is_exact(tmp_path, coefficients):
    written = gaussians(coefficients=coefficients)
    write_ply(tmp_path / "splats.ply", written)
    read = read_ply(tmp_path / "splats.ply")
    assert read.keys() == written.keys()
    assert all(torch.equal(read[name], written[name]) for name in written)


def test_layout_is_that_of_the_3dgs_code(tmp_path):
    written = gaussians()
    write_ply(tmp_path / "splats.ply", written)
    data = PlyData.read(tmp_path / "splats.ply")
    names = [prop.name for prop in data["vertex"].properties]
    expected = ["x", "y", "z", "nx", "ny", "nz", *(f"f_dc_{i}" for i in range(3)), *(f"f_rest_{i}" for i in range(45))]
    assert names == [*expected, "opacity", *(f"scale_{i}" for i in range(3)), *(f"rot_{i}" for i in range(4))]
    assert (data.text, data.byte_order) == (False, "<")
    # f_rest is channel first: the 15 coefficients of red, then of green, then of blue.
    np.testing.assert_array_equal(data["vertex"]["f_rest_15"], written["sh"][:, 1, 1])
    np.testing.assert_array_equal(data["vertex"]["f_rest_1"], written["sh"][:, 2, 0])


def test_damaged_files_are_refused(tmp_path):
    path = tmp_path / "splats.ply"
    with pytest.raises(UserError, match="cannot be read"):
        read_ply(path)
    write_ply(path, gaussians())
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) - 100])
    with pytest.raises(UserError, match=r"splats\.ply: cannot be read"):
        read_ply(path)
    path.write_bytes(b"not a ply file")
    with pytest.raises(UserError, match="cannot be read"):
        read_ply(path)
    path.write_bytes(whole.replace(b"property float opacity", b"property float opacitx"))
    with pytest.raises(UserError, match="lacks the properties opacity"):
        read_ply(path)


def test_nan_is_refused(tmp_path):
    broken = gaussians()
    broken["scales"][3, 1] = float("nan")
    write_ply(tmp_path / "splats.ply", broken)
    with pytest.raises(UserError, match="NaN"):
        read_ply(tmp_path / "splats.ply")

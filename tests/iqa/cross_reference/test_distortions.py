from dataclasses import replace

import numpy as np
import pytest
import safetensors.numpy

from avs.iqa.cross_reference.distortions import coded, decoded, read_distortions, write_distortions
from avs.system.errors import UserError


def test_code_keeps_ssim_to_a_thirty_thousandth_and_clips_it():
    similarity = np.array([[-1.0, -0.2, 0.0], [0.123456, 0.9999, 1.0]])
    np.testing.assert_allclose(decoded(coded(similarity)), similarity.clip(0, 1), atol=1 / 32767)


def test_written_data_are_read_again(toys, tmp_path):
    path = tmp_path / "renders.safetensors"
    write_distortions(path, toys[0])
    read = read_distortions(path)
    assert (read.scene, read.scene_hash, read.moments) == (toys[0].scene, toys[0].scene_hash, toys[0].moments)
    assert (read.images, read.moment_of) == (toys[0].images, toys[0].moment_of)
    np.testing.assert_array_equal(read.geometry, toys[0].geometry)
    np.testing.assert_array_equal(read.centers, toys[0].centers)
    for name in ("photographs", "renderings", "maps"):
        for own, other in zip(getattr(read, name), getattr(toys[0], name), strict=True):
            np.testing.assert_array_equal(own, other)


def test_equal_data_give_equal_bytes(toys, tmp_path):
    for name in ("a", "b"):
        write_distortions(tmp_path / name, toys[0])
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


@pytest.mark.parametrize("name", ["geometry", "centers"])
def test_numbers_that_are_not_finite_or_too_few_are_refused(name, toys, tmp_path):
    right = getattr(toys[0], name)
    for wrong in (right[1:], np.where(right == right[0, 0], np.nan, right)):
        write_distortions(tmp_path / "renders", replace(toys[0], **{name: wrong}))
        with pytest.raises(UserError, match="do not fit together"):
            read_distortions(tmp_path / "renders")


def test_bad_files_are_refused_with_one_line(toys, tmp_path):
    good = tmp_path / "good"
    write_distortions(good, toys[0])
    files = {"truncated": good.read_bytes()[:5000], "no_safetensors": b"PK\x03\x04" * 100, "empty": b""}
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    safetensors.numpy.save_file({"x": np.zeros(3)}, tmp_path / "foreign")
    for name in (*files, "foreign", "absent"):
        with pytest.raises(UserError, match=name) as caught:
            read_distortions(tmp_path / name)
        assert "\n" not in str(caught.value)

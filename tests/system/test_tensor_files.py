"""Arrays in safetensors files: the bytes that safetensors itself writes, and a file that others may read."""

import hashlib

import numpy as np
import pytest
import safetensors
import safetensors.torch
import torch
from factories import with_one_bit_flipped

from avs.system.errors import UserError
from avs.system.files import canonical_json
from avs.system.tensor_files import read_tensors, write_tensors


def test_the_bytes_are_those_of_the_tensors_and_one_canonical_entry(tmp_path):
    tensors = {
        "scalar": torch.tensor(3),
        "floats": torch.rand(3, 4, generator=torch.Generator().manual_seed(0)),
        "bytes": torch.arange(5, dtype=torch.uint8),
    }
    header = {"b": 1, "a": [2, 3]}
    path = tmp_path / "new/file.safetensors"
    write_tensors(path, {name: tensor.numpy() for name, tensor in tensors.items()}, "header", header)
    unsigned = safetensors.torch.save(tensors, metadata={"header": canonical_json(header | {"digest": "0" * 64})})
    digest = hashlib.sha256(unsigned).hexdigest()
    assert path.read_bytes() == unsigned.replace(b"0" * 64, digest.encode())
    assert list(path.parent.iterdir()) == [path]


def test_arrays_that_are_views_are_written_as_they_read(tmp_path):
    array = np.arange(12.0).reshape(3, 4).T
    write_tensors(tmp_path / "file.safetensors", {"turned": array}, "header", {})
    with safetensors.safe_open(tmp_path / "file.safetensors", "np") as opened:
        assert np.array_equal(opened.get_tensor("turned"), array)


def test_what_was_written_is_read(tmp_path):
    path = tmp_path / "file.safetensors"
    write_tensors(path, {"scalar": np.float32(3), "empty": np.zeros((0, 2))}, "header", {"a": [1]})
    arrays, values = read_tensors(path, "header", "remedy")
    assert values == {"a": [1]}
    assert arrays["scalar"] == 3
    assert arrays["empty"].shape == (0, 2)


def test_no_bit_of_a_file_can_change_unseen(tmp_path):
    path = tmp_path / "file.safetensors"
    write_tensors(path, {"values": np.arange(6.0)}, "header", {"a": [1], "note": "x"})
    content = path.read_bytes()
    for changed in with_one_bit_flipped(content):
        path.write_bytes(changed)
        with pytest.raises(UserError, match="remedy"):
            read_tensors(path, "header", "remedy")
    for length in range(0, len(content), 7):
        path.write_bytes(content[:length])
        with pytest.raises(UserError, match="remedy"):
            read_tensors(path, "header", "remedy")

"""Arrays in safetensors files: the bytes that safetensors itself writes, and a file that others may read."""

import numpy as np
import safetensors
import safetensors.torch
import torch

from avs.system.files import canonical_json
from avs.system.tensor_files import write_tensors


def test_the_bytes_are_those_of_the_tensors_and_one_canonical_entry(tmp_path):
    tensors = {
        "scalar": torch.tensor(3),
        "floats": torch.rand(3, 4, generator=torch.Generator().manual_seed(0)),
        "bytes": torch.arange(5, dtype=torch.uint8),
    }
    header = {"b": 1, "a": [2, 3]}
    path = tmp_path / "new/file.safetensors"
    write_tensors(path, {name: tensor.numpy() for name, tensor in tensors.items()}, "header", header)
    assert path.read_bytes() == safetensors.torch.save(tensors, metadata={"header": canonical_json(header)})
    assert list(path.parent.iterdir()) == [path]


def test_arrays_that_are_views_are_written_as_they_read(tmp_path):
    array = np.arange(12.0).reshape(3, 4).T
    write_tensors(tmp_path / "file.safetensors", {"turned": array}, "header", {})
    with safetensors.safe_open(tmp_path / "file.safetensors", "np") as opened:
        assert np.array_equal(opened.get_tensor("turned"), array)

import resource
from pathlib import Path

import pytest
import torch

from avs.iqa.cross_reference.tensors_on_disk import on_disk

SHAPES = [(3, 5, 7), (2, 1), (), (4, 0), (1000, 1000)]


def _tensors():
    generator = torch.Generator().manual_seed(0)
    return [torch.randn(shape, generator=generator) for shape in SHAPES]


def test_tensors_come_back_as_they_were(tmp_path):
    found = on_disk(iter(_tensors()), tmp_path)
    assert [tuple(tensor.shape) for tensor in found] == SHAPES
    assert all(torch.equal(one, other) for one, other in zip(found, _tensors(), strict=True))


def test_one_whose_numbers_do_not_lie_in_order_comes_back(tmp_path):
    turned = torch.arange(12.0).reshape(3, 4).T
    assert torch.equal(on_disk([turned], tmp_path)[0], turned)


@pytest.mark.parametrize("shapes", [[], [(0, 3), (2, 0)]])
def test_nothing_needs_no_file(shapes, tmp_path):
    assert [tuple(tensor.shape) for tensor in on_disk((torch.empty(shape) for shape in shapes), tmp_path)] == shapes


def test_no_file_is_left_or_kept_open(tmp_path):
    opened = len(list(Path("/dev/fd").iterdir()))
    kept = [on_disk(_tensors(), tmp_path) for _ in range(3)]
    assert len(list(Path("/dev/fd").iterdir())) == opened
    assert not list(tmp_path.iterdir())
    assert torch.equal(kept[0][0], kept[2][0])


def test_what_finds_no_room_is_an_error(tmp_path):
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**20, hard))
    try:
        with pytest.raises(OSError, match="File too large"):
            on_disk((torch.zeros(2**17) for _ in range(4)), tmp_path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert not list(tmp_path.iterdir())

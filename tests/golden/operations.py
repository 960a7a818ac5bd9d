"""Prints digests of what NumPy, SciPy, torch and OpenCV compute, by which a difference is laid to a library."""

import hashlib
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from avs.system.compatibility import prepare_environment, prepare_torch

prepare_environment()

import numpy as np  # noqa: E402 - after what it reads when it is imported

_COUNT = 20_001  # not a multiple of any vector's length, so that the rests are computed too


def digest(results):
    """Return a digest of arrays; where one holds no number, that is all that counts."""
    found = hashlib.sha256()
    for result in results:
        array = np.asarray(result)
        found.update(np.ascontiguousarray(np.where(np.isnan(array), 0, array)).tobytes())
    return found.hexdigest()


def numpy_functions():
    """Elementary functions of one and two arguments, in both precisions."""
    values = np.random.default_rng(0).normal(size=_COUNT)
    names = [
        "exp",
        "log",
        "sin",
        "cos",
        "tan",
        "tanh",
        "sqrt",
        "arctan",
        "log1p",
        "arccos",
        "arcsin",
        "cbrt",
        "expm1",
        "log2",
        "exp2",
        "sinh",
        "cosh",
    ]
    with np.errstate(all="ignore"):
        for kind in (np.float32, np.float64):
            given = values.astype(kind)
            yield from (getattr(np, name)(given) for name in names)
            yield from (getattr(np, name)(np.abs(given), given[::-1]) for name in ("power", "arctan2", "hypot"))


def numpy_sums():
    """Sums, products and decompositions."""
    values = np.random.default_rng(1).normal(size=(200, 300))
    for kind in (np.float32, np.float64):
        given = values.astype(kind)
        square = given[:, :200]
        yield from (given.sum(), given.mean(0), given.std(1), given @ given.T, np.einsum("ij,ij->i", given, given))
        yield from (np.linalg.solve(square, given), np.linalg.inv(square), np.linalg.norm(given, axis=1))
        yield from (np.linalg.svd(given[:50, :60])[1], np.linalg.eigvalsh(given @ given.T))
        yield np.linalg.lstsq(given.T, values.T[:, :20].astype(kind), rcond=None)[0]


def scipy_functions():
    """Neighbours, filters, rotations, correlations."""
    from scipy import ndimage, stats
    from scipy.spatial import cKDTree
    from scipy.spatial.transform import Rotation

    points = np.random.default_rng(2).normal(size=(500, 3))
    yield cKDTree(points).query(points, k=4)[0]
    yield ndimage.distance_transform_edt(points[:, :2] > 0)
    yield ndimage.gaussian_filter(points, 1.5)
    yield Rotation.from_rotvec(points).as_matrix()
    yield stats.spearmanr(points[:, 0], points[:, 1])[0]


def torch_functions():
    """Elementary functions, sums and the pieces of networks, forward and backward."""
    import torch
    from torch.nn import functional

    prepare_torch()
    torch.manual_seed(0)
    yield from (torch.randn(1000), torch.rand(1000))
    values = torch.from_numpy(np.random.default_rng(3).normal(size=_COUNT))
    names = [
        "exp",
        "sigmoid",
        "tanh",
        "log",
        "sin",
        "cos",
        "tan",
        "erf",
        "erfc",
        "rsqrt",
        "sqrt",
        "log1p",
        "log2",
        "log10",
        "expm1",
        "atan",
        "asin",
        "acos",
        "lgamma",
    ]
    for given in (values.float(), values):
        yield from (getattr(given, name)() for name in names)
        yield from (given.sum(), given.mean(), given.std(), given.norm(), given.cumsum(0), given.abs().pow(2.3))
    tokens, weight = torch.randn(2, 50, 48), torch.randn(96, 48)
    yield functional.gelu(functional.layer_norm(functional.linear(tokens, weight), (96,))).softmax(2)
    heads = tokens.view(2, 50, 4, 12).transpose(1, 2)
    yield functional.scaled_dot_product_attention(heads, heads, heads)
    pictures, kernel = torch.randn(2, 3, 65, 83, requires_grad=True), torch.randn(16, 3, 3, 3, requires_grad=True)
    convolved = functional.conv2d(pictures, kernel, padding=1)
    yield functional.conv2d(convolved.detach(), torch.randn(16, 1, 3, 3), padding=1, groups=16, stride=2)
    yield functional.conv2d(convolved.detach(), torch.randn(24, 16, 1, 1), torch.randn(24))
    convolved.square().sum().backward()
    yield from (pictures.grad, kernel.grad)
    yield functional.interpolate(pictures.detach(), size=(40, 50), mode="bilinear", antialias=True)
    yield functional.interpolate(pictures.detach(), size=(99, 120), mode="bicubic")
    yield torch.fft.rfft2(pictures.detach()).abs()


def torch_training():
    """Three steps of AdamW on two linear layers."""
    import torch

    prepare_torch()
    torch.manual_seed(1)
    network = torch.nn.Sequential(torch.nn.Linear(48, 96), torch.nn.GELU(), torch.nn.Linear(96, 1))
    optimizer = torch.optim.AdamW(network.parameters(), lr=1e-2)
    tokens = torch.randn(64, 48)
    for _ in range(3):
        optimizer.zero_grad()
        network(tokens).sigmoid().abs().mean().backward()
        optimizer.step()
    yield from (parameter.detach() for parameter in network.parameters())


def opencv_functions():
    """What photographs and their depth maps go through."""
    import cv2

    picture = np.random.default_rng(4).integers(0, 256, (60, 80), dtype=np.uint8)
    smooth = cv2.sepFilter2D(picture.astype(np.float32), cv2.CV_32F, np.full(5, 0.2), np.full(5, 0.2))
    yield smooth
    yield cv2.medianBlur(smooth, 3)
    keypoints, found = cv2.SIFT.create(nfeatures=50).detectAndCompute(smooth.astype(np.uint8), None)
    yield np.array([keypoint.pt for keypoint in keypoints])
    yield found


if __name__ == "__main__":
    for name in (numpy_functions, numpy_sums, scipy_functions, torch_functions, torch_training, opencv_functions):
        print(f"{name.__name__.replace('_', ' ')}\t{digest(name())}", flush=True)

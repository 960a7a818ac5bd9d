"""The diagonal Fisher information against the full per-pixel Jacobian of the slow twin."""

import pytest
import torch
from test_rasterization import cameras, gaussians
from tolerances import FISHER_DIAGONAL

from avs.rasterizer.fisher_diagonal import fisher_diagonal
from tests.rasterizer import reference_renderer as reference

WIDTH, HEIGHT = 20, 15


@pytest.mark.parametrize(
    ("degree", "background", "opaque", "mode"),
    [(0, None, False, "classic"), (2, [0.3, 0.5, 0.1], True, "classic"), (3, None, False, "antialiased")],
)
def test_against_the_jacobian(degree, background, opaque, mode):
    scene = gaussians(40, 5, sh_degree=degree, opaque=opaque, size=2.0)
    viewmats, intrinsics = cameras(1, 1, WIDTH, HEIGHT)
    behind = None if background is None else torch.tensor(background, dtype=torch.float64)

    def channel_sums(*tensors):
        options = {"sh_degree": degree, "background": behind, "rasterize_mode": mode}
        image, _ = reference.render(*tensors, viewmats[0], intrinsics[0], WIDTH, HEIGHT, **options)
        return image.sum(-1).reshape(-1)

    jacobian = torch.autograd.functional.jacobian(channel_sums, tuple(scene))
    result = fisher_diagonal(
        *(x.float() for x in (*scene, viewmats[0], intrinsics[0])),
        WIDTH,
        HEIGHT,
        degree,
        None if behind is None else behind.float(),
        rasterize_mode=mode,
    )
    assert (result.rows.diff() > 0).all()
    of = (result.means, result.quats, result.scales, result.opacities, result.sh)
    for j, found in zip(jacobian, of, strict=True):
        expected = (j**2).sum(0)
        assert expected.max() > 0
        assert (found >= 0).all()
        everywhere = torch.zeros_like(expected)
        everywhere[result.rows] = found.double()
        assert ((everywhere - expected).abs() <= FISHER_DIAGONAL * (expected + 1e-6 * expected.max())).all()


def test_thin_oblique_gaussians():
    """Their derivatives by the short axes are small beside those by the long one, along nearly the same pixels."""
    means, quats, scales, opacities, harmonics = gaussians(12, 5, sh_degree=1, size=3.0)
    scales = scales.max() * torch.tensor([1.0, 0.01, 0.01], dtype=torch.float64).expand(12, 3)
    viewmats, intrinsics = cameras(1, 1, WIDTH, HEIGHT)

    def channel_sums(tensor):
        tensors = (means, quats, tensor, opacities, harmonics)
        image, _ = reference.render(*tensors, viewmats[0], intrinsics[0], WIDTH, HEIGHT, sh_degree=1)
        return image.sum(-1).reshape(-1)

    expected = (torch.autograd.functional.jacobian(channel_sums, scales) ** 2).sum(0)
    tensors = [x.float() for x in (means, quats, scales, opacities, harmonics, viewmats[0], intrinsics[0])]
    result = fisher_diagonal(*tensors, WIDTH, HEIGHT, 1, rotations=False)
    assert result.quats.shape == (0, 4)
    expected = expected[result.rows]
    assert len(expected) == 6
    assert ((result.scales - expected).abs() <= FISHER_DIAGONAL * expected).all()


def test_higher_harmonics_and_unseen_gaussians_have_no_place():
    scene = [x.float() for x in gaussians(40, 6, sh_degree=2)]
    scene[0][:5, 2] = -1.0
    viewmats, intrinsics = (x.float() for x in cameras(1, 1, WIDTH, HEIGHT))
    viewmats[0] = torch.eye(4)
    result = fisher_diagonal(*scene, viewmats[0], intrinsics[0], WIDTH, HEIGHT, 1)
    assert result.sh.shape == (len(result.rows), 4, 3)
    assert result.rows.min() >= 5
    assert (result.sh > 0).any()

"""The diagonal Fisher information against the full per-pixel Jacobian of the slow twin."""

import pytest
import reference_renderer as reference
import torch
from test_rasterization import cameras, gaussians
from tolerances import FISHER_DIAGONAL

from avs.representations.gaussians.fisher import fisher_diagonal

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
    of = (result.means, result.quats, result.scales, result.opacities, result.sh)
    for j, found in zip(jacobian, of, strict=True):
        expected = (j**2).sum(0)
        assert expected.max() > 0
        assert (found >= 0).all()
        assert ((found - expected).abs() <= FISHER_DIAGONAL * (expected + 1e-6 * expected.max())).all()


def test_higher_harmonics_and_unseen_gaussians_have_none():
    scene = [x.float() for x in gaussians(40, 6, sh_degree=2)]
    scene[0][:5, 2] = -1.0
    viewmats, intrinsics = (x.float() for x in cameras(1, 1, WIDTH, HEIGHT))
    viewmats[0] = torch.eye(4)
    result = fisher_diagonal(*scene, viewmats[0], intrinsics[0], WIDTH, HEIGHT, 1)
    assert (result.sh[:, 4:] == 0).all()
    assert (result.means[:5] == 0).all()
    assert (result.sh[:, :4] > 0).any()

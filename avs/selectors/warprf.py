"""WarpRF: the candidate that agrees least with the renderings of the captured views (arXiv 2506.22433)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.representations.base import FloatImages
from avs.selection.batched_rendering import render_in_batches
from avs.selection.contract import Method, Resources, Settings, State

BATCH = 8
"""Views rendered at once, which bounds the memory."""


class WarpRfSelector:
    """Largest sum over pixels of the least difference to a captured view, warped by the candidate's depth."""

    def __init__(self, settings: Settings, resources: Resources) -> None:
        """Compare on the device of ``resources``."""
        self._device = resources.device

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return the sum for each candidate, ``[n]``; of the representation only ``render`` is used."""
        import torch

        from avs.scene.warping import warped

        def images(array: FloatImages) -> torch.Tensor:
            return torch.from_numpy(array).to(self._device).permute(0, 3, 1, 2).contiguous()

        cameras, captured = state.captured.cameras, dict[int, torch.Tensor]()
        for rows, rendering in render_in_batches(state.representation, cameras, BATCH):
            captured |= dict(zip(rows.tolist(), images(rendering.rgb), strict=True))
        scores = np.empty(len(state.candidates))
        for rows, rendering in render_in_batches(state.representation, state.candidates, BATCH):
            # blended, not expected depth: the published code does not divide by the opacity
            depths = torch.from_numpy(rendering.depth * rendering.alpha).to(self._device)
            for row, seen, depth in zip(rows, images(rendering.rgb), depths, strict=True):
                least = torch.full_like(depth, torch.inf)
                for view, image in captured.items():
                    difference = warped(image, cameras[view], depth, state.candidates[row]).sub_(seen).abs_()
                    torch.minimum(least, difference.sum(dim=0), out=least)
                scores[row] = float(least.sum(dtype=torch.float64))
        return scores


METHODS = {
    "warprf": Method(
        label="WarpRF",
        group="2D-based",
        source=(
            "Safadoust et al., WACV 2026 (arXiv 2506.22433), as its code at commit d2e409f computes it: blended depth, "
            "edge colours for points that project outside a captured view, no test of occlusion. It uses renderings "
            "and their depth only, hence its group; no deviation but the reconstruction's own."
        ),
        chooses="highest",
        build=WarpRfSelector,
    )
}

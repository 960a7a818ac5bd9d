"""WarpRF: the candidate that agrees least with the renderings of the captured views (arXiv 2506.22433)."""

from __future__ import annotations

import numpy as np
from pydantic import Field, PositiveInt

from avs.selectors.base import Method, Resources, Selection, Settings, State, choose, render_in_batches


class WarpRfSettings(Settings):
    """Settings of WarpRF."""

    batch: PositiveInt = Field(default=4, description="candidates rendered and compared at once; bounds the memory")


class WarpRfSelector:
    """Largest sum over pixels of the least difference to a captured view, warped by the candidate's depth."""

    def __init__(self, settings: WarpRfSettings, resources: Resources) -> None:
        """Compare on the device of ``resources``."""
        self._settings = settings
        self._device = resources.device

    def select(self, state: State, k: int) -> Selection:
        """Return the ``k`` candidates of the largest sum; of the representation only ``render`` is used."""
        import torch

        from avs.warping import warped

        representation, cameras, batch = state.representation, state.captured.cameras, self._settings.batch
        render_seconds, sources = 0.0, dict[int, torch.Tensor]()
        for rows, rendering, seconds in render_in_batches(representation, cameras, batch):
            render_seconds += seconds
            images = torch.from_numpy(rendering.rgb).to(self._device).permute(0, 3, 1, 2)
            sources |= dict(zip(rows.tolist(), images.contiguous(), strict=True))
        scores = np.empty(len(state.candidates))
        for rows, rendering, seconds in render_in_batches(representation, state.candidates, batch):
            render_seconds += seconds
            seen = torch.from_numpy(rendering.rgb).to(self._device).permute(0, 3, 1, 2)
            # blended, not expected depth: the published code does not divide by the opacity
            depth = torch.from_numpy(rendering.depth * rendering.alpha).to(self._device)
            least = torch.full_like(depth, torch.inf)
            for row, image in sources.items():
                difference = warped(image, cameras[row], depth, state.candidates[rows]).sub_(seen).abs_().sum(dim=1)
                torch.minimum(least, difference, out=least)
            scores[rows] = least.sum(dim=(1, 2), dtype=torch.float64).cpu().numpy()
        return Selection(choose(scores, k, higher_is_worse=True), scores, render_seconds)


METHODS = {
    "warprf": Method(
        label="WarpRF",
        group="2D-based",
        source=(
            "Safadoust et al., WACV 2026 (arXiv 2506.22433), as its code at commit d2e409f computes it: blended depth, "
            "edge colours for points that project outside a captured view, no test of occlusion. It uses renderings "
            "and their depth only, hence its group; no deviation but the reconstruction's own."
        ),
        higher_is_worse=True,
        build=WarpRfSelector,
        settings=WarpRfSettings,
    )
}

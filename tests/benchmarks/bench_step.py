"""Processor time of an optimisation step in one operation against one whose graph torch keeps.

Run from the root of the repository, after ``snakemake -j2 tables``: ``python -m tests.benchmarks.bench_step``. A scene
is fitted from nothing with the settings of a method's episode both ways, in turn; both end with the same bits.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path

from avs.system.compatibility import prepare_environment, prepare_torch

prepare_environment()

from avs.nvs.episode_settings import EpisodeSettings  # noqa: E402
from avs.rasterizer.losses import photometric_loss  # noqa: E402
from avs.rasterizer.rasterization import rasterization  # noqa: E402
from avs.representations.gaussians.objective import PhotometricObjective  # noqa: E402
from avs.representations.gaussians.splats import build  # noqa: E402
from avs.scene.scene import read_scene  # noqa: E402
from avs.system.records import read_settings  # noqa: E402

VIEWS = 20


class WithGraph(PhotometricObjective):
    """The same loss by rasteriser and loss, each with a backward pass of its own."""

    def __call__(self, parameters, arguments, target):
        """See ``Objective``."""
        image, _, meta = rasterization(**arguments, packed=False)
        return photometric_loss(image[0], target, self._ssim_weight), meta


def main() -> None:
    """Print the milliseconds of a step each way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--results", type=Path, default=Path("results/ci"))
    parser.add_argument("--scene", default="orbit/orbit_0")
    parser.add_argument("--steps", type=int, default=500)
    parser.add_argument("--repetitions", type=int, default=5)
    told = parser.parse_args()
    prepare_torch()
    scene = read_scene(told.results / "scenes" / told.scene)
    settings = read_settings(told.results / "settings" / "episode" / "farthest.json", EpisodeSettings).representation
    captured = scene.pool[:VIEWS]
    views = scene.views(captured)

    def fitted(objective):
        splats = build(scene, captured, settings, 0, "cpu")
        splats._objective = objective(settings.ssim_weight)
        start = time.process_time()
        splats.fit(views, told.steps)
        return 1e3 * (time.process_time() - start) / told.steps, splats.fingerprint()

    ways = {"with a graph": WithGraph, "in one operation": PhotometricObjective}
    found = {way: [] for way in ways}
    for _ in range(1 + told.repetitions):  # the first compiles
        ends = [fitted(objective) for objective in ways.values()]
        assert len({fingerprint for _, fingerprint in ends}) == 1, "the two ways differ"
        for way, (milliseconds, _) in zip(ways, ends, strict=True):
            found[way].append(milliseconds)
    medians = {way: statistics.median(times[1:]) for way, times in found.items()}
    for way, times in found.items():
        print(f"{way:18} {medians[way]:.2f} ms ({min(times[1:]):.2f} to {max(times[1:]):.2f})", flush=True)
    print(f"ratio {medians['in one operation'] / medians['with a graph']:.2f}")


if __name__ == "__main__":
    main()

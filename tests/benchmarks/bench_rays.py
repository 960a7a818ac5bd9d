"""Speed of rays through the triangles of embedded scenes, beside Embree (Open3D's RaycastingScene) on the same rays.

Run from the root of the repository: ``python -m tests.benchmarks.bench_rays``. Rays of a camera, which pass the same
boxes one after another, and rays from everywhere to everywhere, as the light that is gathered needs. Both programs use
one thread; times are of the process's CPU, in interleaved rounds, and ratios are of times of one round.
"""

from __future__ import annotations

import statistics
import time
from functools import partial

from avs.system.compatibility import import_open3d, prepare_environment

prepare_environment()

import numpy as np  # noqa: E402 - after what it reads when it is imported

from avs.datasets.embedded.capture import PATTERNS  # noqa: E402
from avs.datasets.embedded.geometry.mesh_model import assemble  # noqa: E402
from avs.datasets.embedded.geometry.ray_search import any_triangle, first_triangles  # noqa: E402
from avs.datasets.embedded.geometry.ray_tree import build_tree  # noqa: E402
from avs.system.provenance import machine  # noqa: E402

ROUNDS = 7
COUNT = 250_000


def model_of(pattern):
    """Return the first scene of ``pattern`` as vertices and triangles."""
    kind = PATTERNS[pattern]
    model = assemble(kind.layout(0, np.random.default_rng([0, kind.number, 0])).meshes)
    return model.vertices, model.triangles


def rays_of(vertices, kind):
    """Return ``[n, 6]`` rays of a ``camera`` in the middle, or ``everywhere``."""
    generator = np.random.default_rng(0)
    if kind == "camera":
        side = int(COUNT**0.5)
        x, y = np.meshgrid(np.linspace(-1, 1, side), np.linspace(-1, 1, side))
        directions = np.stack([x, np.full_like(x, 0.7), y], axis=-1).reshape(-1, 3)
        origins = np.tile(vertices.mean(axis=0) + np.array([0, 0, 1]), (len(directions), 1))
    else:
        directions = generator.normal(size=(COUNT, 3))
        origins = vertices[generator.integers(0, len(vertices), COUNT)] + generator.normal(size=(COUNT, 3)) * 0.01
    return np.concatenate([origins, directions], axis=1).astype(np.float32)


def seconds(function):
    """Return the process's time that ``function`` takes."""
    start = time.process_time()
    function()
    return time.process_time() - start


def main():
    """Print a line for each pattern, kind of rays and question."""
    core = import_open3d().core
    print(machine("cpu")["processor"])
    print(f"{'pattern':12} {'rays':11} {'question':9} {'million rays/s':>15} {'Embree':>8} {'ratio (least..most)':>22}")
    for pattern in ("orbit", "walkthrough"):
        vertices, triangles = model_of(pattern)
        tree = build_tree(vertices, triangles)
        scene = import_open3d().t.geometry.RaycastingScene(nthreads=1)
        scene.add_triangles(core.Tensor(vertices), core.Tensor(triangles.astype(np.uint32)))
        for kind in ("camera", "everywhere"):
            rays = rays_of(vertices, kind)
            questions = {
                "first": (
                    partial(first_triangles, tree, rays),
                    partial(scene.cast_rays, core.Tensor(rays), nthreads=1),
                ),
                "any": (
                    partial(any_triangle, tree, rays, 1.0),
                    partial(scene.test_occlusions, core.Tensor(rays), tnear=0.0, tfar=1.0, nthreads=1),
                ),
            }
            for question, pair in questions.items():
                times = [[seconds(function) for function in pair] for _ in range(ROUNDS + 1)][1:]
                ours, theirs = (statistics.median(column) for column in zip(*times, strict=True))
                ratios = sorted(there / here for here, there in times)
                speeds = len(rays) / ours / 1e6, len(rays) / theirs / 1e6
                print(
                    f"{pattern:12} {kind:11} {question:9} {speeds[0]:15.2f} {speeds[1]:8.2f}"
                    f" {statistics.median(ratios):8.2f} ({ratios[0]:.2f}..{ratios[-1]:.2f})"
                )


if __name__ == "__main__":
    main()

"""Time per candidate of the cross-reference networks against FisherRF's exact score: same scene, same image size.

Run from the root of the repository: ``python -m tests.benchmarks.bench_selection [SCENE SPLATS]``. SCENE is a scene's
folder, SPLATS the ``splats.ply`` of an episode on it. Without them a cube of random Gaussians on a ring of cameras
serves, whose renderings are its photographs.

For each length of the images' longer side it prints the time per candidate, rendering included, and its ratio to
FisherRF's (which renders nothing: its pass over the pixels is the score). Beside it stands what one captured view
costs: FisherRF computes the information of every captured view at every selection, a network encodes a photograph once.
Networks have random weights, which take the same time as trained ones, and five references.

Times are of the process's CPU, medians over interleaved rounds; compare columns of one run only.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
import torch  # noqa: E402

from avs.iqa.cross_reference.network import build_network  # noqa: E402
from avs.iqa.cross_reference.scorer_settings import DINOv2Settings, EfficientNetLite0Settings, RepViTSettings  # noqa: E402
from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer  # noqa: E402
from avs.iqa.resizing import ResizeSettings, resized, to_tensor  # noqa: E402
from avs.representations.gaussians.gaussian_settings import GaussianSettings  # noqa: E402
from avs.representations.gaussians.initialization import PointCloud  # noqa: E402
from avs.representations.gaussians.ply import read_ply  # noqa: E402
from avs.representations.gaussians.splats import GaussianSplats  # noqa: E402
from avs.scene.cameras import Cameras, look_at  # noqa: E402
from avs.scene.scene import read_scene  # noqa: E402
from avs.scene.views import Views  # noqa: E402
from avs.selection import registry  # noqa: E402
from avs.selection.contract import Resources, State  # noqa: E402

NETWORKS = {"Lite0": EfficientNetLite0Settings(), "RepViT": RepViTSettings(), "DINOv2": DINOv2Settings()}
GAUSSIANS, REFERENCES = 6000, 5


def random_scene():
    """Return cameras on a ring, of 3:2 images, and a cube of random Gaussians."""
    generator = np.random.default_rng(0)
    angles = 2 * np.pi * np.arange(32) / 32
    centers = np.stack([2.5 * np.cos(angles), 2.5 * np.sin(angles), np.full(32, 0.8)], axis=1)
    transforms = np.stack([look_at(center, np.zeros(3), np.array([0.0, 0.0, 1.0])) for center in centers])
    intrinsics = np.tile(np.array([[520.0, 0, 300], [0, 520.0, 200], [0, 0, 1]]), (32, 1, 1))
    cameras = Cameras(transforms, intrinsics, np.tile(np.array([[600, 400]], dtype=np.int64), (32, 1)))
    parameters = {
        "means": generator.random((GAUSSIANS, 3)) - 0.5,
        "scales": generator.uniform(np.log(0.005), np.log(0.03), (GAUSSIANS, 3)),
        "quats": generator.standard_normal((GAUSSIANS, 4)),
        "opacities": generator.uniform(-2, 2, GAUSSIANS),
        "sh": 0.3 * generator.standard_normal((GAUSSIANS, 16, 3)),
    }
    return cameras, {key: torch.from_numpy(value.astype(np.float32)) for key, value in parameters.items()}


def splats(parameters):
    """Return a reconstruction with these parameters."""
    count = len(parameters["means"])
    cloud = PointCloud(np.random.default_rng(0).random((count, 3)), np.zeros((count, 3)))
    representation = GaussianSplats(cloud, 1.0, GaussianSettings(), np.random.default_rng(0), "cpu")
    representation.parameters.update({key: value.requires_grad_() for key, value in parameters.items()})
    return representation


def seconds(work):
    """Return the CPU time of one call."""
    start = time.process_time()
    work()
    return time.process_time() - start


def measure(cameras, representation, side, count, repeats):
    """Print one image size's rows: the networks, then FisherRF, in milliseconds."""
    ratio = side / cameras.sizes.max()
    scaled = cameras.resized(np.round(cameras.sizes * ratio).astype(np.int64))
    candidates, captured = scaled[np.arange(count)], scaled[np.arange(count, count + REFERENCES)]
    photographs = representation.render(captured).rgb
    renderings = representation.render(candidates).rgb
    names = tuple(f"{row}.png" for row in range(max(count, REFERENCES)))
    pixels = tuple((255 * photographs.clip(0, 1)).astype(np.uint8))
    views = Views(captured, pixels, names[: len(captured)])
    method = registry.find("fisherrf").method
    fisher = method.build(method.settings(), Resources())

    def select(number):
        rng = np.random.default_rng(0)
        fisher.select(State(representation, views, candidates[np.arange(number)], names[:number], rng, 0), 1)

    works = {
        ("render", "candidates"): lambda: representation.render(candidates),
        ("FisherRF", "all"): lambda: select(count),
        ("FisherRF", "one"): lambda: select(1),
    }
    for label, settings in NETWORKS.items():
        scorer = CrossReferenceScorer(build_network(settings, 0), ResizeSettings(pixels=side))
        pixels = resized(to_tensor(renderings), scorer.resize).contiguous(memory_format=torch.channels_last)
        works |= network_works(label, scorer, renderings, photographs, pixels)
    for work in works.values():
        work()  # compiles and allocates
    rounds = [per_view({key: seconds(work) for key, work in works.items()}, count) for _ in range(repeats)]
    median = {key: 1e3 * float(np.median([each[key] for each in rounds])) for key in rounds[0]}
    width, height = scaled.sizes[0]
    for label in (*NETWORKS, "FisherRF"):
        ratios = [each[label, "candidate"] / each["FisherRF", "candidate"] for each in rounds]
        print(
            f"{width}x{height}  {label:8}  {median[label, 'candidate']:7.1f} ms per candidate"
            f" (backbone {median.get((label, 'backbone'), 0.0):6.1f}),"
            f" {np.median(ratios):5.2f} [{min(ratios):.2f} to {max(ratios):.2f}] of FisherRF's;"
            f" captured view {median[label, 'captured']:6.1f} ms",
            flush=True,
        )
    print(
        f"{width}x{height}  rendering {median['render', 'candidate']:7.1f} ms, part of the networks' times", flush=True
    )


def network_works(label, scorer, renderings, photographs, pixels):
    """Return what is timed of one network."""
    read = scorer.encode(photographs)

    def backbone():
        with torch.inference_mode():
            for batch in pixels.split(scorer.batch):
                scorer.network.encode(batch)

    return {
        (label, "score"): lambda: scorer.score(renderings, [read] * len(renderings)),
        (label, "encode"): lambda: scorer.encode(photographs),
        (label, "backbone"): backbone,
    }


def per_view(times, count):
    """Return one round's seconds for one candidate and for one captured view."""
    rendering = times["render", "candidates"] / count
    candidate = (times["FisherRF", "all"] - times["FisherRF", "one"]) / (count - 1)
    captured = (times["FisherRF", "one"] - candidate) / REFERENCES
    found = {
        ("render", "candidate"): rendering,
        ("FisherRF", "candidate"): candidate,
        ("FisherRF", "captured"): captured,
    }
    for label in NETWORKS:
        found[label, "candidate"] = rendering + times[label, "score"] / count
        found[label, "backbone"] = times[label, "backbone"] / count
        found[label, "captured"] = times[label, "encode"] / REFERENCES
    return found


def main() -> None:
    """Measure the image sizes that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="*", type=Path, metavar="SCENE SPLATS")
    parser.add_argument("--sides", nargs="+", type=int, default=[160, 320, 518])
    parser.add_argument("--candidates", type=int, default=8, help="at least 2")
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    if arguments.paths:
        scene, ply = arguments.paths
        read = read_scene(scene)
        cameras, parameters = read.cameras, read_ply(ply, read.to_capture)
    else:
        cameras, parameters = random_scene()
    representation = splats(parameters)
    print(
        f"{len(parameters['means'])} Gaussians, {arguments.candidates} candidates, {REFERENCES} references, one thread;"
        f" load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
    )
    for side in arguments.sides:
        measure(cameras, representation, side, arguments.candidates, arguments.repeats)


if __name__ == "__main__":
    main()

"""Time per candidate of the cross-reference networks against FisherRF's exact score: same scene, same image size.

Run from the root of the repository: ``python tests/benchmarks/bench_selection.py [SCENE SPLATS]``. SCENE is a scene's
folder, SPLATS the ``splats.ply`` of an episode on it. Without them a cube of random Gaussians on a ring of cameras
serves, whose renderings are its photographs.

For each length of the images' longer side it prints, per candidate, the time of rendering, of scoring, and their sum
as a ratio to FisherRF's (which renders nothing: its pass over the pixels is the score). Beside it stands what one more
captured view costs: FisherRF computes the information of every captured view at every selection, a network encodes a
photograph once. Networks have random weights, which take the same time as trained ones, and five references.

Times are of the process's CPU, medians over interleaved rounds; compare columns of one run only.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).parents[2]))

import numpy as np  # noqa: E402
import torch  # noqa: E402

from avs.cameras import Cameras, look_at  # noqa: E402
from avs.representations.gaussians.initialization import PointCloud  # noqa: E402
from avs.representations.gaussians.ply import read_ply  # noqa: E402
from avs.representations.gaussians.settings import GaussianSettings  # noqa: E402
from avs.representations.gaussians.splats import GaussianSplats  # noqa: E402
from avs.resizing import ResizeSettings, resized, to_tensor  # noqa: E402
from avs.scene import read_scene  # noqa: E402
from avs.scorer.network import build_network  # noqa: E402
from avs.scorer.scoring import CrossReferenceScorer  # noqa: E402
from avs.scorer.settings import DINOv2Settings, RepViTSettings  # noqa: E402
from avs.selectors.fisher import information_gain  # noqa: E402

NETWORKS = {"RepViT": RepViTSettings(), "DINOv2": DINOv2Settings()}
GAUSSIANS, REFERENCES, REGULARISATION = 6000, 5, 1e-6


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
    """Print one image size's rows: first all networks, then FisherRF, in milliseconds."""
    ratio = side / cameras.sizes.max()
    scaled = cameras.resized(np.round(cameras.sizes * ratio).astype(np.int64))
    candidates, captured = scaled[np.arange(count)], scaled[np.arange(count, count + REFERENCES)]
    photographs = representation.render(captured).rgb
    renderings = representation.render(candidates).rgb
    captured_information = sum(d.astype(np.float64) for d in representation.fisher_diagonal(captured, "once"))

    def fisher(views):
        for diagonal in representation.fisher_diagonal(views, "once"):
            information_gain(diagonal, captured_information, REGULARISATION)

    works = {
        ("render", "candidate"): (lambda: representation.render(candidates), count),
        ("FisherRF", "candidate"): (lambda: fisher(candidates), count),
        ("FisherRF", "captured"): (lambda: fisher(captured), REFERENCES),
    }
    for label, settings in NETWORKS.items():
        scorer = CrossReferenceScorer(build_network(settings, 0), ResizeSettings(pixels=side))
        tokens = scorer.encode(photographs)
        pixels = resized(to_tensor(renderings), scorer.resize)

        def score(scorer=scorer, tokens=tokens):
            scorer.score(renderings, [tokens] * count)

        def encode(scorer=scorer):
            scorer.encode(photographs)

        def backbone(scorer=scorer, pixels=pixels):
            with torch.inference_mode():
                for batch in pixels.split(scorer.batch):
                    scorer.network.encode(batch)

        works[label, "candidate"] = (score, count)
        works[label, "captured"] = (encode, REFERENCES)
        works[label, "backbone"] = (backbone, count)
    for work, _ in works.values():
        work()  # compiles and allocates
    rounds = [{key: seconds(work) / number for key, (work, number) in works.items()} for _ in range(repeats)]
    median = {key: 1e3 * float(np.median([each[key] for each in rounds])) for key in works}
    width, height = scaled.sizes[0]
    for label in (*NETWORKS, "FisherRF"):
        rendering = 0.0 if label == "FisherRF" else median["render", "candidate"]
        total = rendering + median[label, "candidate"]
        spread = np.percentile([r[label, "candidate"] / r["FisherRF", "candidate"] for r in rounds], [0, 100])
        print(
            f"{width}x{height}  {label:8}  render {rendering:6.1f}  score {median[label, 'candidate']:7.1f}"
            f"  (backbone {median.get((label, 'backbone'), 0.0):6.1f})  sum {total:7.1f} ms per candidate,"
            f" {total / median['FisherRF', 'candidate']:5.2f} of FisherRF's"
            f"  [scores alone {spread[0]:.2f} to {spread[1]:.2f}]; captured view {median[label, 'captured']:6.1f} ms",
            flush=True,
        )


def main() -> None:
    """Measure the image sizes that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="*", type=Path, metavar="SCENE SPLATS")
    parser.add_argument("--sides", nargs="+", type=int, default=[160, 320, 518])
    parser.add_argument("--candidates", type=int, default=8)
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    if arguments.paths:
        scene, ply = arguments.paths
        cameras, parameters = read_scene(scene).cameras, read_ply(ply)
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

"""The curves of ``docs/reconstruction-study.md``: test PSNR of a reconstruction under farthest-view sampling.

    python -m tests.benchmarks.reconstruction_study CONFIG SCENE... [--set densification.every=25 points.choice=sfm]

CONFIG is a scale's YAML file, of which ``protocol`` and ``representation`` are read; SCENE is the folder of a prepared
scene. No method is compared: farthest-view sampling alone is used.
"""

import argparse
import copy
import time
from pathlib import Path

import numpy as np
import torch
import yaml

from avs.nvs.protocol import ProtocolSettings
from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.gaussians.splats import build
from avs.scene.sampling import initial_views
from avs.scene.scene import read_scene
from metrics.image import psnr


def changed(settings, changes):
    """Return the nested dictionary ``settings`` with values like ``densification.every=25`` replaced."""
    settings = copy.deepcopy(settings)
    for change in changes:
        path, value = change.split("=", 1)
        *sections, key = path.split(".")
        place = settings
        for section in sections:
            place = place.setdefault(section, {})
        place[key] = yaml.safe_load(value)
    return GaussianSettings.model_validate(settings)


def mean_psnr(splats, views):
    values = []
    for index in range(len(views)):
        rendered = splats.render(views.cameras[index]).rgb[0].astype(np.float64)
        values.append(psnr(rendered, views.images[index] / 255.0))
    return float(np.mean(values))


def curve(folder, protocol, settings, seed, moments):
    """Return the lines of one scene: iteration, views, Gaussians, test PSNR, seconds of fitting so far."""
    scene = read_scene(folder)
    budget = min(protocol.budget, int(len(scene.pool) * protocol.pool_share))
    order = scene.pool[initial_views(scene.cameras.centers[scene.pool], budget)]
    test = scene.views(scene.test)
    count = min(protocol.initial_views, budget)
    additions = protocol.additions[: budget - count]
    splats = build(scene, order[:count], settings, seed, "cpu")
    views, seconds = scene.views(order[:count]), 0.0
    for stop in sorted({*additions, *moments, protocol.iterations}):
        start = time.process_time()
        splats.fit(views, stop - splats.iteration)
        seconds += time.process_time() - start
        if stop in moments or stop == protocol.iterations:
            yield stop, len(views), splats.primitives, mean_psnr(splats, test), seconds
        if stop in additions:
            count += 1
            views = scene.views(order[:count])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("config", type=Path)
    parser.add_argument("scenes", type=Path, nargs="+")
    parser.add_argument(
        "--set", nargs="*", default=[], metavar="KEY=VALUE", help="changes of the representation's settings"
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--moments", type=int, nargs="*", default=[], help="iterations at which to measure besides the last"
    )
    arguments = parser.parse_args()
    torch.set_num_threads(1)
    config = yaml.safe_load(arguments.config.read_text())
    protocol = ProtocolSettings.model_validate(config["protocol"])
    settings = changed(config["representation"], arguments.set)
    for folder in arguments.scenes:
        for stop, views, gaussians, value, seconds in curve(
            folder, protocol, settings, arguments.seed, arguments.moments
        ):
            print(
                f"{folder.name:12} {stop:6} {views:3} views {gaussians:7} Gaussians {value:6.2f} dB {seconds:6.1f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()

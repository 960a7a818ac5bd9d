"""Small networks and small distortion data."""

import numpy as np
import pytest
import torch

from avs.iqa.cross_reference.distortions import Distortions, Moment, coded
from avs.iqa.cross_reference.network import build_network
from avs.iqa.cross_reference.scorer_settings import RepViTSettings
from avs.iqa.render_statistics.view_geometry import VIEW_GEOMETRY
from metrics.image import ssim_map


@pytest.fixture(scope="session")
def network():
    torch.set_num_threads(1)
    built = build_network(RepViTSettings(), seed=3).eval()
    # Fresh batch norms are the identity: give them statistics, so that what is merged or forgotten shows.
    generator = torch.Generator().manual_seed(4)
    for module in built.backbone.modules():
        if isinstance(module, torch.nn.BatchNorm2d):
            module.running_mean.normal_(0.0, 0.1, generator=generator)
            module.running_var.uniform_(0.5, 1.5, generator=generator)
            module.weight.data.uniform_(0.5, 1.5, generator=generator)
            module.bias.data.normal_(0.0, 0.1, generator=generator)
    return built


def toy_distortions(name, seed, side=56, photographs=8):
    """Photographs of coarse random colours; renderings of them with noise of several strengths."""
    rng = np.random.default_rng(seed)
    blocks = rng.integers(0, 256, (photographs, side // 7, side // 7, 3), dtype=np.uint8)
    truth = blocks.repeat(7, axis=1).repeat(7, axis=2)
    moments = tuple(Moment(run=0, iteration=10 * m, captured=tuple(range(m + 3))) for m in range(3))
    renderings, maps, images, moment_of = [], [], [], []
    for number in range(len(moments)):
        for image in range(photographs):
            strength = 100 * rng.random() / (number + 1)
            noisy = np.clip(truth[image] + strength * rng.standard_normal(truth[image].shape), 0, 255).astype(np.uint8)
            renderings.append(noisy)
            maps.append(coded(ssim_map(noisy, truth[image])))
            images.append(image)
            moment_of.append(number)
    return Distortions(
        scene=name,
        scene_hash=f"{seed:064d}",
        photographs=tuple(truth),
        moments=moments,
        renderings=tuple(renderings),
        maps=tuple(maps),
        images=tuple(images),
        moment_of=tuple(moment_of),
        geometry=rng.normal(size=(len(renderings), len(VIEW_GEOMETRY))),
        centers=rng.normal(size=(photographs, 3)),
    )


@pytest.fixture(scope="session")
def toys():
    return toy_distortions("toy_1", 1), toy_distortions("toy_2", 2)

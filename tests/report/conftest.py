"""A small factory of episode records."""

import pytest

from avs.nvs.record import CurvePoint, Episode, ImageMetrics
from avs.system.records import write_record

LABELS = {"random": "Random", "farthest": "FVS", "piqe": "PIQE", "fisherrf": "FisherRF", "ours-repvit": "Ours-RepViT"}
GROUPS = {"farthest": "Geometric", "fisherrf": "3D-based"}
ABSENT = {"lpips": "weights vgg16-397923af.pth absent: put them there"}


def images(psnr, ssim, lpips):
    """One entry for each PSNR; SSIM and LPIPS are the same for all."""
    return [
        ImageMetrics(name=f"{index:03d}.png", psnr=value, psnr_per_channel=value + 0.1, ssim=ssim, lpips=lpips)
        for index, value in enumerate(psnr)
    ]


def make_episode(method, scene="attic", seed=0, psnr=(20.0, 22.0), ssim=0.6, lpips=0.3, budget=6, **changes):
    """An episode whose curve climbs by 1 dB a view to the values given, from four views on."""
    protocol = {
        "initial_views": 4,
        "budget": 6,
        "iterations": 100,
        "additions": [20, 45],
        "views_per_step": 1,
        "refit": "continue",
        "lpips": {"net": "vgg", "range": "zero_one"},
    }
    curve = [
        CurvePoint(
            iteration=100 if views == budget else 5 * views,
            views=views,
            primitives=1000,
            images=images([value - (budget - views) for value in psnr], ssim, lpips),
        )
        for views in range(4, budget + 1)
    ]
    fields = {
        "scene": scene,
        "dataset": "orbit",
        "scene_hash": f"hash of {scene}",
        "method": method,
        "label": LABELS.get(method, method),
        "group": GROUPS.get(method, "2D-based"),
        "chooses": "highest",
        "seed": seed,
        "protocol": protocol,
        "representation": {"sh_degree": 3},
        "selector": {},
        "weights_hash": None,
        "initial": ["a.png", "b.png", "c.png", "d.png"],
        "selected": [f"{index}.png" for index in range(budget - 4)],
        "budget": budget,
        "notes": [],
        "absent": ABSENT if lpips is None else {},
        "steps": [],
        "curve": curve,
    }
    return Episode(**(fields | changes))


@pytest.fixture
def episode():
    return make_episode


@pytest.fixture
def written(tmp_path):
    """Write episodes to files and return their paths."""

    def write(episodes):
        paths = []
        for number, each in enumerate(episodes):
            paths.append(tmp_path / "episodes" / f"{number:03d}" / "episode.json")
            write_record(paths[-1], each)
        return paths

    return write

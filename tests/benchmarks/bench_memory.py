"""Bytes that torch's allocator counts in what fills a GPU: networks, their training, the loss, LPIPS.

Run from the root of the repository: ``python -m tests.benchmarks.bench_memory``. ``avs/config/gpu_memory.py`` has what
it prints. Computed on the CPU, whose allocator holds the same tensors; what cuDNN takes beside them is not seen.
Attention keeps its weights here, where a GPU may not.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import torch
from torch.profiler import ProfilerActivity, profile

from avs.config.run_config import ScorerSettings
from avs.iqa.cross_reference import trained_scorer
from avs.iqa.cross_reference.network import CrossReferenceNetwork, build_network
from avs.iqa.cross_reference.scorer_settings import BACKBONE_OF, PATCH
from avs.iqa.cross_reference.training_batches import Batch
from avs.iqa.cross_reference.training_loss import map_loss, predicted_maps
from avs.iqa.resizing import ResizeSettings
from avs.rasterizer.losses import Target, photometric_loss
from avs.system.compatibility import prepare_torch, prepare_torchvision

REFERENCES = 5


def peak(work: Callable[[], object]) -> int:
    """Return the most bytes that torch's allocator held at once in ``work``, beyond what it held before."""
    with profile(activities=[ProfilerActivity.CPU], profile_memory=True) as profiled:
        work()
    events = [event for event in profiled.profiler.kineto_results.events() if event.name() == "[memory]"]
    changes = [event.nbytes() for event in sorted(events, key=lambda event: event.start_ns())]
    return int(np.max(np.cumsum(changes)))


def network_of(scorer: str) -> CrossReferenceNetwork:
    """Return the network of a scorer with random weights."""
    settings = ScorerSettings.model_validate({"network": {"backbone": BACKBONE_OF[scorer]}})
    network = build_network(settings.network, 0)
    network.backbone.requires_grad_(False)
    return network


def scoring(scorer: str, height: int, width: int, batch: int = 4) -> tuple[float, float, float]:
    """Return bytes of a pixel: of an image that is encoded, of one that is scored, of what is kept of a photograph."""
    trained_scorer._CACHED_TOKENS = 2**40  # as on a GPU: all queries at once
    settings = ResizeSettings(side="long", pixels=max(height, width))
    user = trained_scorer.CrossReferenceScorer(network_of(scorer), settings, batch)
    images = np.random.default_rng(0).random((batch, height, width, 3)).astype(np.float32)
    references = (user.encode(images) * 2)[:REFERENCES]
    bytes_of = (peak(lambda: user.queries(images)), peak(lambda: user.score(images, [references] * batch)))
    return (
        *(each / batch / height / width for each in bytes_of),
        references[0].nbytes / height / width,
    )


def training(scorer: str, crop: int) -> float:
    """Return bytes of a query's pixel in a step on encoded images, each query with references of its own.

    It is what two more queries take; gradients of weights are there whatever their number.
    """
    network, side = network_of(scorer), crop // PATCH
    channels = sum(network.backbone.channels)

    def step(queries: int) -> int:
        batch = Batch(
            torch.rand(queries, 1, side, side, channels),
            torch.rand(queries, 1, crop, crop),
            torch.rand(queries, 1, REFERENCES, side, side, channels),
            torch.ones(queries, 1, REFERENCES, dtype=torch.bool),
        )
        return peak(lambda: map_loss(predicted_maps(network, batch), batch.maps).backward())

    return (step(4) - step(2)) / 2 / crop**2


def loss(height: int, width: int) -> float:
    """Return bytes of a pixel of the loss as other devices than the CPU compute it, with its gradient."""
    image = torch.rand(height, width, 3, requires_grad=True)
    target = Target(torch.rand(height, width, 3), moments=None)
    return peak(lambda: photometric_loss(image, target, 0.2).backward()) / height / width


def perceptual(net: str, height: int, width: int) -> float:
    """Return bytes of a pixel of LPIPS of two images."""
    prepare_torchvision()
    import lpips  # once torchvision's operators are there

    model = lpips.LPIPS(net=net, pretrained=False, pnet_rand=True, verbose=False).eval()

    def compare() -> None:
        with torch.inference_mode():
            model(torch.rand(1, 3, height, width), torch.rand(1, 3, height, width))

    return peak(compare) / height / width


def main() -> None:
    """Print all of them."""
    prepare_torch()
    print(f"loss: {loss(400, 600):.0f}")
    for net in ("alex", "vgg"):
        print(f"LPIPS, {net}: {perceptual(net, 400, 600):.0f}")
    for scorer in BACKBONE_OF:
        for size in ((259, 259), (345, 518)):
            encoded, scored, kept = scoring(scorer, *size)
            print(f"{scorer}, {size[1]}x{size[0]}: encoded {encoded:.0f}, scored {scored:.0f}, kept {kept:.0f}")
        weights = sum(parameter.nbytes for parameter in network_of(scorer).parameters())
        print(f"{scorer}: trained {training(scorer, 518):.0f}; weights {weights / 1e6:.1f} MB", flush=True)


if __name__ == "__main__":
    main()

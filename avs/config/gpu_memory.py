"""How much of a GPU's memory a run will take: an estimate from its settings, before anything is computed.

Counted are what lies there all the time (Gaussians with their moments, photographs, weights) and the greatest of what
is needed one after another (a step of the fit, renderings with a network's pass over them, LPIPS). Not counted are
methods with networks of pyiqa, fields that are rendered along rays, and back ends of structure from motion.
"""

from __future__ import annotations

from dataclasses import dataclass

from avs.config.configuration import scorer_of
from avs.config.method_weights import Made, is_program, weights_of
from avs.config.run_config import Config
from avs.datasets.reader import Reader
from avs.iqa.cross_reference.scorer_settings import ENCODED_AT_ONCE, ScorerSettings
from avs.representations.gaussians.gaussian_settings import CAMERAS_PER_BATCH, GaussianSettings
from avs.selection import registry
from avs.selectors.cross_reference import CrossReferenceSettings

ASSUMED_GAUSSIANS = 1_000_000
"""Where growth has no budget: what twenty photographs lead to at most (docs/paper-scale.md)."""

FITTED = 1646
"""Bytes of a Gaussian while a step is taken: the slope of memory over Gaussians in gsplat's published evaluation.

Seven scenes of Mip-NeRF360, 7,000 and 30,000 steps (https://docs.gsplat.studio/main/tests/eval.html); with 0.22 GB
beside, no line is off by more than 2.6 %. All harmonics; parameters, their gradients and both moments are 944 of them.
"""

_KEPT = 4 * 4  # bytes of a parameter, its gradient and two moments
_FLOATS = 11  # parameters of a Gaussian beside its harmonics
_LOSS = 452  # bytes a pixel, avs.rasterizer.losses by conv2d with its gradient
_PHOTOGRAPH = 12
_RENDERING = 20
_LPIPS = {"vgg": 2496, "alex": 253}  # bytes a pixel, two images
_REMEDY = "should it run out, lower the images' size, densification.max_gaussians or the batch"
_CONTEXT = 500_000_000  # what CUDA and its libraries take for themselves


@dataclass(frozen=True)
class NetworkMemory:
    """Bytes that a cross-reference network takes, as torch's allocator counts them.

    Attributes:
        encoded: of one pixel of an image that the backbone sees.
        scored: of one pixel of a rendering in a batch that is scored against five photographs.
        kept: of one pixel of a captured photograph, for its keys and values.
        trained: of one pixel of a query in a step of a training that leaves the backbone as it is.
        weights: of all parameters.
    """

    encoded: int
    scored: int
    kept: int
    trained: int
    weights: int


NETWORKS = {
    "lite0": NetworkMemory(encoded=259, scored=370, kept=21, trained=444, weights=18_100_000),
    "repvit": NetworkMemory(encoded=97, scored=370, kept=21, trained=441, weights=25_400_000),
    "dinov2": NetworkMemory(encoded=123, scored=485, kept=31, trained=530, weights=101_000_000),
}
"""Measured on the CPU at up to 518 x 345 pixels (tests/benchmarks/bench_memory.py)."""


@dataclass(frozen=True)
class Need:
    """What one kind of job takes of a GPU.

    Attributes:
        job: what it is.
        held: bytes that lie there all the time.
        moments: bytes beyond that, by what needs them; one at a time.
    """

    job: str
    held: int
    moments: dict[str, int]

    @property
    def total(self) -> int:
        """Bytes at the greatest."""
        return self.held + max(self.moments.values())

    def __str__(self) -> str:
        """Return one line, in units of 10^9 bytes."""
        greatest = max(self.moments, key=self.moments.__getitem__)
        most = f"{self.held / 1e9:.1f} held and {self.moments[greatest] / 1e9:.1f} for {greatest}"
        return f"{self.job}: about {self.total / 1e9:.1f} GB of a GPU ({most})"


def needs(config: Config) -> list[Need]:
    """Return what the episodes of each data set, and the training of each scorer, take of a GPU.

    Data sets whose image size is not limited are left out, as are trainings of a backbone.
    """
    episodes = (_episode(config, name) for name in config.evaluated)
    trained = dict.fromkeys(
        made.name
        for method in config.methods
        if isinstance(made := weights_of(config, method), Made) and made.rule == "scorer_train"
    )
    trainings = (_training(name, scorer_of(config, name)) for name in trained)
    return [need for need in (*episodes, *trainings) if need is not None]


def told(config: Config, device: int | None) -> list[str]:
    """Return a line for each kind of job, with a warning where it will hardly fit.

    Args:
        config: of the run.
        device: bytes of the smallest GPU that jobs get; None where that is not known.
    """
    few = "" if device is None else f"; the smallest GPU here has {device / 1e9:.1f}: {_REMEDY}"
    return [f"{need}{few if device is not None and need.total > device else ''}" for need in needs(config)]


def pixels_of(dataset: Reader) -> int | None:
    """Return how many pixels an image has at most, of 4:3 where its shape is not known; None: there is no limit."""
    images = getattr(dataset, "capture", dataset)
    for side in ("short", "long"):
        length = getattr(images, f"{side}_side", None)
        if length is not None:
            return _area(side, length)
    return None


def _episode(config: Config, name: str) -> Need | None:
    """Return what the method takes that takes most on a data set."""
    pixels, gaussians = pixels_of(config.datasets[name]), config.representation
    if pixels is None or not isinstance(gaussians, GaussianSettings):
        return None
    views, net = config.protocol.budget, config.protocol.lpips.net
    count = gaussians.densification.max_gaussians or ASSUMED_GAUSSIANS
    kept = _KEPT * (_FLOATS + 3 * (gaussians.sh_degree + 1) ** 2)
    passing = max(FITTED - kept, 0)
    networks = [_pass(config, method, pixels) for method in config.methods_on(name)]
    moments = {
        "a step of the fit": count * passing + pixels * _LOSS,
        # What a step needs beyond the parameters, gradients included, is the most that a rendering can need.
        f"{CAMERAS_PER_BATCH} renderings and their scores": CAMERAS_PER_BATCH * (count * passing + pixels * _RENDERING)
        + max((each for each, _ in networks), default=0),
        "LPIPS": pixels * _LPIPS[net],
    }
    held = _CONTEXT + count * kept + views * pixels * _PHOTOGRAPH + max((each for _, each in networks), default=0)
    return Need(f"an episode of {name}, {count:,} Gaussians", held, moments)


def _pass(config: Config, method: str, pixels: int) -> tuple[int, int]:
    """Return the bytes of a network's pass over a batch of candidates, and of what it keeps; 0 without a network."""
    settings = None if is_program(method) else registry.create_settings(method, config.selectors.get(method, {}))
    if not isinstance(settings, CrossReferenceSettings):
        return 0, 0
    network = NETWORKS[str(registry.find(method).method.scorer)]
    seen = _area(settings.resize.side, settings.resize.pixels)
    passing = settings.batch * (seen * network.scored + pixels * _PHOTOGRAPH)
    return passing, network.weights + config.protocol.budget * seen * network.kept


def _training(name: str, scorer: ScorerSettings) -> Need | None:
    """Return what a step of a training takes; None where its backbone is trained, too."""
    training, network = scorer.training, NETWORKS[name]
    if training.backbone_frozen is False:
        return None
    crop = training.crop**2
    queries = training.batch // training.processes
    seen = queries * (1 + training.references.count) if not training.cache_features else 0
    moments = {
        "the decoder": queries * crop * network.trained,
        "the backbone": ENCODED_AT_ONCE * crop * network.encoded,
    }
    held = _CONTEXT + 4 * network.weights + (seen + queries) * crop * _PHOTOGRAPH
    return Need(f"the training of {name}", held, moments)


def _area(side: str, length: int) -> int:
    """Return how many pixels an image of 4:3 has whose long or short side is ``length``."""
    return int(length**2 * (3 / 4 if side == "long" else 4 / 3))

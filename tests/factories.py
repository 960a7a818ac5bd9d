"""Small scenes and stand-ins for the tests of the loop."""

import numpy as np

from avs.representations.base import Rendering
from avs.scene.cameras import Cameras, look_at
from avs.scene.scene import Points, Scene, read_scene, write_scene
from avs.scene.views import Views
from avs.selection import registry
from avs.selection.choice import select_views
from avs.selection.contract import State
from avs.system.weights import missing


def with_one_bit_flipped(content):
    """Yield ``content`` with one bit flipped, in each of its bytes in turn."""
    generator = np.random.default_rng(0)
    for place in range(len(content)):
        changed = bytearray(content)
        changed[place] ^= 1 << int(generator.integers(8))
        yield bytes(changed)


def ring(count, radius=3.0, size=(24, 16)):
    """Return cameras on a circle that look at the origin."""
    angles = 2 * np.pi * np.arange(count) / count
    centers = np.stack([radius * np.cos(angles), radius * np.sin(angles), np.ones(count)], axis=1)
    transforms = np.stack([look_at(center, np.zeros(3), np.array([0.0, 0.0, 1.0])) for center in centers])
    width, height = size
    intrinsics = np.tile(np.array([[20.0, 0, width / 2], [0, 20.0, height / 2], [0, 0, 1]]), (count, 1, 1))
    return Cameras(transforms, intrinsics, np.tile(np.array([size], dtype=np.int64), (count, 1)))


def small_scene(folder, count=40, name="toy", size=(24, 16), darkest=40) -> Scene:
    """Write and read a scene of ``count`` flat pictures on a ring; picture i is brighter the larger i."""
    cameras = ring(count, size=size)
    images = tuple(np.full((size[1], size[0], 3), darkest + 4 * i, dtype=np.uint8) for i in range(count))
    rng = np.random.default_rng(0)
    points = Points(
        positions=rng.normal(size=(12, 3)),
        colors=rng.integers(0, 256, (12, 3), dtype=np.uint8),
        observations=np.array([[p, i] for p in range(12) for i in (p, p + 1, p + 2)], dtype=np.int64),
    )
    write_scene(
        folder,
        name=name,
        dataset="toys",
        names=tuple(f"{i:03d}.png" for i in range(count)),
        images=images,
        cameras=cameras,
        test=np.arange(0, count, 8),
        points=points,
        source="made by a test",
        licence="none",
    )
    return read_scene(folder)


def named_views(cameras, images):
    """Return views whose names are their numbers."""
    return Views(cameras, tuple(images), tuple(f"{number:03d}.png" for number in range(len(cameras))))


def state_of(representation, captured, candidates, rng=None, step=0, truth=None):
    """Return a state whose candidates are named by their numbers."""
    names = tuple(f"candidate_{row}.png" for row in range(len(candidates)))
    return State(representation, captured, candidates, names, rng or np.random.default_rng(0), step, truth)


def selected(identifier, selector, state, k):
    """Let a selector of a registered method choose, as the loop does."""
    return select_views(registry.find(identifier).method, selector, state, k)


class MeanColor:
    """A representation that renders the mean of the views that it was fitted to; it keeps count of its steps."""

    def __init__(self):
        self.primitives = 1
        self.iteration = 0
        self.fits = []
        self._mean = 0.0

    def fit(self, views, iterations):
        self.iteration += iterations
        self.fits.append((len(views), iterations))
        self._mean = float(np.mean([image.mean() for image in views.images])) / 255

    def render(self, cameras):
        (width, height), _ = next(cameras.by_size())
        shape = (len(cameras), height, width)
        return Rendering(
            np.full((*shape, 3), self._mean, dtype=np.float32),
            np.ones(shape, dtype=np.float32),
            np.ones(shape, dtype=np.float32),
        )


class OnlyRenders:
    """Hands on ``render`` and raises on anything else: what a 2D method may use of a representation."""

    def __init__(self, representation):
        self._representation = representation

    def render(self, cameras):
        return self._representation.render(cameras)

    def __getattr__(self, name):
        raise AssertionError(f"a 2D method asked the representation for {name}")


def methods_that_run():
    """Return the identifiers of the methods that choose by themselves and whose pretrained weights are here, if any."""
    return [
        name
        for name, found in sorted(registry.methods().items())
        if missing(found.method.pretrained) is None and found.method.follows is None
    ]


def write_regression(path, pixels):
    """Write the regressions of a fit to random numbers, of renderings of a long side of ``pixels``; return the path."""
    from avs.iqa.render_statistics.pixel_statistics import PIXEL_STATISTICS
    from avs.iqa.render_statistics.regression_file import FittedRegressions, RegressionFacts, write_regressions
    from avs.iqa.render_statistics.regression_fit import ALL_STATISTICS
    from avs.iqa.render_statistics.regression_settings import RegressionSettings
    from avs.iqa.render_statistics.ssim_regression import Sample, fit_regression

    rng = np.random.default_rng(5)
    statistics = rng.normal(size=(30, len(ALL_STATISTICS)))
    columns = {"seen": ALL_STATISTICS, "pixels": PIXEL_STATISTICS}
    fits = {
        name: fit_regression([Sample(statistics[:, : len(read)], rng.random(30), np.arange(30) // 10)], read, 0.1)
        for name, read in columns.items()
    }
    settings = RegressionSettings(resize={"side": "long", "pixels": pixels})
    facts = RegressionFacts(settings=settings, scenes=1, candidates=30, held_out=0, candidate_spearman={"seen": None})
    write_regressions(path, FittedRegressions(fits, facts))
    return path

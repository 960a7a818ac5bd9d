"""What every method promises, whatever it is: checked for each one that is found and can run here."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from factories import MeanColor, OnlyRenders, methods_that_run, named_views, ring, selected, state_of, write_regression

from avs.representations.capabilities import CAPABILITIES
from avs.selection import registry
from avs.selection.contract import PreparesRepresentation, Resources, Truth
from avs.system.errors import UserError
from tests import tolerances

ROOT = Path(__file__).resolve().parents[2]
CANDIDATES, CAPTURED = 5, 3
# NIQE's windows of 96 pixels need two of them in each direction.
SIZE = (256, 192)
SCORED_AT = {False: 256, True: 112}  # long side in pixels, by whether the method is a trained scorer
# The rows of the benchmark. A method may be added without a line here, but none of these may go.
IDENTIFIERS = {
    *(
        "random",
        "farthest",
        "activenerf",
        "activenerf-views",
        "fisherrf",
        "fisherrf4",
        "fisherrf4-released",
        "warprf",
        "popgs",
        "gauss-mi",
    ),
    *("brisque", "niqe", "piqe", "nima", "musiq", "maniqa", "tres", "topiq", "ours-repvit", "ours-dinov2"),
    *("ours-lite0", "ours-diverse", "statistics"),
    *("oracle-ssim", "oracle-psnr", "oracle-gain"),
}
RENDERS_ONLY = ("2D-based", "Geometric")

METHODS = methods_that_run()
every_method = pytest.mark.parametrize("identifier", METHODS)


@cache
def cloud():
    from avs.representations.gaussians.initialization import PointCloud

    rng = np.random.default_rng(0)
    return PointCloud(rng.normal(size=(60, 3)) * 0.7, rng.random((60, 3)))


def splats():
    from avs.representations.gaussians.gaussian_settings import GaussianSettings
    from avs.representations.gaussians.splats import GaussianSplats

    return GaussianSplats(cloud(), 1.0, GaussianSettings(iterations=200), np.random.default_rng(1), "cpu")


@cache
def photographs():
    """All views of a ring, as the untrained Gaussians look from there."""
    cameras = ring(CANDIDATES + CAPTURED + 1, size=SIZE)
    return named_views(cameras, tuple(np.round(image * 255).astype(np.uint8) for image in splats().render(cameras).rgb))


@pytest.fixture(scope="module")
def weights(tmp_path_factory):
    """Return the weights of a method, of an untrained scorer or a made-up regression; each file is made once."""
    from avs.config.configuration import load
    from avs.iqa.cross_reference.network import build_network
    from avs.iqa.cross_reference.scorer_checkpoint import save_network

    folder = tmp_path_factory.mktemp("scorers")

    @cache
    def scorer(name):
        import yaml

        values = yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text())
        settings = load(values).scorers[name].network
        path = folder / f"{name}.safetensors"
        save_network(path, build_network(settings, seed=0))
        return path

    def make(identifier):
        method = registry.find(identifier).method
        if method.fallback == "statistics":
            return write_regression(folder / "statistics.safetensors", SCORED_AT[False])
        return None if method.scorer is None else scorer(method.scorer)

    return make


@pytest.fixture(scope="module")
def created(weights):
    """Make a method's selector, and a reconstruction prepared for it."""

    def create(identifier):
        method = registry.find(identifier).method
        resize = {"resize": {"side": "long", "pixels": SCORED_AT[method.scorer is not None]}}
        values = resize if "resize" in method.settings.model_fields else {}
        resources = Resources(weights(identifier))
        selector = method.build(registry.create_settings(identifier, values), resources)
        representation = splats()
        if isinstance(selector, PreparesRepresentation):
            selector.prepare(representation)
        representation.fit(photographs()[range(CAPTURED)], 2)
        return selector, OnlyRenders(representation) if method.group in RENDERS_ONLY else representation

    return create


@pytest.fixture(scope="module")
def kept(created):
    """As ``created``, made once for all tests."""
    return cache(created)


def make_state(identifier, representation, rows, captured=range(CAPTURED)):
    """Return a state whose candidates are the photographs at ``rows``."""
    views, method = photographs(), registry.find(identifier).method
    truth = Truth(views[rows], views[[CAPTURED + CANDIDATES]]) if method.oracle else None
    return state_of(representation, views[captured], views.cameras[rows], np.random.default_rng(7), 0, truth)


ALL = tuple(range(CAPTURED, CAPTURED + CANDIDATES))


def test_every_row_of_the_benchmark_has_its_method():
    assert set(registry.methods()) >= IDENTIFIERS


@every_method
def test_metadata_are_complete(identifier):
    method = registry.find(identifier).method
    assert method.label
    assert method.source.endswith(".")
    assert method.oracle == (method.group == "Oracle")
    assert registry.create_settings(identifier, {}) == method.settings()
    assert set(method.needs) <= CAPABILITIES.keys()
    assert method.settings().needs in (None, method.needs)


@every_method
def test_the_same_seed_gives_the_same_choice_of_finite_scores(identifier, created, kept):
    first, second = (
        selected(identifier, selector, make_state(identifier, representation, ALL), 2)
        for selector, representation in (created(identifier), kept(identifier))
    )
    assert first.indices.dtype == np.int64
    assert first.indices.tolist() == second.indices.tolist()
    assert first.scores.tolist() == second.scores.tolist()
    assert first.scores.shape == (CANDIDATES,)
    assert np.isfinite(first.scores).all()
    scored = np.ones(CANDIDATES, dtype=bool) if first.scored is None else first.scored
    best = max if registry.find(identifier).method.chooses == "highest" else min
    assert first.scores[first.indices[0]] == best(first.scores[scored])


@every_method
def test_one_candidate_and_all_candidates_can_be_chosen(identifier, kept):
    selector, representation = kept(identifier)
    every = selected(identifier, selector, make_state(identifier, representation, ALL), CANDIDATES)
    assert sorted(every.indices.tolist()) == list(range(CANDIDATES))
    only = selected(identifier, selector, make_state(identifier, representation, ALL[:1]), 1)
    assert only.indices.tolist() == [0]
    assert only.scores.shape == (1,)


@every_method
def test_ties_go_to_the_lowest_index(identifier, kept):
    if identifier == "random":
        pytest.skip("random numbers do not tie")
    selector, representation = kept(identifier)
    rows = (ALL[0],) * 3
    selection = selected(identifier, selector, make_state(identifier, representation, rows, captured=(0, 0, 0)), 2)
    np.testing.assert_allclose(selection.scores, selection.scores[0], rtol=tolerances.SAME_IMAGE_IN_A_BATCH)
    if len(set(selection.scores.tolist())) == 1:
        assert selection.indices.tolist() == [0, 1]


@every_method
def test_a_missing_capability_is_one_line(identifier, weights):
    """A representation that only renders serves, or the line names the method and what is missing."""
    method = registry.find(identifier).method
    if method.group in RENDERS_ONLY:
        pytest.skip("needs rendering alone")
    selector = method.build(registry.create_settings(identifier, {}), Resources())

    def use(representation):
        if isinstance(selector, PreparesRepresentation):
            selector.prepare(representation)
        selected(identifier, selector, make_state(identifier, representation, ALL), 1)

    if not method.needs:
        use(MeanColor())
        return
    with pytest.raises(UserError) as caught:
        use(MeanColor())
    found = re.fullmatch(f"{identifier}: needs the capability (\\w+), which MeanColor lacks; .+", str(caught.value))
    assert found
    assert found[1] in method.needs


def test_hidden_photographs_are_shown_to_oracles_alone():
    oracles = {identifier for identifier in METHODS if registry.find(identifier).method.oracle}
    assert oracles == {"oracle-ssim", "oracle-psnr", "oracle-gain"}


@cache
def heavy_libraries(code):
    """Return which of the libraries that take long to import come with what ``code`` imports."""
    heavy = ("torch", "open3d", "pyiqa", "pycolmap", "numba", "timm")
    code = f"{code}; import sys; print(*(name for name in {heavy} if name in sys.modules))"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    return result.stdout.split()


@every_method
def test_metadata_are_read_without_heavy_libraries(identifier):
    assert heavy_libraries(f"import {registry.find(identifier).module}") == []


def test_all_metadata_are_found_without_heavy_libraries():
    assert heavy_libraries("from avs.selection import registry; registry.methods()") == []

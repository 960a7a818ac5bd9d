"""The cross-reference selector with a scorer that is easy to foresee."""

import dataclasses

import numpy as np
import pytest
import torch
from factories import OnlyRenders, named_views, ring, selected, state_of

from avs.iqa.cross_reference.network import build_network
from avs.iqa.cross_reference.published_weights import published_weights
from avs.iqa.cross_reference.scorer_checkpoint import save_network
from avs.iqa.cross_reference.scorer_settings import DINOv2Settings, ReferenceSettings, RepViTSettings, ScorerSettings
from avs.iqa.cross_reference.training_facts import TrainingFacts
from avs.representations.base import Rendering
from avs.selection import registry
from avs.selection.contract import Resources
from avs.selectors.cross_reference import (
    CrossReferenceSelector,
    CrossReferenceSettings,
    DiverseSelector,
    DiverseSettings,
    discounted,
)
from avs.system.errors import UserError
from avs.system.weights.cache import VARIABLE


class Brightness:
    """A stand-in for the scorer: an image's score is its mean; it keeps what it was asked."""

    def __init__(self):
        self.encoded = []
        self.references = []

    def encode(self, images):
        self.encoded += [int(image.flat[0]) for image in images]
        return [torch.full((2, 4), float(image.flat[0])) for image in images]

    def score(self, images, references):
        self.references += [[int(tokens[0, 0]) for tokens in some] for some in references]
        return images.mean(axis=(1, 2, 3), dtype=np.float64)


class Heights:
    """Renders each camera in a grey that depends on the camera alone."""

    def __init__(self, greys):
        self._greys = greys

    def render(self, cameras):
        (width, height), indices = next(cameras.by_size())
        assert len(indices) == len(cameras)
        greys = np.array([self._greys[tuple(center.round(6))] for center in cameras.centers], dtype=np.float32)
        rgb = np.broadcast_to(greys[:, None, None, None], (len(cameras), height, width, 3))
        return Rendering(rgb, np.ones(rgb.shape[:3], np.float32), np.ones(rgb.shape[:3], np.float32))


def make_state(captured=6, greys=(0.5, 0.2, 0.9, 0.2, 0.7), sizes=None, seed=0):
    cameras = ring(captured + len(greys))
    candidates = cameras[captured:]
    if sizes is not None:
        candidates = dataclasses.replace(candidates, sizes=np.array(sizes, dtype=np.int64))
    images = tuple(np.full((16, 24, 3), 10 + i, np.uint8) for i in range(captured))
    known = {tuple(center.round(6)): grey for center, grey in zip(candidates.centers, greys, strict=True)}
    views = named_views(cameras[:captured], images)
    return state_of(OnlyRenders(Heights(known)), views, candidates, np.random.default_rng(seed), 0)


def make_selector(scorer, **settings):
    return CrossReferenceSelector(CrossReferenceSettings(**settings), scorer)


@pytest.mark.parametrize("batch", [1, 2, 8])
def test_lowest_scores_are_chosen_and_ties_go_to_the_first(batch):
    selection = selected("ours-repvit", make_selector(Brightness(), batch=batch), make_state(), 3)
    assert selection.indices.tolist() == [1, 3, 0]
    np.testing.assert_allclose(selection.scores, [0.5, 0.2, 0.9, 0.2, 0.7], rtol=1e-6)


def test_candidates_of_several_sizes_keep_their_order():
    sizes = [(24, 16), (16, 24), (24, 16), (16, 24), (8, 8)]
    selection = selected("ours-repvit", make_selector(Brightness(), batch=2), make_state(sizes=sizes), 5)
    np.testing.assert_allclose(selection.scores, [0.5, 0.2, 0.9, 0.2, 0.7], rtol=1e-6)


def test_a_captured_photograph_is_encoded_once_in_an_episode():
    scorer = Brightness()
    selector = make_selector(scorer)
    for captured in (4, 5, 6):
        selected("ours-repvit", selector, make_state(captured), 1)
    assert scorer.encoded == [10, 11, 12, 13, 14, 15]
    selected("ours-repvit", selector, make_state(4), 1)  # another episode, which begins with views that are known
    assert len(scorer.encoded) == 6
    selected("ours-repvit", selector, make_state(5), 1)  # the fifth view has been forgotten in between
    assert scorer.encoded[6:] == [14]


def test_random_references_are_drawn_for_each_candidate_and_repeat_with_the_seed():
    draws = []
    for seed in (0, 0, 1):
        scorer = Brightness()
        selected("ours-repvit", make_selector(scorer), make_state(8, seed=seed), 1)
        draws.append(scorer.references)
        assert all(len(set(some)) == 5 for some in scorer.references)
    assert draws[0] == draws[1] != draws[2]
    assert len({tuple(sorted(some)) for some in draws[0]}) > 1


def test_nearest_references_are_the_nearest_camera_centres():
    scorer = Brightness()
    state = make_state(8)
    selected("ours-repvit", make_selector(scorer, references=ReferenceSettings(count=3, choice="nearest")), state, 1)
    for center, some in zip(state.candidates.centers, scorer.references, strict=True):
        distances = np.linalg.norm(state.captured.cameras.centers - center, axis=1)
        expected = sorted(range(8), key=lambda i: (distances[i], i))[:3]
        assert [value - 10 for value in some] == expected


@pytest.mark.parametrize(("pad", "numbers"), [("none", 3), ("black", 5)])
def test_missing_references_are_left_out_or_black(pad, numbers):
    scorer = Brightness()
    selected("ours-repvit", make_selector(scorer, references=ReferenceSettings(pad=pad)), make_state(3), 1)
    for some in scorer.references:
        assert len(some) == numbers
        assert sorted(some)[-3:] == [10, 11, 12]
        assert some.count(0) == numbers - 3


@pytest.mark.parametrize(("identifier", "scorer"), [("ours-repvit", "repvit"), ("ours-dinov2", "dinov2")])
def test_method_needs_weights(identifier, scorer):
    method = registry.find(identifier).method
    assert method.chooses == "lowest"
    assert method.scorer == scorer
    with pytest.raises(UserError, match=f"needs the weights of the scorer {scorer}"):
        method.selector(method.settings(), Resources())


def test_method_refuses_the_weights_of_the_other(tmp_path):
    path = tmp_path / "weights.safetensors"
    save_network(path, build_network(RepViTSettings(), seed=0))
    selector = registry.find("ours-repvit").method.build(CrossReferenceSettings(), Resources(path))
    (note,) = selector.notes
    assert note == "Ours-RepViT: weights of a training that is not recorded (the paper's are not published)"
    with pytest.raises(UserError, match="holds a network on repvit_m0_9, where vit_small_patch14_dinov2 is needed"):
        registry.find("ours-dinov2").method.build(CrossReferenceSettings(), Resources(path))


def test_a_note_says_that_weights_are_not_the_published_ones(tmp_path):
    path = tmp_path / "weights.safetensors"
    save_network(path, build_network(DINOv2Settings(), seed=0))
    selector = registry.find("ours-dinov2").method.build(CrossReferenceSettings(), Resources(path))
    (note,) = selector.notes
    assert note.endswith("(for the published ones: python -m avs weights fetch crossscore)")


@pytest.mark.parametrize(
    ("backbone", "frozen", "said"),
    [
        (None, True, "on a backbone with random weights that stay as they are; held out"),
        (None, False, "on a backbone with random weights that are trained, too; held out"),
        ("repvit.safetensors", True, "on a backbone with the pretrained weights repvit.safetensors that stay as they"),
    ],
)
def test_a_note_tells_how_the_weights_were_trained(tmp_path, backbone, frozen, said):
    path = tmp_path / "weights.safetensors"
    held_out = {"held_out": 2, "spearman": 0.876, "candidate_spearman": None}
    facts = TrainingFacts(backbone=backbone, frozen=frozen, steps=400, scenes=1, **held_out)
    save_network(path, build_network(RepViTSettings(), seed=0), facts)
    (note,) = registry.find("ours-repvit").method.build(CrossReferenceSettings(), Resources(path)).notes
    assert note.startswith("Ours-RepViT: weights trained by this run on 1 scene in 400 steps, on a backbone with ")
    assert said in note
    assert (
        "held out (2 scenes), the rank correlation with the true SSIM is 0.88 over all their renderings together and "
        "undefined" in note
    )
    assert note.endswith("with other photographs as references (the paper's are not published)")


def test_published_weights_are_used_where_they_are(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    settings = ScorerSettings(network=DINOv2Settings())
    assert published_weights("dinov2", settings) is None
    path = tmp_path / "crossscore" / "CrossScore-v1.0.0.ckpt"
    path.parent.mkdir()
    path.touch()
    assert published_weights("dinov2", settings) == path
    assert published_weights("dinov2", ScorerSettings(network=DINOv2Settings(), published=False)) is None
    assert published_weights("repvit", ScorerSettings()) is None


class WithMaps(Brightness):
    """Predicts the image's mean everywhere."""

    def maps(self, images, references):
        self.references += [[int(tokens[0, 0]) for tokens in some] for some in references]
        return np.broadcast_to(images.mean(axis=(1, 2, 3))[:, None, None], (len(images), 8, 12)).copy()


def test_the_map_of_a_candidate_comes_from_the_photographs_that_its_score_came_from():
    scorer, state = WithMaps(), make_state()
    selector = make_selector(scorer)
    scores = selector.score(state)
    asked = list(scorer.references)
    for row in (3, 1):
        found = selector.predicted_map(state, row)
        assert found.shape == (8, 12)
        np.testing.assert_allclose(found, scores[row], rtol=1e-6)
        assert scorer.references[-1] == asked[row]


LINE = np.array([[0.1, 0, 0], [1, 0, 0], [1.1, 0, 0], [3, 0, 0], [4, 0, 0]])
ORIGIN = np.zeros((1, 3))


def test_lack_of_quality_is_discounted_near_captured_views_alone():
    found = discounted(np.full(5, 0.8), LINE, ORIGIN, near=0.5, k=1)
    np.testing.assert_allclose(found.scores, 0.8 * np.array([0.1 / 1.1, 1 / 1.1, 1, 1, 1]))
    assert found.indices.tolist() == [2]


def test_a_chosen_view_counts_as_captured():
    lack = np.array([0.9, 0.8, 0.7, 0.3, 0.2])
    found = discounted(lack, LINE, ORIGIN, near=0.5, k=5)
    assert found.indices.tolist() == [1, 3, 4, 0, 2]  # the second worst stands beside the first, and waits
    assert found.scores[1] == max(found.scores)


def test_a_view_at_a_captured_place_comes_last():
    found = discounted(np.array([0.9, 0.1]), np.array([[0.0, 0, 0], [1, 0, 0]]), ORIGIN, near=1.0, k=2)
    assert found.indices.tolist() == [1, 0]
    assert found.scores[0] == 0


def test_candidates_at_captured_places_only_are_taken_in_order():
    assert discounted(np.ones(3), np.zeros((3, 3)), ORIGIN, near=0.5, k=3).indices.tolist() == [0, 1, 2]


def test_diverse_scores_are_the_networks_scores_discounted():
    state = make_state()
    selection = selected("ours-diverse", DiverseSelector(DiverseSettings(near=1.0), Brightness()), state, 2)
    own = make_selector(Brightness()).score(state)
    apart = np.linalg.norm(state.candidates.centers[:, None] - state.captured.cameras.centers, axis=2).min(axis=1)
    np.testing.assert_allclose(selection.scores, (1 - own) * apart / apart.max())

"""The pictures that an episode keeps: which, how exact, how they are vouched for, and that nothing depends on them."""

import dataclasses
import hashlib
import zipfile

import numpy as np
import pytest
import torch
from factories import MeanColor, small_scene

from avs.nvs.evaluation import Evaluator
from avs.nvs.loop import Identity, Plan, run
from avs.nvs.picture_settings import PICTURES, PictureSettings
from avs.nvs.pictures import archive, final_rows, read_pictures, shrunk, write_pictures
from avs.nvs.protocol import ProtocolSettings
from avs.selection.contract import Method, Selection
from avs.system.errors import UserError
from metrics.image import ssim_map

PROTOCOL = ProtocolSettings(initial_views=4, budget=7, additions=(10, 25, 45), iterations=100)
SETTINGS = PictureSettings(test_images=3)


class First:
    """Chooses the first k candidates, and predicts a map that rises from left to right."""

    def select(self, state, k):
        return Selection(np.arange(k), -np.arange(len(state.candidates), dtype=float))

    def predicted_map(self, state, row):
        return np.tile(np.linspace(-0.5, 1.5, 12, dtype=np.float32), (8, 1))


class Broken(First):
    """Predicts a map with a hole."""

    def predicted_map(self, state, row):
        return np.full((8, 12), np.nan)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene(tmp_path_factory.mktemp("pictures") / "toy")


def outcome(scene, selector=None, pictures=SETTINGS, protocol=PROTOCOL):
    selector = selector or First()
    method = Method("First", "2D-based", "A test.", "highest", lambda settings, resources: selector)
    evaluate = Evaluator(scene, protocol.lpips)
    identity = Identity("first", 0, {}, {})
    plan = Plan(scene, protocol, identity, method, selector, lambda _: MeanColor(), evaluate, lambda _: None)
    return run(dataclasses.replace(plan, pictures=pictures))


@pytest.fixture
def kept(scene, tmp_path):
    """The record and the pictures of an episode, as they are read back."""
    found = outcome(scene)
    write_pictures(tmp_path, found.pictures)
    return found.record, read_pictures(tmp_path / "episode.json", found.record)


def test_an_episode_keeps_final_renderings_and_those_of_the_chosen_views(kept, scene):
    record, pictures = kept
    finals = [f"final_{place:03d}" for place in range(3)]
    choices = [f"choice_{step:02d}_0_{kind}" for step in range(3) for kind in ("predicted", "rendering", "true")]
    assert sorted(pictures) == sorted(finals + choices)
    assert record.pictures.test == [scene.names[scene.test[row]] for row in (0, 2, 4)]
    assert pictures["final_000"].shape == (16, 24, 3)
    # The reconstruction is the mean of the seven views; JPEG of one colour is exact to a level.
    mean = np.mean([40 + 4 * scene.names.index(name) for name in record.initial + record.selected])
    np.testing.assert_allclose(pictures["final_000"], mean, atol=1.01)


def test_maps_are_grey_and_cut_to_what_a_similarity_can_be(kept, scene):
    record, pictures = kept
    predicted = pictures["choice_00_0_predicted"]
    assert predicted.shape == (8, 12)
    assert predicted[:, :2].max() < 20
    assert predicted[:, -2:].min() > 235
    (chosen,) = record.steps[1].chosen
    photograph = scene.views([scene.names.index(chosen)]).images[0]
    rendering = pictures["choice_01_0_rendering"]
    expected = 255 * np.clip(ssim_map(rendering, photograph), 0, 1)
    np.testing.assert_allclose(pictures["choice_01_0_true"], expected, atol=12)  # both are JPEG


def test_views_chosen_together_are_told_apart_by_their_place(scene, tmp_path):
    found = outcome(scene, protocol=PROTOCOL.model_copy(update={"views_per_choice": 3}))
    write_pictures(tmp_path, found.pictures)
    names = read_pictures(tmp_path / "episode.json", found.record)
    assert {f"choice_00_{place}_true" for place in range(3)} < set(names)


def test_the_episode_is_the_same_without_pictures(scene):
    with_pictures, without = outcome(scene), outcome(scene, pictures=None)
    assert without.record.pictures is None
    assert with_pictures.record.model_copy(update={"pictures": None}) == without.record
    assert without.pictures == archive({})


def test_equal_episodes_give_equal_bytes_that_the_record_vouches_for(scene):
    first, second = outcome(scene), outcome(scene)
    assert first.pictures == second.pictures
    assert first.record.pictures.sha256 == hashlib.sha256(first.pictures).hexdigest()


def test_a_changed_or_missing_archive_is_one_line(scene, tmp_path):
    found = outcome(scene)
    path = tmp_path / PICTURES
    with pytest.raises(UserError, match=r"pictures.zip: no such file"):
        read_pictures(tmp_path / "episode.json", found.record)
    changed = bytearray(found.pictures)
    changed[100] ^= 1
    path.write_bytes(changed)
    with pytest.raises(UserError, match="is not the file that the record beside it tells of"):
        read_pictures(tmp_path / "episode.json", found.record)


def test_any_program_opens_the_archive(scene, tmp_path):
    write_pictures(tmp_path, outcome(scene).pictures)
    with zipfile.ZipFile(tmp_path / PICTURES) as opened:
        assert opened.testzip() is None
        assert opened.read("final_000.jpg").startswith(b"\xff\xd8")


def test_a_record_without_pictures_has_none(scene, tmp_path):
    assert read_pictures(tmp_path / "episode.json", outcome(scene, pictures=None).record) == {}


def test_a_map_that_is_none_is_a_fault_of_the_method(scene):
    with pytest.raises(ValueError, match="Broken predicted a map that is no array"):
        outcome(scene, Broken())


class Meddling(First):
    """Does something to what it is shown when it predicts a map."""

    def __init__(self, meddle):
        self.meddle = meddle

    def predicted_map(self, state, row):
        self.meddle(state)
        return super().predicted_map(state, row)


@pytest.mark.parametrize(
    ("meddle", "told"),
    [
        (lambda state: state.representation.fit(state.captured, 5), "went on fitting the reconstruction"),
        (lambda state: torch.set_grad_enabled(False), "changed settings of torch .* the gradient mode"),
        (lambda state: write_into(state.captured.images[0]), "wrote into the photographs"),
    ],
)
def test_a_map_that_changes_what_the_episode_goes_on_with_is_refused(scene, meddle, told):
    with pytest.raises(UserError, match=f"method First: {told}"):
        outcome(scene, Meddling(meddle))
    assert torch.is_grad_enabled()


def write_into(image):
    image.setflags(write=True)
    image[0, 0] ^= 1


def test_cameras_that_a_method_changes_in_place_are_not_those_of_the_pictures(scene):
    def moved(state):
        state.candidates.world_to_camera[:] = 0
        state.candidates.sizes[:] = 1

    assert outcome(scene, Meddling(moved)).pictures == outcome(scene).pictures


@pytest.mark.parametrize(("count", "wanted", "expected"), [(6, 3, [0, 2, 5]), (2, 6, [0, 1]), (5, 1, [0]), (5, 0, [])])
def test_test_images_are_spread_evenly(count, wanted, expected):
    assert final_rows(count, PictureSettings(test_images=wanted)) == expected


def test_large_pictures_are_made_smaller():
    assert shrunk(np.zeros((600, 1200, 3), dtype=np.uint8), 400).shape == (200, 400, 3)
    assert shrunk(np.zeros((1200, 600), dtype=np.uint8), 400).shape == (400, 200)
    assert shrunk(np.zeros((40, 60), dtype=np.uint8), 400).shape == (40, 60)

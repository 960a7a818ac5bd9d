import numpy as np
import pytest
import torch

from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.resizing import ResizeSettings, resized, target_size, to_tensor
from tests.tolerances import BFLOAT16_SCORE, FLOAT32_NETWORK


def _pictures(count, height=40, width=60, seed=0):
    return np.random.default_rng(seed).integers(0, 256, (count, height, width, 3), dtype=np.uint8)


@pytest.fixture(scope="module")
def scorer(network):
    return CrossReferenceScorer(network, ResizeSettings(pixels=70), batch=2)


@pytest.mark.parametrize(
    ("side", "pixels", "size"),
    [("long", 518, (345, 518)), ("short", 518, (518, 777)), ("long", 192, (128, 192)), ("long", 14, (14, 14))],
)
def test_target_size(side, pixels, size):
    assert target_size(1066, 1600, ResizeSettings(side=side, pixels=pixels)) == size


def test_pixels_become_floats_in_the_unit_range():
    images = _pictures(2)
    expected = torch.from_numpy(images.astype(np.float32) / 255).permute(0, 3, 1, 2)
    torch.testing.assert_close(to_tensor(images), expected)
    floats = np.array([[[[-0.5, 0.25, 1.5]]]], dtype=np.float32)
    assert to_tensor(floats).flatten().tolist() == [0, 0.25, 1]
    with pytest.raises(ValueError, match="expected"):
        to_tensor(images[0])
    frozen = images.copy()
    frozen.flags.writeable = False
    torch.testing.assert_close(to_tensor(frozen), expected)


def test_resizing_keeps_what_has_the_size_and_does_not_alias():
    checkerboard = np.indices((64, 64)).sum(axis=0) % 2
    images = to_tensor(np.repeat(checkerboard[None, :, :, None], 3, axis=-1).astype(np.float32))
    assert resized(images, ResizeSettings(pixels=64)) is images
    small = resized(images, ResizeSettings(pixels=16))[..., 2:-2, 2:-2]
    torch.testing.assert_close(small, torch.full_like(small, 0.5), rtol=0, atol=0.02)


def test_score_is_the_mean_of_the_map(scorer):
    references = scorer.encode(_pictures(3, seed=1))
    images = _pictures(5)
    maps = scorer.maps(images, [references] * 5)
    assert maps.shape == (5, 42, 70)  # 47x70 pixels after resizing, in whole tokens
    np.testing.assert_array_equal(scorer.score(images, [references] * 5), maps.mean(axis=(1, 2), dtype=np.float64))


def test_batches_and_merging_change_nothing(network, scorer):
    other = CrossReferenceScorer(network, ResizeSettings(pixels=70), batch=16)
    images = _pictures(5)
    scores = [each.score(images, [each.encode(_pictures(3, seed=1))] * 5) for each in (scorer, other)]
    np.testing.assert_allclose(scores[0], scores[1], atol=FLOAT32_NETWORK)
    plain = to_tensor(np.concatenate([images, _pictures(3, seed=1)]))
    with torch.inference_mode():
        tokens = network.encode(resized(plain, ResizeSettings(pixels=70)))
        memory = network.memory(tokens[5:].reshape(1, -1, 256)).expand(5, -1, -1)
        expected = network.predict(tokens[:5], memory).mean(dim=(1, 2))
    np.testing.assert_allclose(scores[0], expected.numpy(), atol=FLOAT32_NETWORK)


def test_numbers_and_sizes_of_references_may_differ(scorer):
    """A batch of mixed lists equals each image scored alone."""
    square, wide = scorer.encode(_pictures(2, 60, 60)), scorer.encode(_pictures(1, 40, 60))
    lists = [square, wide, [*square, *wide]]
    images = _pictures(3, seed=2)
    together = scorer.score(images, lists)
    alone = [scorer.score(image[None], [some])[0] for image, some in zip(images, lists, strict=True)]
    np.testing.assert_allclose(together, alone, atol=FLOAT32_NETWORK)


def test_an_image_needs_a_reference(scorer):
    with pytest.raises(ValueError, match="at least one reference"):
        scorer.score(_pictures(1), [[]])


def test_lower_precision_ranks_alike(network, scorer):
    """The rounding of bfloat16 moves a score by far less than scores differ."""
    lower = CrossReferenceScorer(network, ResizeSettings(pixels=70), batch=2, precision="bfloat16")
    pictures = _pictures(6).astype(np.float32) / 255
    pictures *= np.linspace(0.2, 1, 6, dtype=np.float32)[:, None, None, None]
    scores = [each.score(pictures, [each.encode(_pictures(3, seed=1))] * 6) for each in (scorer, lower)]
    np.testing.assert_allclose(*scores, rtol=0, atol=BFLOAT16_SCORE)
    np.testing.assert_array_equal(lower.score(pictures, [lower.encode(_pictures(3, seed=1))] * 6), scores[1])

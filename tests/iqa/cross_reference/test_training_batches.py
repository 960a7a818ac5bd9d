import dataclasses

import numpy as np
import pytest
import torch

from avs.iqa.cross_reference.distortions import decoded
from avs.iqa.cross_reference.scorer_settings import ReferenceSettings, TrainingSettings
from avs.iqa.cross_reference.training_batches import Sampler
from avs.iqa.resizing import ResizeSettings
from avs.system.errors import UserError


def _settings(**changes):
    values = {
        "resize": ResizeSettings(side="long", pixels=56),
        "crop": 28,
        "batch": 6,
        "queries_per_set": 3,
        "references": ReferenceSettings(count=5),
    }
    return TrainingSettings(**{**values, **changes})


def _numbered(scene):
    """A scene whose photograph i is all i, rendering j is all 100 + j, and map j is all j / 100."""
    return dataclasses.replace(
        scene,
        photographs=tuple(np.full_like(image, i) for i, image in enumerate(scene.photographs)),
        renderings=tuple(np.full_like(image, 100 + j) for j, image in enumerate(scene.renderings)),
        maps=tuple(np.full_like(code, round((j / 100 + 1) * 32767)) for j, code in enumerate(scene.maps)),
    )


@pytest.mark.parametrize("pool", ["scene", "captured"])
def test_references_never_show_the_view_of_a_query(toys, pool):
    scene = _numbered(toys[0])
    sampler = Sampler([scene], _settings(reference_pool=pool), np.random.default_rng(0))
    for _ in range(20):
        batch = sampler.batch()
        for number in range(2):
            rows = (batch.queries[number, :, 0, 0, 0] * 255).round().int() - 100
            torch.testing.assert_close(batch.maps[number, :, 0, 0], rows / 100, rtol=0, atol=1e-4)
            moments = {scene.moment_of[row] for row in rows.tolist()}
            assert len(moments) == 1
            values = (batch.references[number, 0, :, 0, 0, 0] * 255).round().int()
            references = values[batch.present[number, 0]].tolist()
            assert len(set(references)) == len(references) > 0
            assert not {scene.images[row] for row in rows.tolist()} & set(references)
            if pool == "captured":
                assert set(references) <= set(scene.moments[moments.pop()].captured)
            else:
                assert len(references) == 5


@pytest.mark.parametrize("pool", ["scene", "captured"])
def test_each_query_has_the_references_nearest_to_it(toys, pool):
    scene = _numbered(toys[0])
    references = ReferenceSettings(count=2, choice="nearest")
    sampler = Sampler([scene], _settings(references=references, reference_pool=pool), np.random.default_rng(0))
    for _ in range(10):
        batch = sampler.batch()
        assert batch.references.shape[:3] == (2, 3, 2)
        rows = (batch.queries[..., 0, 0, 0] * 255).round().int() - 100
        found = (batch.references[..., 0, 0, 0] * 255).round().int()
        for row, images in zip(rows.flatten().tolist(), found.flatten(0, 1).tolist(), strict=True):
            own = scene.images[row]
            captured = scene.moments[scene.moment_of[row]].captured
            others = [
                image for image in (captured if pool == "captured" else range(len(scene.photographs))) if image != own
            ]
            distances = {image: float(np.linalg.norm(scene.centers[image] - scene.centers[own])) for image in others}
            assert images == sorted(others, key=distances.__getitem__)[:2]


def test_query_and_map_share_a_crop(toys):
    scene = toys[0]
    # the map holds the rendering's red channel, so that equal crops show
    maps = tuple(np.round((image[..., 0] / 255 + 1) * 32767).astype(np.uint16) for image in scene.renderings)
    sampler = Sampler([dataclasses.replace(scene, maps=maps)], _settings(), np.random.default_rng(1))
    batch = sampler.batch()
    torch.testing.assert_close(batch.maps, batch.queries[:, :, 0], rtol=0, atol=1e-4)
    assert batch.queries.shape == (2, 3, 3, 28, 28)
    assert batch.references.shape == (2, 1, 5, 3, 28, 28)


@pytest.mark.parametrize(("pad", "full"), [("none", False), ("black", True)])
def test_missing_references_are_absent_or_black(toys, pad, full):
    settings = _settings(references=ReferenceSettings(count=7, pad=pad), reference_pool="captured")
    batch = Sampler([toys[0]], settings, np.random.default_rng(2)).batch()
    assert bool(batch.present.all()) == full
    assert float(batch.references[:, :, -1].abs().max()) == 0


def test_same_seed_draws_the_same_batches(toys):
    first, second = (Sampler(list(toys), _settings(), np.random.default_rng(3)) for _ in range(2))
    for _ in range(3):
        one, other = first.batch(), second.batch()
        assert all(torch.equal(getattr(one, name), getattr(other, name)) for name in ("queries", "maps", "references"))


def test_images_are_resized_with_their_maps(toys):
    sampler = Sampler([toys[0]], _settings(resize=ResizeSettings(pixels=42), crop=42), np.random.default_rng(4))
    batch = sampler.batch()
    means = sorted(float(decoded(code).mean()) for code in toys[0].maps)
    assert all(min(abs(float(m.mean()) - mean) for mean in means) < 0.01 for m in batch.maps.flatten(0, 1))


def test_images_smaller_than_a_crop_are_refused(toys):
    with pytest.raises(UserError, match=r"toy_1: its images have a side of 56 pixels"):
        Sampler([toys[0]], _settings(crop=70), np.random.default_rng(0))

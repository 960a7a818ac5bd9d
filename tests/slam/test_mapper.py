"""The mapper on rooms whose every measure is known: growth, windows, pruning, gradients of poses, planted errors."""

import math

import numpy as np
import pytest
import torch
from mapped_views import CAMERA, PIXELS, errors_of, view

from avs.slam.building.simulator import Frame
from avs.slam.mapping.gaussian_map import empty_map, gaussians_of, map_rendering, points_of
from avs.slam.mapping.keyframes import as_keyframe, overlapping, window_of
from avs.slam.mapping.map_optimization import grown, lesson, mapping_loss, optimised
from avs.slam.mapping.mapper import Mapper
from avs.slam.mapping.mapper_settings import (
    RELEASED_MAPPING,
    GrowthSettings,
    KeyframeSettings,
    MapperSettings,
    PruningSettings,
)
from avs.slam.mapping.mapper_state import mapper_arrays, restore_mapper


def rng():
    return np.random.default_rng(0)


def test_the_first_frame_gives_every_pixel_a_gaussian_of_its_size():
    frame, camera = view()
    tensors = grown(empty_map(), frame, camera, GrowthSettings(), rng())
    assert len(tensors["means"]) == PIXELS
    middle = 36 * 96 + 48
    assert tensors["scales"][middle].exp().item() == pytest.approx(frame.depth[36, 48] / 48, rel=1e-5)
    assert torch.allclose(tensors["opacities"], torch.zeros(()))
    # back in the camera, every point lies at its own pixel's centre
    local = tensors["means"].detach().numpy() @ camera.world_to_camera[0, :3, :3].T + camera.world_to_camera[0, :3, 3]
    pixels = local[:, :2] / local[:, 2:] * 48 + [48, 36]
    rows, columns = np.divmod(np.arange(PIXELS), 96)
    assert np.allclose(pixels, np.stack([columns, rows], 1) + 0.5, atol=1e-3)


def test_stride_takes_fewer_and_larger():
    frame, camera = view()
    fine = grown(empty_map(), frame, camera, GrowthSettings(), rng())
    coarse = grown(empty_map(), frame, camera, GrowthSettings(stride=4), rng())
    assert len(coarse["means"]) == len(fine["means"]) // 16
    assert coarse["scales"].mean().item() == pytest.approx(fine["scales"].mean().item() + math.log(4), abs=0.02)


def test_what_is_explained_gets_nothing_and_what_is_empty_does():
    frame, camera = view()
    tensors = grown(empty_map(), frame, camera, GrowthSettings(), rng())
    tensors, _ = optimised(tensors, [lesson(frame, camera)], MapperSettings(), 2.0, rng())
    same = grown(tensors, frame, camera, GrowthSettings(), rng())
    assert len(same["means"]) - len(tensors["means"]) < 0.02 * PIXELS
    other = grown(tensors, *view(yaw=math.pi), GrowthSettings(), rng())
    assert len(other["means"]) - len(tensors["means"]) > 0.95 * PIXELS


def test_what_appears_in_front_of_the_map_is_added():
    frame, camera = view()
    tensors = grown(empty_map(), frame, camera, GrowthSettings(), rng())
    tensors, _ = optimised(tensors, [lesson(frame, camera)], MapperSettings(), 2.0, rng())
    depth = frame.depth.copy()
    depth[20:40, 20:40] = 0.5
    nearer = grown(tensors, Frame(frame.rgb, depth), camera, GrowthSettings(error_factor=10), rng())
    assert 380 <= len(nearer["means"]) - len(tensors["means"]) <= 450


def test_spacing_makes_what_was_seen_from_afar_as_dense_as_what_is_near():
    tensors = grown(empty_map(), *view(x=0.3), GrowthSettings(), rng())
    tensors, _ = optimised(tensors, [lesson(*view(x=0.3))], MapperSettings(), 2.0, rng())
    near = view(x=2.0, y=0.5)
    sparse = grown(tensors, *near, GrowthSettings(), rng())
    dense = grown(tensors, *near, GrowthSettings(spacing=0.03), rng())
    assert len(dense["means"]) > len(sparse["means"]) + 200
    again = grown(dense, *near, GrowthSettings(spacing=0.03), rng())
    assert len(again["means"]) - len(dense["means"]) <= len(sparse["means"]) - len(tensors["means"]) + 5


def test_a_limit_on_gaussians_holds():
    frame, camera = view()
    tensors = grown(empty_map(), frame, camera, GrowthSettings(max_gaussians=100), rng())
    assert len(tensors["means"]) == 100
    assert len(grown(tensors, *view(yaw=math.pi), GrowthSettings(max_gaussians=100), rng())["means"]) == 100


def test_a_frame_without_depth_adds_nothing():
    frame, camera = view()
    blind = Frame(frame.rgb, np.zeros_like(frame.depth))
    mapper = Mapper(MapperSettings(), 0)
    mapper.add(blind, camera)
    assert len(mapper.tensors["means"]) == 0
    mapper.add(frame, camera)
    assert len(mapper.tensors["means"]) > 0


def test_optimisation_lowers_the_loss_and_keyframes_are_eight_bits():
    mapper = Mapper(MapperSettings(keyframes=KeyframeSettings(every=1)), 0)
    frame, camera = view()
    mapper.tensors = grown(empty_map(), frame, camera, GrowthSettings(), mapper.rng)
    before = mapping_loss(mapper.tensors, lesson(frame, camera), mapper.settings).item()
    for _ in range(3):
        mapper.add(frame, camera)
    after = mapping_loss(mapper.tensors, lesson(frame, camera), mapper.settings).item()
    assert after < 0.5 * before
    assert mapper.keyframes[0].rgb.dtype == np.uint8
    assert mapper.keyframes[0].millimetres.dtype == np.uint16
    assert np.abs(mapper.keyframes[0].frame.depth - frame.depth).max() <= 0.0005 + 1e-6


def test_faint_and_large_gaussians_are_pruned():
    frame, camera = view()
    tensors = grown(empty_map(), frame, camera, GrowthSettings(), rng())
    with torch.no_grad():
        tensors["opacities"][:10] = -8.0
        tensors["scales"][10:15] = 1.0
    settings = MapperSettings(iterations=1, pruning=PruningSettings(iterations=(0,)))
    kept, _ = optimised(tensors, [lesson(frame, camera)], settings, 2.0, rng())
    assert len(kept["means"]) == len(tensors["means"]) - 15
    none = MapperSettings(iterations=1, pruning=PruningSettings(iterations=()))
    assert len(optimised(tensors, [lesson(frame, camera)], none, 2.0, rng())[0]["means"]) == len(tensors["means"])


def test_only_keyframes_that_see_the_same_overlap():
    keyframes = [as_keyframe(k, *view(yaw=yaw)) for k, yaw in enumerate((0.0, math.pi / 2, math.pi, -math.pi / 2, 0.2))]
    found = overlapping(*view(yaw=0.1), keyframes, KeyframeSettings(), rng())
    assert {0, 4} <= set(found)
    assert 2 not in found
    window = window_of(*view(yaw=0.1), keyframes, KeyframeSettings(window=3), rng())
    assert window[0] == 4
    assert len(window) == 2


def test_points_of_a_wall_lie_on_it():
    frame, camera = view(yaw=math.pi)
    points = points_of(frame, camera, frame.depth > 0)
    on = [
        np.abs(points[:, 0]),
        np.abs(points[:, 1]),
        np.abs(points[:, 1] - 3),
        np.abs(points[:, 2]),
        np.abs(points[:, 2] - 2.5),
    ]
    assert np.min(on, axis=0).max() < 1e-5


SHORT = MapperSettings(keyframes=KeyframeSettings(every=1), iterations=30)


def test_planted_errors_show():
    clean, clean_color, _ = errors_of(SHORT)
    scaled, _, _ = errors_of(SHORT, lambda frame, camera: (Frame(frame.rgb, frame.depth * np.float32(1.02)), camera))
    noise = np.random.default_rng(1)

    def moved(frame, camera):
        pose = camera.world_to_camera.copy()
        pose[0, :3, 3] += noise.normal(0, 0.05, 3)
        return frame, type(camera)(pose, camera.intrinsics, camera.sizes)

    assert clean == pytest.approx(1.0, abs=0.02)  # blended over edges, it is a little short
    assert scaled / clean == pytest.approx(1.02, abs=0.004)
    assert errors_of(SHORT, moved)[1] > 1.3 * clean_color


def test_a_mapper_that_was_stored_goes_on_to_the_bit():
    settings = RELEASED_MAPPING.model_copy(update={"map_every": 2, "iterations": 5})
    whole, first, second = (Mapper(settings, 3) for _ in range(3))
    frames = [view(yaw=0.2 * k) for k in range(6)]
    for frame in frames:
        whole.add(*frame)
    for frame in frames[:3]:
        first.add(*frame)
    arrays, values = mapper_arrays(first)
    restore_mapper(second, {name: array.copy() for name, array in arrays.items()}, values)
    for frame in frames[3:]:
        second.add(*frame)
    for (name, one), other in zip(mapper_arrays(whole)[0].items(), mapper_arrays(second)[0].values(), strict=True):
        assert np.array_equal(one, other), name
    assert whole.rng.bit_generator.state == second.rng.bit_generator.state


def test_rendered_depth_is_blended_and_not_divided():
    frame, camera = view()
    one = {
        name: torch.nn.Parameter(value)
        for name, value in gaussians_of(frame, camera, frame.depth > 0, 0.3, 0.4).items()
    }
    width, height = CAMERA.width, CAMERA.height
    seen = map_rendering(
        one,
        *(torch.tensor(m[0], dtype=torch.float32) for m in (camera.world_to_camera, camera.intrinsics)),
        width,
        height,
    )
    assert 0.2 < seen.alpha.mean() < 0.9
    ratio = seen.depth / seen.alpha
    assert np.allclose(ratio.detach().numpy()[36, 60:], frame.depth[36, 60:], rtol=0.2)

"""Coverage on clouds whose numbers are known, against plain loops and Open3D, and the toolbox's convention by hand."""

import numpy as np
import pytest

from avs.system.compatibility import import_open3d
from metrics.coverage import (
    agreement,
    extent,
    mean_f_score,
    nearest_distances,
    representatives,
    share_nearer,
    toolbox_agreement,
    voxel_means,
)
from tests import tolerances


def grid(size, step=1.0, height=0.0):
    """A square of ``size`` x ``size`` points on a plane."""
    x, y = np.meshgrid(np.arange(size) * step, np.arange(size) * step, indexing="ij")
    return np.stack([x.ravel(), y.ravel(), np.full(x.size, height)], axis=1)


def sphere(count, radius=1.0, seed=0):
    directions = np.random.default_rng(seed).normal(size=(count, 3))
    return radius * directions / np.linalg.norm(directions, axis=1, keepdims=True)


def turned(points, scale=1.0, shift=(0.0, 0.0, 0.0), seed=3):
    rotation = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return scale * points @ rotation.T + np.array(shift)


def both(cloud, reference):
    return nearest_distances(cloud, reference), nearest_distances(reference, cloud)


def test_a_plane_is_covered_where_a_half_of_it_is():
    whole = grid(20)
    half = whole[whole[:, 0] < 10]
    of_cloud, of_reference = both(half, whole)
    assert share_nearer(of_reference, 0.5) == 0.5
    assert share_nearer(of_reference, 1.5) == 0.55  # one further column of points is a step away
    assert agreement(of_cloud, of_reference, 0.5).precision == 1.0
    assert agreement(of_cloud, of_reference, 0.5).f_score == pytest.approx(2 / 3)


def test_shells_are_apart_by_the_difference_of_their_radii():
    inner, outer = sphere(3000), sphere(3000) * 1.2
    of_cloud, of_reference = both(outer, inner)
    assert of_cloud == pytest.approx(np.full(3000, 0.2), abs=tolerances.COVERAGE_SHELLS)
    assert agreement(of_cloud, of_reference, 0.19).f_score == 0.0
    assert agreement(of_cloud, of_reference, 0.21).f_score == 1.0


def test_a_distance_equal_to_the_threshold_is_not_nearer():
    plane, above = grid(5), grid(5, height=0.25)
    of_reference = nearest_distances(plane, above)
    assert share_nearer(of_reference, 0.25) == 0.0
    assert share_nearer(of_reference, np.nextafter(0.25, 1)) == 1.0


def test_floaters_lower_the_precision_and_nothing_else():
    whole = grid(10)
    floaters = whole + np.array([0.0, 0.0, 40.0])
    clean, dirty = both(whole, whole), both(np.concatenate([whole, floaters]), whole)
    assert agreement(*clean, 0.1) == agreement(*both(whole[::-1], whole), 0.1)
    assert agreement(*dirty, 0.1).recall == agreement(*clean, 0.1).recall == 1.0
    assert agreement(*dirty, 0.1).precision == 0.5


def test_the_f_score_is_the_same_with_the_clouds_exchanged():
    first, second = sphere(400, seed=1), sphere(700, 1.05, seed=2)
    one, other = both(first, second), both(second, first)
    for threshold in (0.02, 0.06, 0.2):
        assert agreement(*one, threshold).f_score == agreement(*other, threshold).f_score
        assert agreement(*one, threshold).precision == agreement(*other, threshold).recall
        assert (
            toolbox_agreement(first, second, threshold).f_score == toolbox_agreement(second, first, threshold).f_score
        )


def test_the_mean_over_thresholds_is_that_of_the_f_scores():
    of_cloud, of_reference = np.array([0.05, 0.5, 5.0]), np.array([0.05, 0.05, 5.0])
    # thresholds 0.1 and 1: precision 1/3 and 2/3, recall 2/3 and 2/3
    assert mean_f_score(of_cloud, of_reference, (0.1, 1.0)) == pytest.approx((4 / 9 + 2 / 3) / 2)


@pytest.mark.parametrize("definition", ["robust_box", "bounding_box"])
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_no_share_depends_on_units_and_place(definition, scale):
    rng = np.random.default_rng(0)
    reference = sphere(2000) * [1.0, 2.0, 3.0]
    cloud = reference[rng.random(2000) < 0.6] + rng.normal(size=(1, 3)) * 0.01
    moved = [scale * points + scale * np.array([30.0, -20.0, 5.0]) for points in (cloud, reference)]
    size = extent(reference, definition)
    assert extent(moved[1], definition) == pytest.approx(scale * size, rel=tolerances.COVERAGE_UNITS)
    before = agreement(*both(cloud, reference), 0.01 * size)
    after = agreement(*both(*moved), 0.01 * scale * size)
    assert (after.precision, after.recall) == pytest.approx((before.precision, before.recall))


@pytest.mark.parametrize("seed", range(3))
def test_a_turned_scene_has_the_same_numbers(seed):
    reference = sphere(2000) * [1.0, 2.0, 3.0]
    cloud = reference[:1500] + np.array([0.01, 0.0, 0.0])
    moved = [turned(points, 7.0, (1.0, 2.0, 3.0), seed) for points in (cloud, reference)]
    size = extent(reference)
    assert extent(moved[1]) == pytest.approx(7.0 * size, rel=tolerances.COVERAGE_UNITS)
    assert mean_f_score(*both(*moved), [0.07 * size]) == pytest.approx(
        mean_f_score(*both(cloud, reference), [0.01 * size])
    )


def test_stray_points_move_the_bounding_box_alone():
    cloud = sphere(5000)
    dirty = np.concatenate([cloud, [[1e6, 0.0, 0.0], [0.0, -1e6, 0.0]]])
    assert extent(dirty) == pytest.approx(extent(cloud), rel=tolerances.COVERAGE_STRAY)
    assert extent(dirty, "bounding_box") > 1e5
    # Along each axis of a sphere 98 % of the points lie within 0.98 of the radius.
    assert extent(cloud) == pytest.approx(2 * 0.98 * 3**0.5, rel=tolerances.COVERAGE_STRAY)


def test_representatives_are_points_of_the_cloud_one_a_voxel():
    rng = np.random.default_rng(1)
    cloud = rng.uniform(size=(4000, 3))
    rows = representatives(cloud, 0.1)
    assert len(rows) == len(voxel_means(cloud, 0.1)) <= 11**3
    assert (np.diff(rows) > 0).all()
    cells = np.floor((cloud - cloud.min(axis=0)) / 0.1 + 0.5)
    assert len(np.unique(cells[rows], axis=0)) == len(rows)
    for row in rows[:50]:
        members = cloud[(cells == cells[row]).all(axis=1)]
        nearest = np.linalg.norm(members - members.mean(axis=0), axis=1).min()
        assert np.linalg.norm(cloud[row] - members.mean(axis=0)) == pytest.approx(nearest)


def test_density_has_no_weight():
    sparse, dense = grid(10), grid(100, 0.01, height=0.0) + np.array([30.0, 0.0, 0.0])
    reference = np.concatenate([sparse, dense])
    kept = reference[representatives(reference, 1.0)]
    share = share_nearer(nearest_distances(kept, sparse), 0.5)
    assert share == pytest.approx(100 / (100 + 4))  # the dense patch of one unit touches four voxels
    assert share_nearer(nearest_distances(reference, sparse), 0.5) < 0.01


def test_voxel_means_are_those_of_open3d():
    cloud = sphere(3000) * [3.0, 2.0, 1.0] + 5.0
    twin = import_open3d().geometry.PointCloud(import_open3d().utility.Vector3dVector(cloud)).voxel_down_sample(0.13)
    own, other = voxel_means(cloud, 0.13), np.asarray(twin.points)
    assert len(own) == len(other)
    assert nearest_distances(own, other).max() < tolerances.COVERAGE_DISTANCE
    assert nearest_distances(other, own).max() < tolerances.COVERAGE_DISTANCE


def test_distances_are_those_of_open3d_and_of_a_plain_loop():
    first, second = sphere(300, seed=5), sphere(200, 1.3, seed=6)
    geometry, vectors = import_open3d().geometry, import_open3d().utility.Vector3dVector
    twin = geometry.PointCloud(vectors(first)).compute_point_cloud_distance(geometry.PointCloud(vectors(second)))
    looped = [min(np.linalg.norm(point - other) for other in second) for point in first]
    assert nearest_distances(first, second) == pytest.approx(np.asarray(twin), abs=tolerances.COVERAGE_DISTANCE)
    assert nearest_distances(first, second) == pytest.approx(looped, abs=tolerances.COVERAGE_DISTANCE)


def test_the_toolbox_down_samples_both_clouds_at_half_the_threshold():
    """With a threshold of 2 voxels are 1 wide, and the first begins half a voxel before the least coordinates."""
    cloud = np.array([[0.0, 0, 0], [0.4, 0, 0], [3.0, 0, 0], [9.0, 0, 0]])  # means at 0.2, 3 and 9
    reference = np.array([[0.0, 0, 0], [5.0, 0, 0], [5.4, 0, 0], [7.0, 0, 0]])  # means at 0, 5.2 and 7
    assert voxel_means(cloud, 1.0)[:, 0] == pytest.approx([0.2, 3.0, 9.0])
    assert voxel_means(reference, 1.0)[:, 0] == pytest.approx([0.0, 5.2, 7.0])
    found = toolbox_agreement(cloud, reference, 2.0)
    # cloud to reference 0.2, 2.2, 2: one of three is nearer than 2; reference to cloud 0.2, 2.2, 2: one of three
    assert (found.precision, found.recall, found.f_score) == pytest.approx((1 / 3, 1 / 3, 1 / 3))
    raw = agreement(*both(cloud, reference), 2.0)
    assert raw.precision == pytest.approx(2 / 4)
    assert raw.recall == pytest.approx(1 / 4)


def test_an_empty_cloud_covers_nothing():
    none, plane = np.zeros((0, 3)), grid(4)
    assert np.isinf(nearest_distances(plane, none)).all()
    assert share_nearer(nearest_distances(plane, none), 1e9) == 0.0
    for found in (agreement(*both(none, plane), 1.0), toolbox_agreement(none, plane, 1.0)):
        assert (found.precision, found.recall, found.f_score) == (0.0, 0.0, 0.0)
    assert len(representatives(none, 1.0)) == len(voxel_means(none, 1.0)) == 0


@pytest.mark.parametrize("points", [[[0.0, np.nan, 0.0]], [[np.inf, 0.0, 0.0]], [[0.0, 1.0]], [0.0, 1.0, 2.0]])
def test_what_is_no_cloud_is_refused(points):
    for function in (extent, lambda cloud: representatives(cloud, 1.0), lambda cloud: nearest_distances(cloud, cloud)):
        with pytest.raises(ValueError, match=r"finite numbers \[n, 3\]"):
            function(points)


def test_no_extent_of_nothing_and_no_voxels_of_no_size():
    with pytest.raises(ValueError, match="without points"):
        extent(np.zeros((0, 3)))
    for voxel in (0.0, -1.0, np.nan):
        with pytest.raises(ValueError, match="edge greater than 0"):
            representatives(grid(2), voxel)

"""Rays through the tree of triangles, against every triangle in float64 and against Embree (Open3D)."""

import numpy as np
import pytest

from avs.datasets.embedded.geometry.ray_search import any_triangle, first_triangles
from avs.datasets.embedded.geometry.ray_tree import build_tree
from avs.datasets.embedded.geometry.raycast import Caster
from avs.system.compatibility import import_open3d
from tests import tolerances


def _mesh(kind):
    """Return vertices ``[v, 3]`` and triangles ``[t, 3]`` of a mesh that is awkward in one respect."""
    generator = np.random.default_rng(0)
    if kind == "one triangle":
        return np.float32([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]])
    centres = generator.uniform(-1, 1, (900, 1, 3))
    corners = centres + generator.normal(size=(900, 3, 3)) * 0.08
    if kind == "one place":
        corners = generator.normal(size=(900, 3, 3)) * 0.2
        corners -= (corners.min(axis=1) + corners.max(axis=1))[:, None] / 2
    elif kind == "in a plane":
        corners[..., 2] = 0.25
    elif kind == "sizes from 1e-4 to 1":
        corners = centres + (corners - centres) * 10.0 ** generator.uniform(-4, 1, (900, 1, 1))
    elif kind == "without area":
        corners[::2, 2] = corners[::2, 1]
    elif kind == "spaced by powers":
        corners = corners * 1.05 ** -np.arange(900)[:, None, None]
    return corners.reshape(-1, 3).astype(np.float32), np.arange(2700).reshape(-1, 3)


KINDS = (
    "scattered",
    "one triangle",
    "one place",
    "in a plane",
    "sizes from 1e-4 to 1",
    "without area",
    "spaced by powers",
)


def _rays(count=2000):
    generator = np.random.default_rng(1)
    origins, directions = generator.uniform(-1.5, 1.5, (count, 3)), generator.normal(size=(count, 3))
    directions[::5] = np.eye(3)[generator.integers(0, 3, len(directions[::5]))]  # two numbers are 0
    directions[1::10] = -directions[0::10]
    return np.concatenate([origins, directions], axis=1).astype(np.float32)


def _every_distance(vertices, triangles, rays):
    """Return the distances ``[n, t]`` of triangles along rays in float64, and how far within each the ray passes."""
    first, second, third = (vertices[triangles[:, k]].astype(np.float64) for k in range(3))
    origin, direction = rays[:, None, :3].astype(np.float64), rays[:, None, 3:].astype(np.float64)
    across = np.cross(direction, third - first)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 1 / ((second - first) * across).sum(axis=2)
        away = origin - first
        of_second = (away * across).sum(axis=2) * scale
        around = np.cross(away, second - first)
        of_third = (direction * around).sum(axis=2) * scale
        distance = ((third - first) * around).sum(axis=2) * scale
        within = np.minimum(np.minimum(of_second, of_third), 1 - of_second - of_third)
    met = (within >= 0) & (distance > 0) & np.isfinite(distance)
    return np.where(met, distance, np.inf), np.where(np.isfinite(within), within, -1)


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_triangle_is_that_of_a_search_through_all(kind):
    vertices, triangles = _mesh(kind)
    rays = _rays()
    tree = build_tree(vertices, triangles)
    found = first_triangles(tree, rays)
    distances, within = _every_distance(vertices, triangles, rays)
    nearest = distances.min(axis=1)
    mine = np.where(found >= 0, distances[np.arange(len(rays)), found], np.inf)
    # Where a ray passes a border more closely than float32 can tell, either answer is right.
    doubtful = (np.abs(within) < tolerances.RAY_BORDER).any(axis=1)
    assert doubtful.mean() < 0.02
    sure = ~doubtful
    np.testing.assert_allclose(mine[sure], nearest[sure], rtol=tolerances.RAY_DISTANCE)
    assert np.isfinite(nearest[sure]).any()
    for far in (0.3, 1.0, np.inf):
        near_the_end = (
            np.abs(nearest - far) < tolerances.RAY_DISTANCE * far if np.isfinite(far) else np.zeros(len(rays), bool)
        )
        agreed = any_triangle(tree, rays, far) == (nearest < far)
        assert agreed[sure & ~near_the_end].all()


def test_a_mesh_of_many_levels_is_searched_whole():
    vertices, triangles = _mesh("spaced by powers")
    tree = build_tree(vertices, triangles)
    assert sorted(tree.members[tree.members >= 0]) == list(range(900))
    assert tree.depth >= 3


def test_triangles_that_are_not_finite_lie_nowhere():
    vertices, triangles = _mesh("scattered")
    vertices[3:9] = [[np.nan, 0, 0], [1, 0, np.inf], [0, -np.inf, 0]] * 2
    tree = build_tree(vertices, triangles)
    assert sorted(tree.members[tree.members >= 0]) == [0, *range(3, 900)]
    kept = np.delete(triangles, [1, 2], axis=0)
    here, there = first_triangles(tree, _rays()), first_triangles(build_tree(vertices, kept), _rays())
    np.testing.assert_array_equal(np.where(here > 2, here - 2, here), there)


def test_without_triangles_nothing_is_met():
    tree = build_tree(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int64))
    assert (first_triangles(tree, _rays(7)) == -1).all()
    assert not any_triangle(tree, _rays(7), np.inf).any()


def test_no_ray_leaves_a_closed_surface():
    sphere = import_open3d().geometry.TriangleMesh.create_sphere(1.0, 40)
    vertices, triangles = np.asarray(sphere.vertices, np.float32), np.asarray(sphere.triangles)
    generator = np.random.default_rng(2)
    weights = generator.dirichlet([1, 1, 1], len(triangles))
    weights[::3, 0], weights[1::3, :2] = 0, 0  # on sides, and at corners
    weights[:, 2] += weights.sum(axis=1) == 0
    aims = (weights[..., None] * vertices[triangles]).sum(axis=1) / weights.sum(axis=1, keepdims=True)
    for origin in np.float32([[0, 0, 0], [0.3, -0.2, 0.5], [1e-3, 0.9, 0]]):
        rays = np.concatenate([np.tile(origin, (len(aims), 1)), aims - origin], axis=1).astype(np.float32)
        assert (first_triangles(build_tree(vertices, triangles), rays) >= 0).all()
        assert any_triangle(build_tree(vertices, triangles), rays, np.inf).all()


def test_embree_meets_the_same_surface():
    vertices, triangles = _mesh("scattered")
    rays = _rays(20_000)
    hits = Caster(vertices, triangles.astype(np.int32)).nearest(rays[:, :3], rays[:, 3:])
    core = import_open3d().core
    scene = import_open3d().t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(core.Tensor(vertices), core.Tensor(triangles.astype(np.uint32)))
    answer = scene.cast_rays(core.Tensor(rays), nthreads=1)
    theirs = answer["t_hit"].numpy()
    same = (hits.triangle >= 0) == np.isfinite(theirs)
    assert same.mean() > 0.9999
    met = (hits.triangle >= 0) & np.isfinite(theirs)
    agreed = np.isclose(hits.distance[met], theirs[met], rtol=1e-4, atol=1e-5)
    assert agreed.mean() > 0.9999
    equal = hits.triangle[met] == answer["primitive_ids"].numpy()[met]
    np.testing.assert_allclose(hits.weights[met][equal, 1:], answer["primitive_uvs"].numpy()[met][equal], atol=2e-3)

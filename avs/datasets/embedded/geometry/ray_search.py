"""Rays through a tree of triangles on the CPU: numba, one thread, sixteen boxes or triangles at once.

No operation depends on the kind of processor, so that scenes have the same pixels everywhere. Embree begins with the
processor's approximate reciprocals, and chooses its instructions by itself.
"""

# numba finds the types of the compiled functions when they are first called.
# mypy: disable-error-code="no-untyped-def, no-untyped-call"

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.ray_tree import RayTree
from avs.rasterizer.kernels import Floats, Integers, Number, Numbers, inline, kernel
from avs.rasterizer.simd import absolute, bits_of, fma, lowest_bit, maximum, minimum
from avs.rasterizer.simd_memory import load, store
from avs.rasterizer.simd_types import LANES

_ZERO: Number = np.float32(0)
_ONE: Number = np.float32(1)
# Of a box's far side, against the rounding of three operations: Ize, Robust BVH Ray Traversal, 2013.
_SLACK = np.float32(1 + 4e-7)
# Instead of a direction of 0, whose reciprocal has no use.
_LEAST = np.float32(1e-30)


class Ray(NamedTuple):
    """What the search wants to know of one ray.

    Attributes:
        origin: its start.
        inverse: the reciprocals of its direction.
        sides: where a node has the sides of its boxes by which the ray enters.
        axes: where a leaf has the coordinates of a corner, that along which the ray is longest last.
        turned: its start in that order.
        shear: how far it goes along the first two of them for each step along the last, and the length of such a step.
    """

    origin: Numbers
    inverse: Numbers
    sides: Numbers
    axes: Numbers
    turned: Numbers
    shear: Numbers


def first_triangles(tree: RayTree, rays: npt.NDArray[np.float32]) -> npt.NDArray[np.int64]:
    """Return the triangle ``[n]`` that each of ``rays`` ``[n, 6]``, origin and direction, meets first, or -1."""
    found = np.empty(len(rays), np.int32)
    _first(tree.boxes, tree.children, tree.corners, tree.members, np.ascontiguousarray(rays), tree.depth, found)
    return found.astype(np.int64)


def any_triangle(tree: RayTree, rays: npt.NDArray[np.float32], far: float) -> npt.NDArray[np.bool_]:
    """Return whether each of ``rays`` ``[n, 6]`` meets a triangle before ``far`` lengths of its direction."""
    found = np.empty(len(rays), np.bool_)
    _any(
        tree.boxes,
        tree.children,
        tree.corners,
        tree.members,
        np.ascontiguousarray(rays),
        np.float32(far),
        tree.depth,
        found,
    )
    return found


@inline
def _reciprocal(direction: float) -> Number:
    return _ONE / (direction if abs(direction) > _LEAST else _LEAST)


@inline
def _near_boxes(boxes: Floats, node: int, ray: Ray, far: Number) -> tuple[Number, Number]:
    """Return where a ray enters the sixteen boxes of ``node``, and as bits which it meets before ``far``."""
    at = node * (6 * LANES)
    origin, inverse, sides = ray.origin, ray.inverse, ray.sides
    near_x = (load(boxes, at + sides[0]) - origin[0]) * inverse[0]
    near_y = (load(boxes, at + sides[1]) - origin[1]) * inverse[1]
    near_z = (load(boxes, at + sides[2]) - origin[2]) * inverse[2]
    far_x = (load(boxes, at + 3 * LANES - sides[0]) - origin[0]) * inverse[0]
    far_y = (load(boxes, at + 5 * LANES - sides[1]) - origin[1]) * inverse[1]
    far_z = (load(boxes, at + 7 * LANES - sides[2]) - origin[2]) * inverse[2]
    near = maximum(maximum(near_x, near_y), maximum(near_z, _ZERO))
    beyond = minimum(minimum(far_x, far_y), minimum(far_z, far))
    return near, bits_of(near <= beyond * _SLACK)


@inline
def _along_ray(corners: Floats, at: int, ray: Ray) -> Numbers:
    """Return sixteen corners with the ray's origin as theirs and the ray as their third axis."""
    depth = load(corners, at + ray.axes[2]) - ray.turned[2]
    x = load(corners, at + ray.axes[0]) - ray.turned[0] - ray.shear[0] * depth
    y = load(corners, at + ray.axes[1]) - ray.turned[1] - ray.shear[1] * depth
    return x, y, ray.shear[2] * depth


@inline
def _distances(corners: Floats, leaf: int, ray: Ray, far: Number) -> tuple[Number, Number]:
    """Return the distances of a leaf's sixteen triangles along a ray, and as bits which it meets before ``far``.

    Woop, Benthin and Wald, Watertight ray/triangle intersection, 2013: seen along the ray, each corner is one point for
    all its triangles, and the difference of two rounded products never has the wrong sign, so that no ray slips between
    neighbours. A fused operation would break that.
    """
    at = leaf * (9 * LANES)
    a, b, c = (
        _along_ray(corners, at, ray),
        _along_ray(corners, at + 3 * LANES, ray),
        _along_ray(corners, at + 6 * LANES, ray),
    )
    of_a, of_b, of_c = c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]
    total = of_a + of_b + of_c
    distance = fma(of_a, a[2], fma(of_b, b[2], of_c * c[2])) / total
    inside = bits_of(minimum(minimum(of_a, of_b), of_c) >= _ZERO) | bits_of(maximum(maximum(of_a, of_b), of_c) <= _ZERO)
    return distance, inside & bits_of((absolute(total) > _ZERO) & (distance > _ZERO) & (distance < far))


@inline
def _prepared(rays: Floats, index: int) -> Ray:
    origin = rays[index, 0], rays[index, 1], rays[index, 2]
    x, y, z = rays[index, 3], rays[index, 4], rays[index, 5]
    inverse = _reciprocal(x), _reciprocal(y), _reciprocal(z)
    upper = 3 * LANES
    sides = (
        0 if inverse[0] > 0 else upper,
        LANES if inverse[1] > 0 else upper + LANES,
        2 * LANES if inverse[2] > 0 else upper + 2 * LANES,
    )
    longest = 0 if abs(x) >= max(abs(y), abs(z)) else (1 if abs(y) >= abs(z) else 2)
    first, second = (longest + 1) % 3, (longest + 2) % 3
    step = _ONE / rays[index, 3 + longest]
    return Ray(
        origin,
        inverse,
        sides,
        (first * LANES, second * LANES, longest * LANES),
        (rays[index, first], rays[index, second], rays[index, longest]),
        (rays[index, 3 + first] * step, rays[index, 3 + second] * step, step),
    )


@kernel
def _first(
    boxes: Floats, children: Integers, corners: Floats, members: Integers, rays: Floats, levels: int, found: Integers
) -> None:
    """Write ``first_triangles`` into ``found``. Among triangles at one distance the first that is searched is it."""
    waiting, entered = np.empty(LANES * levels, np.int64), np.empty(LANES * levels, np.float32)
    distances = np.empty(LANES, np.float32)
    for index in range(len(rays)):
        ray = _prepared(rays, index)
        best, nearest = np.float32(np.inf), -1
        waiting[0], entered[0], depth = 0, _ZERO, 1
        while depth > 0:
            depth -= 1
            if entered[depth] > best:
                continue
            node = waiting[depth]
            if node < 0:
                distance, bits = _distances(corners, -1 - node, ray, best)
                if bits:
                    store(distances, 0, distance)
                while bits:
                    lane = lowest_bit(bits)
                    bits &= bits - np.uint32(1)
                    if distances[lane] < best:
                        best, nearest = distances[lane], members[(-1 - node) * LANES + lane]
                continue
            near, bits = _near_boxes(boxes, node, ray, best)
            if bits:
                store(distances, 0, near)
            bottom = depth
            while bits:
                lane = lowest_bit(bits)
                bits &= bits - np.uint32(1)
                place = depth
                while place > bottom and entered[place - 1] < distances[lane]:
                    waiting[place], entered[place] = waiting[place - 1], entered[place - 1]
                    place -= 1
                waiting[place], entered[place] = children[node * LANES + lane], distances[lane]
                depth += 1
        found[index] = nearest


@kernel
def _any(
    boxes: Floats,
    children: Integers,
    corners: Floats,
    members: Integers,
    rays: Floats,
    far: float,
    levels: int,
    found: Integers,
) -> None:
    """Write ``any_triangle`` into ``found``."""
    waiting = np.empty(LANES * levels, np.int64)
    for index in range(len(rays)):
        ray = _prepared(rays, index)
        met = False
        waiting[0], depth = 0, 1
        while depth > 0:
            depth -= 1
            node = waiting[depth]
            if node < 0:
                if _distances(corners, -1 - node, ray, far)[1]:
                    met = True
                    break
                continue
            bits = _near_boxes(boxes, node, ray, far)[1]
            while bits:
                lane = lowest_bit(bits)
                bits &= bits - np.uint32(1)
                waiting[depth] = children[node * LANES + lane]
                depth += 1
        found[index] = met

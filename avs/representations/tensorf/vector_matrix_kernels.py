"""Samples on rays, and vector-matrix lookups with their gradients, on the CPU: numba, one thread.

Planes are ``[3, cells, cells, components]`` and lines ``[3, cells, components]``: the m-th plane lies over the axes
``m`` and ``m + 1`` (modulo 3), its line along the axis that is left. Places are in the contracted cube, -2..2 on each
axis; the first and last cells' centres lie on its faces. ``vector_matrix_twin`` computes the same with torch.
"""

# numba finds the types of the compiled functions when they are first called.
# ruff: noqa: ANN001, ANN201, ANN202
# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from functools import partial

import numba
import numpy as np

from avs.rasterizer.kernels import kernel

_kernel = partial(kernel, fastmath={"contract", "nsz", "arcp", "reassoc", "afn"})
_inline = numba.njit(error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc", "afn"}, inline="always")

_HALF, _ONE, _TWO, _QUARTER = np.float32(0.5), np.float32(1), np.float32(2), np.float32(0.25)


@_inline
def _distance(spacing, turn):
    """Return ``unbounded_space.distance_at`` of one number."""
    if spacing < _HALF:
        return turn * _TWO * spacing
    return turn * _HALF / max(_ONE - spacing, np.float32(1e-6))


@_inline
def _contract(x, y, z):
    """Return ``unbounded_space.contracted`` of one point."""
    largest = max(abs(x), abs(y), abs(z))
    if largest > _ONE:
        factor = (_TWO - _ONE / largest) / largest
        return x * factor, y * factor, z * factor
    return x, y, z


@_inline
def _cell(place, cells):
    """Return the lower of two neighbouring cells and the weight of the upper one."""
    position = (place + _TWO) * _QUARTER * np.float32(cells - 1)
    lower = min(max(int(position), 0), cells - 2)
    return lower, position - np.float32(lower)


@_inline
def _around(planes, lines, place, m):
    """Return the weights and the rows of the four corners around a place on plane ``m`` and of two ends on its line."""
    cells = lines.shape[1]
    i, u = _cell(place[m], cells)
    j, v = _cell(place[(m + 1) % 3], cells)
    k, w = _cell(place[(m + 2) % 3], cells)
    weights = ((_ONE - u) * (_ONE - v), (_ONE - u) * v, u * (_ONE - v), u * v, _ONE - w, w)
    corners = planes[m, i, j], planes[m, i, j + 1], planes[m, i + 1, j], planes[m, i + 1, j + 1]
    return weights, (*corners, lines[m, k], lines[m, k + 1])


@_inline
def _on_plane(weights, rows, n):
    return weights[0] * rows[0][n] + weights[1] * rows[1][n] + weights[2] * rows[2][n] + weights[3] * rows[3][n]


@_inline
def _on_line(weights, rows, n):
    return weights[4] * rows[4][n] + weights[5] * rows[5][n]


@_inline
def _scatter(weights, rows, into, n, gradient):
    """Add to rows ``into``, as ``_around`` gives them, the gradients of component ``n``, given that of its product."""
    by_plane = gradient * _on_line(weights, rows, n)
    by_line = gradient * _on_plane(weights, rows, n)
    into[0][n] += weights[0] * by_plane
    into[1][n] += weights[1] * by_plane
    into[2][n] += weights[2] * by_plane
    into[3][n] += weights[3] * by_plane
    into[4][n] += weights[4] * by_line
    into[5][n] += weights[5] * by_line


@_inline
def _density_feature(planes, lines, place):
    """Return the sum over modes and components of plane times line at one place."""
    total = np.float32(0)
    for m in range(3):
        weights, rows = _around(planes, lines, place, m)
        for n in range(lines.shape[2]):
            total += _on_plane(weights, rows, n) * _on_line(weights, rows, n)
    return total


@_inline
def _softplus(x):
    return x if x > np.float32(20) else np.log(_ONE + np.exp(x))


@_kernel
def march(planes, lines, filled, origins, directions, offsets, numbers, samples):
    """Take samples on rays where something may be, until nothing behind them can be seen.

    Args:
        planes: of the density.
        lines: of the density.
        filled: ``[cells, cells, cells]`` uint8, 0 where no samples are to be taken.
        origins: ``[n, 3]`` in units of the inner box's half side.
        directions: ``[n, 3]``.
        offsets: ``[n]`` in 0..1, where in its interval each sample of a ray lies.
        numbers: where rays begin; the turn of the spacing; shift and scale of the density; least transmittance.
        samples: intervals of each ray.

    Returns:
        For each sample its place ``[m, 3]``, ray ``[m]``, distance ``[m]``, length of its interval times the scale
        ``[m]``, density before the softplus ``[m]``, weight ``[m]`` and transmittance behind it ``[m]``; and where each
        ray's samples start ``[n + 1]``.
    """
    near, turn, shift, scale, least = numbers
    rays, size = len(origins), filled.shape[0]
    room = 1024
    places, owners = np.empty((room, 3), np.float32), np.empty(room, np.int64)
    table = np.empty((5, room), np.float32)
    starts = np.zeros(rays + 1, np.int64)
    begin = near / (_TWO * turn)
    stride = (_ONE - begin) / np.float32(samples)
    place = np.empty(3, np.float32)
    count = 0
    for ray in range(rays):
        if count + samples > room:
            room = 2 * room + samples
            places, owners, table = _grown(places, owners, table, count, room)
        transmittance = _ONE
        origin, direction = origins[ray], directions[ray]
        for sample in range(samples):
            spacing = begin + (np.float32(sample) + offsets[ray]) * stride
            distance = _distance(spacing, turn)
            place[0], place[1], place[2] = _contract(
                origin[0] + distance * direction[0],
                origin[1] + distance * direction[1],
                origin[2] + distance * direction[2],
            )
            i = min(max(int((place[0] + _TWO) * _QUARTER * size), 0), size - 1)
            j = min(max(int((place[1] + _TWO) * _QUARTER * size), 0), size - 1)
            k = min(max(int((place[2] + _TWO) * _QUARTER * size), 0), size - 1)
            if filled[i, j, k] == 0:
                continue
            feature = _density_feature(planes, lines, place) + shift
            first = begin + np.float32(sample) * stride
            length = (_distance(first + stride, turn) - _distance(first, turn)) * scale
            kept = np.exp(-_softplus(feature) * length)
            places[count] = place
            owners[count] = ray
            table[0, count], table[1, count] = distance, length
            table[2, count], table[3, count] = feature, transmittance * (_ONE - kept)
            transmittance *= kept
            table[4, count] = transmittance
            count += 1
            if transmittance < least:
                break
        starts[ray + 1] = count
    return places[:count].copy(), owners[:count].copy(), table[:, :count].copy(), starts


@_inline
def _grown(places, owners, table, count, room):
    more_places, more_owners = np.empty((room, 3), np.float32), np.empty(room, np.int64)
    more = np.empty((5, room), np.float32)
    more_places[:count], more_owners[:count], more[:, :count] = places[:count], owners[:count], table[:, :count]
    return more_places, more_owners, more


@_kernel
def march_backward(planes, lines, places, table, starts, by_weights):
    """Return the gradients of planes and lines, given that of the weights ``[m]`` of ``march``'s samples."""
    by_planes, by_lines = np.zeros_like(planes), np.zeros_like(lines)
    for ray in range(len(starts) - 1):
        behind = np.float32(0)  # of all samples behind: gradient times weight
        for n in range(starts[ray + 1] - 1, starts[ray] - 1, -1):
            length, feature = table[1, n], table[2, n]
            by_depth = by_weights[n] * table[4, n] - behind
            behind += by_weights[n] * table[3, n]
            gradient = by_depth * length / (_ONE + np.exp(-feature))
            if gradient != 0:
                _scatter_density(planes, lines, by_planes, by_lines, places[n], gradient)
    return by_planes, by_lines


@_inline
def _scatter_density(planes, lines, by_planes, by_lines, place, gradient):
    for m in range(3):
        weights, rows = _around(planes, lines, place, m)
        _, into = _around(by_planes, by_lines, place, m)
        for n in range(lines.shape[2]):
            _scatter(weights, rows, into, n, gradient)


@_kernel
def products(planes, lines, places):
    """Return plane times line of each mode and component at places ``[m, 3]``, as ``[m, 3 * components]``."""
    components = lines.shape[2]
    found = np.empty((len(places), 3 * components), np.float32)
    for n in range(len(places)):
        for m in range(3):
            weights, rows = _around(planes, lines, places[n], m)
            out = found[n, m * components : (m + 1) * components]
            for component in range(components):
                out[component] = _on_plane(weights, rows, component) * _on_line(weights, rows, component)
    return found


@_kernel
def products_backward(planes, lines, places, by_products):
    """Return the gradients of planes and lines, given that of ``products``."""
    components = lines.shape[2]
    by_planes, by_lines = np.zeros_like(planes), np.zeros_like(lines)
    for n in range(len(places)):
        for m in range(3):
            weights, rows = _around(planes, lines, places[n], m)
            _, into = _around(by_planes, by_lines, places[n], m)
            by = by_products[n, m * components : (m + 1) * components]
            for component in range(components):
                _scatter(weights, rows, into, component, by[component])
    return by_planes, by_lines


@_kernel
def features_at(planes, lines, places):
    """Return the density before shift and softplus at places ``[m, 3]``, as ``[m]``."""
    found = np.empty(len(places), np.float32)
    for n in range(len(places)):
        found[n] = _density_feature(planes, lines, places[n])
    return found

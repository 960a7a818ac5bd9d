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
def _density_feature(planes, lines, place):
    """Return the sum over modes and components of plane times line at one place."""
    cells, components = lines.shape[1], lines.shape[2]
    total = np.float32(0)
    for m in range(3):
        i, u = _cell(place[m], cells)
        j, v = _cell(place[(m + 1) % 3], cells)
        k, w = _cell(place[(m + 2) % 3], cells)
        a, b, c, d = (_ONE - u) * (_ONE - v), (_ONE - u) * v, u * (_ONE - v), u * v
        p, q, r, s = planes[m, i, j], planes[m, i, j + 1], planes[m, i + 1, j], planes[m, i + 1, j + 1]
        low, high = lines[m, k], lines[m, k + 1]
        for n in range(components):
            total += (a * p[n] + b * q[n] + c * r[n] + d * s[n]) * ((_ONE - w) * low[n] + w * high[n])
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
    cells, components = lines.shape[1], lines.shape[2]
    for m in range(3):
        i, u = _cell(place[m], cells)
        j, v = _cell(place[(m + 1) % 3], cells)
        k, w = _cell(place[(m + 2) % 3], cells)
        a, b, c, d = (_ONE - u) * (_ONE - v), (_ONE - u) * v, u * (_ONE - v), u * v
        p, q, r, s = planes[m, i, j], planes[m, i, j + 1], planes[m, i + 1, j], planes[m, i + 1, j + 1]
        low, high = lines[m, k], lines[m, k + 1]
        at_p, at_q = by_planes[m, i, j], by_planes[m, i, j + 1]
        at_r, at_s = by_planes[m, i + 1, j], by_planes[m, i + 1, j + 1]
        at_low, at_high = by_lines[m, k], by_lines[m, k + 1]
        for n in range(components):
            on_line = gradient * ((_ONE - w) * low[n] + w * high[n])
            on_plane = gradient * (a * p[n] + b * q[n] + c * r[n] + d * s[n])
            at_p[n] += a * on_line
            at_q[n] += b * on_line
            at_r[n] += c * on_line
            at_s[n] += d * on_line
            at_low[n] += (_ONE - w) * on_plane
            at_high[n] += w * on_plane


@_kernel
def products(planes, lines, places):
    """Return plane times line of each mode and component at places ``[m, 3]``, as ``[m, 3 * components]``."""
    cells, components = lines.shape[1], lines.shape[2]
    found = np.empty((len(places), 3 * components), np.float32)
    for n in range(len(places)):
        place = places[n]
        for m in range(3):
            i, u = _cell(place[m], cells)
            j, v = _cell(place[(m + 1) % 3], cells)
            k, w = _cell(place[(m + 2) % 3], cells)
            a, b, c, d = (_ONE - u) * (_ONE - v), (_ONE - u) * v, u * (_ONE - v), u * v
            p, q, r, s = planes[m, i, j], planes[m, i, j + 1], planes[m, i + 1, j], planes[m, i + 1, j + 1]
            low, high = lines[m, k], lines[m, k + 1]
            out = found[n, m * components : (m + 1) * components]
            for c_ in range(components):
                value = a * p[c_] + b * q[c_] + c * r[c_] + d * s[c_]
                out[c_] = value * ((_ONE - w) * low[c_] + w * high[c_])
    return found


@_kernel
def products_backward(planes, lines, places, by_products):
    """Return the gradients of planes and lines, given that of ``products``."""
    cells, components = lines.shape[1], lines.shape[2]
    by_planes, by_lines = np.zeros_like(planes), np.zeros_like(lines)
    for n in range(len(places)):
        place = places[n]
        for m in range(3):
            i, u = _cell(place[m], cells)
            j, v = _cell(place[(m + 1) % 3], cells)
            k, w = _cell(place[(m + 2) % 3], cells)
            a, b, c, d = (_ONE - u) * (_ONE - v), (_ONE - u) * v, u * (_ONE - v), u * v
            p, q, r, s = planes[m, i, j], planes[m, i, j + 1], planes[m, i + 1, j], planes[m, i + 1, j + 1]
            low, high = lines[m, k], lines[m, k + 1]
            at_p, at_q = by_planes[m, i, j], by_planes[m, i, j + 1]
            at_r, at_s = by_planes[m, i + 1, j], by_planes[m, i + 1, j + 1]
            at_low, at_high = by_lines[m, k], by_lines[m, k + 1]
            by = by_products[n, m * components : (m + 1) * components]
            for c_ in range(components):
                on_line = by[c_] * ((_ONE - w) * low[c_] + w * high[c_])
                on_plane = by[c_] * (a * p[c_] + b * q[c_] + c * r[c_] + d * s[c_])
                at_p[c_] += a * on_line
                at_q[c_] += b * on_line
                at_r[c_] += c * on_line
                at_s[c_] += d * on_line
                at_low[c_] += (_ONE - w) * on_plane
                at_high[c_] += w * on_plane
    return by_planes, by_lines


@_kernel
def features_at(planes, lines, places):
    """Return the density before shift and softplus at places ``[m, 3]``, as ``[m]``."""
    found = np.empty(len(places), np.float32)
    for n in range(len(places)):
        found[n] = _density_feature(planes, lines, places[n])
    return found

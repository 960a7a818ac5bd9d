"""Lookups of hashed grids with their gradients on the CPU: numba, one thread. ``hash_grid`` has their torch twin.

Tables are ``[levels, entries, 2]``; a grid with no more corners than entries has one entry for each corner.
"""

# numba finds the types of the compiled functions when they are first called.
# ruff: noqa: ANN001, ANN201, ANN202
# mypy: disable-error-code="no-untyped-def"

from __future__ import annotations

from functools import partial

import numba
import numpy as np

from avs.rasterizer.kernels import kernel

_FAST = {"contract", "nsz", "arcp", "reassoc", "afn"}
_kernel = partial(kernel, fastmath=_FAST)
_inline = numba.njit(error_model="numpy", fastmath=_FAST, inline="always")

PRIME_Y, PRIME_Z = 2654435761, 805459861
"""Of the hash (Müller et al. 2022, arXiv 2201.05989, equation 4)."""

_ONE, _TWO, _QUARTER = np.float32(1), np.float32(2), np.float32(0.25)


@_inline
def _entry(i, j, k, cells, entries):
    side = cells + 1
    if side * side * side <= entries:
        return (i * side + j) * side + k
    return (i ^ (j * PRIME_Y) ^ (k * PRIME_Z)) & (entries - 1)


@_inline
def _cell(place, cells):
    position = (place + _TWO) * _QUARTER * np.float32(cells)
    lower = min(max(int(position), 0), cells - 1)
    return lower, position - np.float32(lower)


@_inline
def _corner(corner, i, j, k, u, v, w, cells, entries):
    """Return the entry of one of the eight corners of a cell, and its weight."""
    a, b, c = corner >> 2, (corner >> 1) & 1, corner & 1
    weight = (u if a else _ONE - u) * (v if b else _ONE - v) * (w if c else _ONE - w)
    return _entry(i + a, j + b, k + c, cells, entries), weight


@_kernel
def looked_up(tables, cells, places):
    """Return the features of all levels at places ``[n, 3]`` in -2..2, ``[n, 2 * levels]``, trilinearly."""
    levels, entries, _ = tables.shape
    found = np.empty((len(places), 2 * levels), np.float32)
    for level in range(levels):
        table, side = tables[level], cells[level]
        for n in range(len(places)):
            i, u = _cell(places[n, 0], side)
            j, v = _cell(places[n, 1], side)
            k, w = _cell(places[n, 2], side)
            first, second = np.float32(0), np.float32(0)
            for corner in range(8):
                entry, weight = _corner(corner, i, j, k, u, v, w, side, entries)
                first += weight * table[entry, 0]
                second += weight * table[entry, 1]
            found[n, 2 * level], found[n, 2 * level + 1] = first, second
    return found


@_kernel
def looked_up_backward(shape, cells, places, by_found):
    """Return the gradient of tables of this shape, given that of ``looked_up``."""
    by_tables = np.zeros(shape, np.float32)
    levels, entries, _ = shape
    for level in range(levels):
        table, side = by_tables[level], cells[level]
        for n in range(len(places)):
            i, u = _cell(places[n, 0], side)
            j, v = _cell(places[n, 1], side)
            k, w = _cell(places[n, 2], side)
            first, second = by_found[n, 2 * level], by_found[n, 2 * level + 1]
            for corner in range(8):
                entry, weight = _corner(corner, i, j, k, u, v, w, side, entries)
                table[entry, 0] += weight * first
                table[entry, 1] += weight * second
    return by_tables

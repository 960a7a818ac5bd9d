"""Whether pictures agree with the intrinsics and the cloud that came with their poses: what no file can tell by itself.

A focal length of another picture size, or a cloud in another frame or unit, is as good a number as the right one. The
reconstruction then learns from it, and nothing but its score would tell. Features matched along epipolar lines tell:
with the right cameras far more of them agree than with any others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from avs.scene.cameras import Cameras, FloatArray, IndexArray
from avs.scene.even_places import evenly_spread
from avs.scene.views import Views
from avs.sfm.guided_points import Features, features_of, guided_matches, triangulated_pairs
from avs.sfm.sfm_settings import GuidedSettings
from avs.sfm.sparse import near_pairs
from avs.system.lists_of_names import some_of

_MOST = 25
"""Views for which other focal lengths are tried, evenly spread over the capture."""

_SETTINGS = GuidedSettings(partners=4)

_SCALES = (0.5, 0.67, 0.8, 0.9, 1.1, 1.25, 1.5, 2.0)
"""Times the focal length, beside once. Over eight real captures and six embedded scenes the right one had more points
than any of these, by a third in the median; for a capture that looks into one direction, 1.1 and .9 had as many."""

_BETTER = 1.1
"""Times as many points that another focal length must have to be told of."""

_FEWEST = 50
"""Points from which their number tells."""

_ASIDE = 0.06
"""Of the distance to the nearest camera, by which half of the points may lie beside the cloud. It was .008 to .05 with
the captures' own clouds, .07 to 1.5 with those turned by a right angle, ten times as large, or of another capture."""

_LONELY = 0.05
"""Of the median number of points that a picture shares with its neighbours, below which it is named.

With two pictures of a capture exchanged, both came to .05 at the most in nine of eleven captures. As they were, the
least of a capture was .12 to .72; but for bonsai, of which some show little that can be told apart.
"""

_OFF_CENTRE = 0.15
"""Of width or height, by which a principal point may lie beside the middle before it is told of."""


def geometry_notes(views: Views, cloud: FloatArray) -> list[str]:
    """Return what speaks against the intrinsics of views with poses, or against the points that came with them.

    Args:
        views: pictures and cameras.
        cloud: ``[n, 3]`` points of the scene in the frame of the cameras.
    """
    features = [features_of(image, _SETTINGS.features) for image in views.images]
    pairs = near_pairs(views.cameras, _SETTINGS.partners)
    found = [_shared(views.cameras, features, pair) for pair in pairs]
    rows = evenly_spread(len(views), _MOST)
    notes = [*_centre_notes(views.cameras), *_focal_notes(views.cameras[rows], [features[row] for row in rows])]
    notes += _lonely_notes(views.names, pairs, np.array([len(points) for points in found]))
    return [*notes, *_cloud_notes(views.cameras, np.concatenate(found), cloud)]


def _shared(cameras: Cameras, features: list[Features], pair: tuple[int, int]) -> FloatArray:
    """Return the points ``[n, 3]`` on which two pictures agree."""
    two, first, second = cameras[list(pair)], features[pair[0]], features[pair[1]]
    matches = guided_matches(first, second, two, _SETTINGS)
    return triangulated_pairs(first.pixels[matches[:, 0]], second.pixels[matches[:, 1]], two, _SETTINGS)


def _lonely_notes(names: Sequence[str], pairs: list[tuple[int, int]], counts: IndexArray) -> list[str]:
    """Return the note on pictures that agree with their neighbours on hardly any point, if there are some."""
    shared = np.zeros(len(names))
    for pair, count in zip(pairs, counts, strict=True):
        shared[list(pair)] += count
    lonely = [name for name, count in zip(names, shared, strict=True) if count < _LONELY * np.median(shared)]
    if not lonely or np.median(shared) < _FEWEST:
        return []
    told = f"{len(lonely)} of {len(names)} pictures agree with their neighbours on hardly any point ({some_of(lonely)})"
    return [f"{told}: their poses may be those of others, or they show little that can be told apart"]


def _centre_notes(cameras: Cameras) -> list[str]:
    places = cameras.intrinsics[:, :2, 2] / cameras.sizes
    off = np.abs(places - 0.5).max(axis=1) > _OFF_CENTRE
    if not off.any():
        return []
    x, y = places[off][0]
    told = f"the principal point of {off.sum()} of {len(off)} cameras lies far from the middle, such as at {x:.0%} of"
    return [f"{told} the width and {y:.0%} of the height: the intrinsics may be of another picture size"]


def _focal_notes(cameras: Cameras, features: list[Features]) -> list[str]:
    """Return the note on another focal length with which clearly more points agree, if there is one."""
    pairs = near_pairs(cameras, _SETTINGS.partners)

    def count(scale: float) -> int:
        return sum(len(_shared(_scaled(cameras, scale), features, pair)) for pair in pairs)

    given, counts = count(1.0), {scale: count(scale) for scale in _SCALES}
    best = max(counts, key=counts.__getitem__)
    if counts[best] < max(_FEWEST, _BETTER * given):
        return []
    told = f"pictures agree on {counts[best]} points with {best:g} times the focal lengths, on {given} with those given"
    return [f"{told}: the intrinsics may be wrong, or of another picture size"]


def _scaled(cameras: Cameras, scale: float) -> Cameras:
    intrinsics = cameras.intrinsics.copy()
    intrinsics[:, [0, 1], [0, 1]] *= scale
    return replace(cameras, intrinsics=intrinsics)


def _cloud_notes(cameras: Cameras, points: FloatArray, cloud: FloatArray) -> list[str]:
    """Return the note on a cloud that lies beside the points on which the pictures agree, if it does."""
    from scipy.spatial import KDTree

    if len(points) < _FEWEST or not len(cloud):
        return []
    depth = float(np.median(KDTree(cameras.centers).query(points)[0]))
    aside = float(np.median(KDTree(cloud).query(points)[0])) / depth
    if aside <= _ASIDE:
        return []
    told = f"half of the {len(points)} points on which pictures agree lie {aside:.0%} of their distance or more beside"
    return [f"{told} the scene's points: these may be of another capture, frame or unit, or too few"]

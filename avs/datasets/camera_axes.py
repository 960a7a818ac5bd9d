"""Whether the axes that a user names are those of the cameras: with others, cameras look the other way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from avs.datasets.found_points import are_doubtful, sure_points, triangulated_points
from avs.datasets.posed_scene import FindPoints
from avs.datasets.stored_points import behind_all, seen_shares
from avs.datasets.transforms_file import Axes
from avs.scene.cameras import Cameras
from avs.scene.points import Points
from avs.scene.views import Views
from avs.system.errors import UserError
from avs.system.lists_of_names import some_of

OTHER: dict[Axes, Axes] = {"opengl": "opencv", "opencv": "opengl"}

_CLEARLY = 3.0
"""The other axes are named where they explain so many times as much."""


def turned(cameras: Cameras) -> Cameras:
    """Return the cameras with y and z of their axes the other way round: from OpenCV's to OpenGL's, or back."""
    return replace(cameras, world_to_camera=np.diag([1.0, -1.0, -1.0, 1.0]) @ cameras.world_to_camera)


def triangulating(subject: object, axes: Axes) -> FindPoints:
    """Return a function that triangulates points and refuses axes that the pictures speak against."""

    def find(views: Views) -> tuple[Points, list[str]]:
        points, notes = triangulated_points(views)
        if not are_doubtful(points, len(views)):
            return points, notes
        sure = sure_points(points)
        others = sure_points(triangulated_points(replace(views, cameras=turned(views.cameras)))[0])
        if others > max(len(views), _CLEARLY * sure):
            fault = f"with axes {axes}, three pictures agree on {sure} points, with {OTHER[axes]} on {others}"
            raise UserError(subject, fault, f"set axes: {OTHER[axes]}")
        return points, notes

    return find


def showing(subject: object, axes: Axes, read: Callable[[], Points]) -> FindPoints:
    """Return a function that reads stored points and refuses axes with which cameras do not see them."""

    def find(views: Views) -> tuple[Points, list[str]]:
        points = read()
        if not len(points):
            return points, ["the cloud has no points"]
        seen = float(seen_shares(views.cameras, points.positions).mean())
        others = float(seen_shares(turned(views.cameras), points.positions).mean())
        told = f"with axes {axes}, a camera sees {seen:.1%} of the points on average, with {OTHER[axes]} {others:.1%}"
        if others > _CLEARLY * seen:
            raise UserError(subject, told, f"set axes: {OTHER[axes]}")
        blind = [views.names[row] for row in np.flatnonzero(behind_all(views.cameras, points.positions))]
        if blind:
            fault = f"all points lie behind the cameras of {len(blind)} images ({some_of(blind)})"
            raise UserError(subject, fault, "correct their poses, or take them out")
        notes = [f"{len(points)} points are those of the file, without images that see them"]
        return points, notes if seen > _CLEARLY * others else [*notes, f"{told}: this does not tell which is right"]

    return find

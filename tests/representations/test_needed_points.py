"""What a reconstruction needs of a scene's points is checked when the scene is prepared."""

from dataclasses import replace

import pytest
from factories import small_scene

from avs.datasets.capture_consistency import unseen_notes
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.representations.needed_points import check_points
from avs.scene.points import Points
from avs.system.errors import UserError


def needed(choice, **settings):
    return GaussianSettings(points=InitialPoints(choice=choice, **settings)).needed_points()


@pytest.fixture
def scene(tmp_path):
    """12 points; point p is seen by images p, p + 1 and p + 2, of which every eighth is a test image."""
    return small_scene(tmp_path / "toy")


def test_random_points_need_nothing():
    assert needed("random") is None


def test_points_that_are_there_are_enough(scene):
    check_points(scene, needed("sfm"))
    check_points(scene, needed("selected", selected_min_views=2))


def test_points_without_tracks_name_the_choice_that_takes_them(scene):
    bare = replace(scene, points=replace(scene.points, observations=scene.points.observations[:0]))
    check_points(bare, needed("sfm"))
    line = (
        r"0 of 12 points are seen by 1 or more images of the pool, but representation\.points\.choice 'selected' "
        r"needs 4; set representation: \{points: \{choice: sfm\}\}, or"
    )
    with pytest.raises(UserError, match=line):
        check_points(bare, needed("selected"))


def test_poses_that_are_in_doubt_are_the_remedy_where_another_choice_would_hide_it(scene):
    bare = replace(scene, points=replace(scene.points, observations=scene.points.observations[:0]))
    note = unseen_notes(scene.names, scene.points, bare.points)
    line = "needs 4; correct it: 10 of 40 images .* their poses may be wrong or inverted"
    with pytest.raises(UserError, match=line):
        check_points(replace(bare, notes=tuple(note)), needed("selected"))


@pytest.mark.parametrize("choice", ["sfm", "selected"])
def test_a_model_without_points_names_the_choice_that_needs_none(choice, scene):
    points = scene.points
    empty = replace(scene, points=Points(points.positions[:0], points.colors[:0], points.observations[:0]))
    line = r"the model has 0 points, .*; set representation: \{points: \{choice: random\}\}"
    with pytest.raises(UserError, match=line):
        check_points(empty, needed(choice))

"""The figures of coverage: pictures of clouds, where the worst region is, what curves are, equal bytes."""

import numpy as np
import pytest

from avs.coverage.coverage_record import Coverage
from avs.coverage.episode_coverage import write_coverage
from avs.report.figures.cloud_rendering import BACKGROUND, coloured, magnified, painted, project
from avs.report.figures.coverage_maps import write_coverage_maps
from avs.report.figures.coverage_over_views import coverage_panels, write_coverage_over_views
from avs.scene.cameras import Cameras
from avs.sfm.cloud import empty_cloud
from avs.sfm.cloud_file import read_cloud, write_cloud
from avs.system.errors import UserError
from avs.system.records import read_record, write_record
from tests.report.coverage_records import make_coverage
from tests.scene_coverage.conftest import reference, sphere  # noqa: F401 - fixtures
from tests.scene_coverage.sphere_scene import coverage_job, write_episode

METHODS = ["random", "farthest", "ours-repvit"]


def camera():
    """Looks along z from the origin; 40 x 20 pixels, focal length 20."""
    matrix = np.array([[[20.0, 0, 20], [0, 20.0, 10], [0, 0, 1]]])
    return Cameras(np.eye(4)[None], matrix, np.array([[40, 20]], dtype=np.int64))


def test_near_points_hide_far_ones_and_those_behind_are_not_seen():
    points = np.array([[0.0, 0, 4], [0.0, 0, 2], [0.0, 0, -2], [1.0, 0, 2]])
    projection = project(points, camera(), 0.1, 40)
    assert projection.size == (40, 20)
    assert projection.pixels[[0, 1, 3]].tolist() == [[20, 10], [20, 10], [30, 10]]
    assert projection.visible().tolist() == [True, True, False, True]
    picture = painted(projection)
    assert picture.shape == (20, 40)
    assert picture[10, 20] == picture[9, 19] == 1
    assert picture[10, 30] == 3
    assert set(np.unique(picture)) == {-1, 1, 3}
    image = coloured(picture, np.array([[9, 9, 9]] * 4, dtype=np.uint8))
    assert image[0, 0].tolist() == [BACKGROUND] * 3
    assert image[10, 30].tolist() == [9, 9, 9]


def test_a_window_is_magnified():
    projection = project(np.array([[1.0, 0, 2], [0.0, 0, 2]]), camera(), 0.1, 40)
    part = magnified(projection, (25.0, 5.0, 10.0), 100)
    assert part.size == (100, 100)
    assert part.pixels[0].tolist() == [50, 50]
    assert part.visible().tolist() == [True, False]


def test_a_picture_without_points_is_background():
    picture = painted(project(np.zeros((0, 3)), camera(), 0.1, 80))
    assert picture.shape == (40, 80)
    assert (picture == -1).all()


@pytest.fixture
def covered(sphere, reference, tmp_path):  # noqa: F811 - fixtures
    """Measure two methods on the sphere and return their records and covered clouds."""
    records = []
    for method, views in (("random", (1, 2, 3, 4, 5, 6)), ("farthest", (1, 9, 3, 11, 5, 13))):
        out = tmp_path / method
        episode = write_episode(out / "episode.json", sphere, method, views=views)
        write_coverage(sphere.folder, episode, reference, coverage_job(), out, print)
        records.append(out / "coverage.json")
    return records, [path.with_name("covered.ply") for path in records]


def test_maps_are_the_same_to_the_byte(sphere, covered, tmp_path):  # noqa: F811
    contents = []
    for name, step in (("one", 1), ("other", -1)):
        out = tmp_path / name / "coverage_maps"
        write_coverage_maps(sphere.folder, *(paths[::step] for paths in covered), METHODS, out)
        contents.append({path.name: path.read_bytes() for path in out.parent.iterdir()})
    assert contents[0] == contents[1]
    assert set(contents[0]) == {"coverage_maps.md", "coverage_maps.pdf", "coverage_maps.png"}


def test_maps_of_different_points_are_refused(sphere, covered, tmp_path):  # noqa: F811
    records, clouds = covered
    cloud, fields = read_cloud(clouds[1], "")
    write_cloud(clouds[1], cloud.moved_to(cloud.positions + 1), fields)
    with pytest.raises(UserError, match="does not hold the points of the others"):
        write_coverage_maps(sphere.folder, records, clouds, METHODS, tmp_path / "maps")


@pytest.mark.parametrize("change", [{"seed": 7}, {"settings": {"voxel": 1.0}}, {"reference": {}}, {"method": "random"}])
def test_maps_of_other_seeds_or_settings_are_refused(sphere, covered, tmp_path, change):  # noqa: F811
    records, clouds = covered
    write_record(records[1], read_record(records[1], Coverage).model_copy(update=change))
    for step in (1, -1):
        with pytest.raises(UserError, match="a second record of its method, or of another seed or other settings"):
            write_coverage_maps(sphere.folder, records[::step], clouds[::step], METHODS, tmp_path / "maps")


def test_a_reference_without_points_has_words_in_place_of_maps(sphere, covered, tmp_path):  # noqa: F811
    records, clouds = covered
    record = read_record(records[0], Coverage)
    write_record(records[0], record.model_copy(update={"extent": None, "against_reference": None}))
    write_cloud(clouds[0], empty_cloud(), {"distance": np.zeros(0, dtype=np.float32)})
    write_coverage_maps(sphere.folder, records[:1], clouds[:1], METHODS, tmp_path / "maps")
    assert (tmp_path / "maps.png").exists()


@pytest.fixture
def curves(written, tmp_path):
    def write(pairs):
        records = []
        for number, (_, record) in enumerate(pairs):
            records.append(tmp_path / "coverage" / f"{number}.json")
            write_record(records[-1], record)
        return written([episode for episode, _ in pairs]), records

    return write


def test_curves_are_the_median_over_scenes_of_the_scr(episode, curves):
    pairs = []
    for method, gain in (("random", 0.0), ("farthest", 0.1)):
        for scene, scr in (("attic", 0.2), ("cellar", 0.3), ("hall", 0.8)):
            made = episode(method, scene)
            pairs.append((made, make_coverage(made, scr=scr + gain)))
    (panel,) = coverage_panels(*curves(pairs), METHODS)
    random, farthest = panel.curves
    assert random.views.tolist() == [5, 6]
    np.testing.assert_allclose(random.mean, [15.0, 30.0])
    np.testing.assert_allclose(farthest.mean, [20.0, 40.0])
    np.testing.assert_allclose(farthest.difference - random.difference, [5.0, 10.0])
    assert panel.over == "scenes"


def test_the_figure_is_written_twice_the_same(episode, curves, tmp_path):
    pairs = [(made := episode(method), make_coverage(made)) for method in METHODS]
    episodes, records = curves(pairs)
    contents = []
    for order in (1, -1):
        out = tmp_path / str(order) / "coverage_over_views"
        write_coverage_over_views(episodes[::order], records[::order], METHODS, out)
        contents.append([path.read_bytes() for path in sorted(out.parent.iterdir())])
    assert contents[0] == contents[1]
    assert len(contents[0]) == 3


def test_scenes_without_a_curve_are_left_out(episode, curves, tmp_path):
    pairs = [(made := episode(method, scene), make_coverage(made)) for method in METHODS for scene in ("attic", "hall")]
    without = [(made, record.model_copy(update={"curve": []})) for made, record in pairs]
    mixed = [pair if pair[0].scene == "hall" else other for pair, other in zip(pairs, without, strict=True)]
    (panel,) = coverage_panels(*curves(mixed), METHODS)
    assert panel.title == "orbit: hall, 1 seed"
    write_coverage_over_views(*curves(without), METHODS, tmp_path / "none")
    assert (tmp_path / "none.png").exists()

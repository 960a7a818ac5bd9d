"""The reference of a scene and the coverage of an episode, on a sphere that the back end sees as it is."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from avs.coverage import clouds_of_views
from avs.coverage.coverage_record import Coverage, CoverageMeta, Reference
from avs.coverage.episode_coverage import write_coverage
from avs.coverage.reference_cloud import read_reference, write_reference
from avs.coverage.true_surface import visible_surface
from avs.scene.cameras import Cameras
from avs.scene.scene import read_scene
from avs.sfm.back_end_registry import create_settings
from avs.sfm.cloud_file import read_cloud
from avs.sfm.reconstruction import Reconstruction
from avs.system.errors import UserError
from avs.system.records import read_record
from metrics.coverage import nearest_distances
from tests import tolerances
from tests.scene_coverage.sphere_scene import (
    COUNT,
    blind,
    coverage_job,
    perfect,
    reference_job,
    seen_by,
    write_episode,
    write_sphere,
)

ALL = (0, 1, 2, 3, *range(4, COUNT))


def measured(tmp_path, scene, reference, captured=(1, 4, 7, 10, 2, 3), name="out", **settings):
    path = write_episode(tmp_path / name / "episode.json", scene, views=captured)
    write_coverage(scene.folder, path, reference, coverage_job(**settings), tmp_path / name, lambda line: None)
    return read_record(tmp_path / name / "coverage.json", Coverage)


def test_the_surface_lies_where_the_rays_meet_it(sphere):
    surface = visible_surface(sphere, np.array([0, 5]))
    middle = sphere.to_capture.points_back(np.zeros(3))
    radius = 1.0 / sphere.to_capture.scale
    lengths = np.linalg.norm(surface.points - middle, axis=1)
    assert lengths == pytest.approx(np.full(len(lengths), radius), rel=tolerances.COVERAGE_SURFACE)
    depth = np.load(sphere.folder / "depth" / "000.npy")
    focal = sphere.cameras.intrinsics[0, 0, 0]
    assert surface.resolution[: (depth > 0).sum()] == pytest.approx(focal / depth[depth > 0], rel=1e-6)


def test_without_depth_there_is_no_true_surface(tmp_path):
    assert visible_surface(write_sphere(tmp_path / "ball", with_depth=False), np.array([0])) is None


def test_a_changed_depth_map_is_refused(sphere):
    path = sphere.folder / "depth" / "003.npy"
    path.write_bytes(path.read_bytes()[:-4] + b"abcd")
    with pytest.raises(UserError, match=r"003\.npy: is not the file that scene\.json lists"):
        visible_surface(sphere, np.array([3]))


def test_all_views_cover_the_reference_and_the_truth(sphere, reference, tmp_path):
    record = measured(tmp_path, sphere, reference, ALL)
    for numbers in (record.against_reference, record.against_surface):
        assert numbers.scr == numbers.toolbox_f_score == 1.0
        assert [each.f_score for each in numbers.at[1:]] == [1.0, 1.0]
    assert record.against_reference.f_score == 1.0
    assert record.registered == list(sphere.names)
    assert record.points == read_record(reference / "reference.json", Reference).points


def test_fewer_views_cover_less_and_the_curve_tells_how_much(sphere, reference, tmp_path):
    record = measured(tmp_path, sphere, reference, (1, 2, 3, 4, 5, 6), views=(2, 4))
    assert [point.views for point in record.curve] == [2, 4, 6]
    scr = [point.scr for point in record.curve]
    assert 0.0 < scr[0] < scr[1] < scr[2] < 1.0
    assert record.curve[-1].scr == record.against_reference.scr
    assert record.against_reference.at[1].precision == 1.0
    # The reference is the truth but for its sampling.
    for point in record.curve:
        assert point.true_scr == pytest.approx(point.scr, abs=tolerances.COVERAGE_OF_SPHERE)


def test_the_order_of_capture_does_not_change_the_cloud(sphere, reference, tmp_path):
    one = measured(tmp_path, sphere, reference, (1, 4, 7, 10, 2, 3), "one")
    other = measured(tmp_path, sphere, reference, (7, 10, 1, 4, 3, 2), "other")
    assert one.against_reference == other.against_reference
    assert one.views != other.views
    clouds = [(tmp_path / name / "cloud.ply").read_bytes() for name in ("one", "other")]
    assert clouds[0] == clouds[1]


def test_equal_input_gives_equal_bytes(sphere, reference, tmp_path):
    for name in ("one", "other"):
        measured(tmp_path, sphere, reference, name=name)
    for file in ("coverage.json", "cloud.ply", "covered.ply", "covered_surface.ply"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "other" / file).read_bytes()
    meta = read_record(tmp_path / "one" / "coverage.meta.json", CoverageMeta)
    assert 0 < meta.reconstruction_seconds < meta.total_seconds


def test_clouds_carry_their_distances(sphere, reference, tmp_path):
    record = measured(tmp_path, sphere, reference)
    found = read_reference(reference, sphere)
    cloud, fields = read_cloud(tmp_path / "out" / "cloud.ply", "")
    covered, distances = read_cloud(tmp_path / "out" / "covered.ply", "")
    surface, true_distances = read_cloud(tmp_path / "out" / "covered_surface.ply", "")
    assert set(fields) == {"distance", "true_distance"}
    assert set(distances) == set(true_distances) == {"distance"}
    assert distances["distance"] == pytest.approx(nearest_distances(covered.positions, cloud.positions), abs=1e-6)
    near = distances["distance"] < 0.04 * record.extent
    assert near.mean() == pytest.approx(record.against_reference.scr)
    assert (true_distances["distance"] < 0.04 * record.extent).mean() == pytest.approx(record.against_surface.scr)
    assert len(surface) <= found.record.surface_points


def test_surfaces_that_no_image_resolves_need_not_be_covered(sphere, tmp_path):
    write_reference(sphere.folder, reference_job(voxel=0.001), tmp_path / "fine")
    found = read_reference(tmp_path / "fine", sphere)
    assert len(found.surface_cloud)
    assert (found.surface_cloud.confidence < 1).all()
    record = measured(tmp_path, sphere, tmp_path / "fine", voxel=0.001)
    assert record.against_reference.scr > 0
    assert record.against_surface is None
    assert record.absent == {"against_surface": "images are coarser than voxels everywhere"}


def test_views_that_do_not_register_cover_nothing_and_say_why(sphere, reference, tmp_path, monkeypatch):
    monkeypatch.setattr(clouds_of_views, "reconstruct", blind)
    record = measured(tmp_path, sphere, reference)
    assert record.points == 0
    assert record.against_reference.scr == record.against_reference.f_score == 0.0
    assert record.against_surface.toolbox_f_score == 0.0
    assert record.registered == []
    assert record.notes == ["Random, ball, seed 0: no cloud, SCR 0: no matches"]


def test_a_scene_without_a_cloud_has_no_coverage_and_says_why(sphere, tmp_path, monkeypatch):
    monkeypatch.setattr(clouds_of_views, "reconstruct", blind)
    write_reference(sphere.folder, reference_job(), tmp_path / "reference")
    record = measured(tmp_path, sphere, tmp_path / "reference")
    assert record.against_reference is record.against_surface is record.extent is None
    assert record.curve == []
    assert "the cloud of all views has no extent: no matches" in record.absent["against_reference"]


def test_without_known_geometry_there_is_the_reference_alone(tmp_path, monkeypatch):
    with_depth = write_sphere(tmp_path / "ball")
    scene = write_sphere(tmp_path / "bare", with_depth=False)
    monkeypatch.setattr(clouds_of_views, "reconstruct", perfect(with_depth))
    write_reference(scene.folder, reference_job(), tmp_path / "reference")
    record = measured(tmp_path, scene, tmp_path / "reference")
    assert record.against_surface is None
    assert record.absent == {"against_surface": "the true surface is not known"}
    assert record.curve[-1].true_scr is None


def free(scene, wrong=()):
    """A back end with poses of its own: turned, moved and scaled, and some of them wrong."""
    rotation = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))

    def reconstruct(views, settings, subject, device="cpu"):
        cloud = seen_by(scene, views)
        transforms = views.cameras.world_to_camera.copy()
        transforms[:, :3, :3] = views.cameras.world_to_camera[:, :3, :3] @ rotation.T
        shift = np.array([3.0, -1.0, 2.0])
        transforms[:, :3, 3] = 0.2 * views.cameras.world_to_camera[:, :3, 3] - transforms[:, :3, :3] @ shift
        for name in set(wrong) & set(views.names):
            transforms[views.names.index(name), :3, 3] += 0.7
        cameras = Cameras(transforms, views.cameras.intrinsics, views.cameras.sizes)
        moved = cloud.moved_to(0.2 * cloud.positions @ rotation.T + shift)
        return Reconstruction(moved, views.names, cameras=cameras)

    return reconstruct


def test_free_poses_are_brought_to_the_reference(sphere, tmp_path, monkeypatch):
    monkeypatch.setattr(clouds_of_views, "reconstruct", free(sphere, wrong=("003.png",)))
    write_reference(sphere.folder, reference_job(), tmp_path / "reference")
    found = read_reference(tmp_path / "reference", sphere).record
    assert found.placement.scale == pytest.approx(5.0)
    assert found.placement.agreeing == COUNT - 1
    assert set(found.cameras) == set(sphere.names)
    record = measured(tmp_path, sphere, tmp_path / "reference", ALL)
    assert record.against_reference.scr == 1.0
    assert record.placement.residual == pytest.approx(0.0, abs=1e-6)


def test_cameras_that_fit_nowhere_give_no_cloud(sphere, reference, tmp_path, monkeypatch):
    monkeypatch.setattr(clouds_of_views, "reconstruct", free(sphere, wrong=sphere.names[::2]))
    scattered = free(sphere)

    def lost(views, settings, subject, device="cpu"):
        found = scattered(views, settings, subject, device)
        transforms = found.cameras.world_to_camera.copy()
        transforms[:, :3, 3] += np.random.default_rng(0).normal(size=(len(transforms), 3)) * 9
        return replace(found, cameras=replace(found.cameras, world_to_camera=transforms))

    monkeypatch.setattr(clouds_of_views, "reconstruct", lost)
    record = measured(tmp_path, sphere, reference)
    assert record.against_reference.scr == 0.0
    assert "do not agree with the scene's" in record.notes[0]


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"scene_hash": "another"}, "is of another version of the scene"),
        ({"selected": ["nowhere.png"]}, "view nowhere.png is no image of the scene"),
    ],
)
def test_an_episode_of_other_images_is_refused(changes, fault, sphere, reference, tmp_path):
    path = write_episode(tmp_path / "episode.json", sphere, **changes)
    with pytest.raises(UserError, match=fault):
        write_coverage(sphere.folder, path, reference, coverage_job(), tmp_path / "out", print)


def test_a_reference_of_other_settings_is_refused(sphere, reference, tmp_path):
    settings = coverage_job(sfm=create_settings({"back_end": "colmap"}))
    path = write_episode(tmp_path / "episode.json", sphere)
    with pytest.raises(UserError, match="was made with other settings of structure from motion"):
        write_coverage(sphere.folder, path, reference, settings, tmp_path / "out", print)


@pytest.mark.parametrize("name", ["reference.json", "reference.ply", "surface.ply"])
def test_a_changed_reference_is_refused(name, sphere, reference, tmp_path):
    content = bytearray((reference / name).read_bytes())
    content[len(content) // 2] ^= 1
    (reference / name).write_bytes(content)
    with pytest.raises(UserError, match=name):
        read_reference(reference, sphere)


def test_clouds_of_another_reference_are_refused(sphere, reference, tmp_path):
    write_reference(sphere.folder, reference_job(reference_views="pool"), tmp_path / "pool")
    shutil.copy(tmp_path / "pool" / "reference.ply", reference / "reference.ply")
    with pytest.raises(UserError, match=r"reference\.ply: was changed after it was written"):
        read_reference(reference, sphere)
    assert "000.png" not in read_record(tmp_path / "pool" / "reference.json", Reference).views


def test_a_missing_image_is_one_line(sphere, reference, tmp_path):
    (sphere.folder / "images" / "004.png").unlink()
    with pytest.raises(UserError, match=r"004\.png"):
        measured(tmp_path, read_scene(sphere.folder), reference)

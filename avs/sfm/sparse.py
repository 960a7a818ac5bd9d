"""Sparse points by COLMAP (Schoenberger and Frahm 2016): features, matches, and triangulation or mapping.

With known poses a match is judged by the epipolar geometry of the two cameras, and not by one that RANSAC finds: of
pairs far apart few matches are left, too few to find their geometry by, but enough to check them against it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras, FloatArray
from avs.sfm.colmap_workspace import library, row_name, row_of
from avs.sfm.sfm_settings import FeatureSettings

_NARROWEST = 1.5
"""Degrees between the rays of a point, at least: COLMAP's own limit."""


def find_features(folder: Path, cameras: Cameras, settings: FeatureSettings) -> Path:
    """Extract SIFT features of the images of a workspace and match all pairs; return the database.

    Args:
        folder: of ``colmap_workspace.workspace``.
        cameras: of its images; their intrinsics go into the database.
        settings: see there.
    """
    pycolmap = library()

    database = folder / "database.db"
    extraction = pycolmap.FeatureExtractionOptions(num_threads=1, use_gpu=False)
    extraction.sift.max_num_features = settings.features
    pycolmap.extract_features(
        database,
        folder / "images",
        image_names=[row_name(row) for row in range(len(cameras))],
        camera_mode=pycolmap.CameraMode.PER_IMAGE,
        reader_options=pycolmap.ImageReaderOptions(camera_model="PINHOLE"),
        extraction_options=extraction,
        device=pycolmap.Device.cpu,
    )
    with pycolmap.Database.open(database) as opened:
        for image in opened.read_all_images():
            camera = opened.read_camera(image.camera_id)
            matrix = cameras.intrinsics[row_of(image.name)]
            camera.params = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]
            camera.has_prior_focal_length = True
            opened.update_camera(camera)
    return database


def match_known(database: Path, cameras: Cameras, settings: FeatureSettings) -> None:
    """Match the features of views near each other and keep what lies near the epipolar lines of the known cameras."""
    pycolmap = library()

    matching = _matching(settings)
    matching.skip_geometric_verification = True
    listed = database.with_name("pairs.txt")
    pairs = near_pairs(cameras, settings.partners)
    listed.write_text("".join(f"{row_name(first)} {row_name(second)}\n" for first, second in pairs))
    pairing = pycolmap.ImportedPairingOptions(match_list_path=listed)
    few = pycolmap.TwoViewGeometryOptions(min_num_inliers=1)
    pycolmap.match_image_pairs(database, matching, pairing, few, device=pycolmap.Device.cpu)
    with pycolmap.Database.open(database) as opened:
        identifiers = {row_of(image.name): image.image_id for image in opened.read_all_images()}
        keypoints = {
            row: np.asarray(opened.read_keypoints(number))[:, :2].astype(np.float64)
            for row, number in identifiers.items()
        }
        opened.clear_two_view_geometries()
        for first, second in pairs:
            matches = np.asarray(opened.read_matches(identifiers[first], identifiers[second]))
            if not len(matches):
                continue
            errors = epipolar_errors(
                keypoints[first][matches[:, 0]], keypoints[second][matches[:, 1]], cameras[[first, second]]
            )
            geometry = pycolmap.TwoViewGeometry()
            geometry.config = pycolmap.TwoViewGeometryConfiguration.CALIBRATED
            geometry.inlier_matches = matches[errors <= settings.error]
            opened.write_two_view_geometry(identifiers[first], identifiers[second], geometry)


def near_pairs(cameras: Cameras, partners: int) -> list[tuple[int, int]]:
    """Return the pairs of views that are among each other's, or one's, ``partners`` nearest, in ascending order.

    The distance of two views is that of their centres, in shares of the greatest, and that of their directions of view,
    in shares of a half turn: a view that looks elsewhere from the same place shows as little of the same surface as one
    from far away.
    """
    centers, forward = cameras.centers, cameras.world_to_camera[:, 2, :3]
    apart = np.linalg.norm(centers[:, None] - centers[None], axis=2)
    turned = np.arccos(np.clip(forward @ forward.T, -1, 1)) / np.pi
    distances = apart / max(float(apart.max()), 1e-300) + turned
    np.fill_diagonal(distances, np.inf)
    nearest = np.argsort(distances, axis=1, kind="stable")[:, : min(partners, len(cameras) - 1)]
    return sorted(
        {(min(row, other), max(row, other)) for row, others in enumerate(nearest.tolist()) for other in others}
    )


def match_free(database: Path, settings: FeatureSettings, seed: int) -> None:
    """Match the features of all pairs and keep what agrees with the geometry that RANSAC finds for the pair."""
    pycolmap = library()

    verification = pycolmap.TwoViewGeometryOptions(min_num_inliers=settings.fewest_inliers)
    verification.ransac.random_seed = seed
    verification.ransac.num_threads = 1
    pycolmap.match_exhaustive(
        database, _matching(settings), verification_options=verification, device=pycolmap.Device.cpu
    )


def triangulate(folder: Path, database: Path, cameras: Cameras, settings: FeatureSettings, seed: int) -> Any:  # noqa: ANN401
    """Return the ``pycolmap.Reconstruction`` of known cameras with the points that the matches give."""
    pycolmap = library()

    options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=seed, min_num_matches=1)
    options.triangulation.ignore_two_view_tracks = False
    options.triangulation.min_angle = _NARROWEST
    options.triangulation.random_seed = seed
    options.mapper.filter_max_reproj_error = settings.error
    pycolmap.set_random_seed(seed)
    (folder / "triangulated").mkdir()
    return pycolmap.triangulate_points(
        _model_of(database, cameras),
        database,
        folder / "images",
        folder / "triangulated",
        options=options,
        refine_intrinsics=False,
    )


def map_incrementally(folder: Path, database: Path, seed: int) -> list[Any]:
    """Return the models that incremental mapping finds, that with the most images first; focal lengths stay."""
    pycolmap = library()

    options = pycolmap.IncrementalPipelineOptions(num_threads=1, random_seed=seed, min_model_size=2)
    options.ba_refine_focal_length = options.ba_refine_extra_params = False
    options.mapper.abs_pose_refine_focal_length = options.mapper.abs_pose_refine_extra_params = False
    options.mapper.num_threads, options.mapper.random_seed = 1, seed
    options.triangulation.random_seed = seed
    pycolmap.set_random_seed(seed)
    (folder / "mapped").mkdir()
    models = pycolmap.incremental_mapping(database, folder / "images", folder / "mapped", options=options)
    return sorted(models.values(), key=lambda model: (-model.num_reg_images(), -model.num_points3D()))


def epipolar_errors(first: FloatArray, second: FloatArray, cameras: Cameras) -> npt.NDArray[np.float64]:
    """Return Sampson's distance in pixels of pairs of pixels from the epipolar geometry of two cameras.

    Args:
        first: ``[m, 2]`` pixels of the first camera.
        second: ``[m, 2]`` pixels of the second.
        cameras: the two.
    """
    matrix = fundamental(cameras)
    ones = np.ones((len(first), 1))
    left, right = np.hstack([first, ones]), np.hstack([second, ones])
    lines, lines_back = left @ matrix.T, right @ matrix
    slopes = (lines[:, :2] ** 2).sum(axis=1) + (lines_back[:, :2] ** 2).sum(axis=1)
    errors: npt.NDArray[np.float64] = np.abs((right * lines).sum(axis=1)) / np.sqrt(np.maximum(slopes, 1e-300))
    return errors


def fundamental(cameras: Cameras) -> FloatArray:
    """Return the fundamental matrix ``[3, 3]`` F of two cameras: pixels of one point fulfil ``x2 . F x1 = 0``."""
    relative = cameras.world_to_camera[1] @ np.linalg.inv(cameras.world_to_camera[0])
    x, y, z = relative[:3, 3]
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    back = np.linalg.inv(cameras.intrinsics)
    matrix: FloatArray = back[1].T @ cross @ relative[:3, :3] @ back[0]
    return matrix


def _model_of(database: Path, cameras: Cameras) -> Any:  # noqa: ANN401
    """Return a model without points, whose cameras and images have the identifiers of the database."""
    pycolmap = library()

    model = pycolmap.Reconstruction()
    with pycolmap.Database.open(database) as opened:
        images = {image.frame_id: image for image in opened.read_all_images()}
        for camera in opened.read_all_cameras():
            model.add_camera(camera)
        for rig in opened.read_all_rigs():
            model.add_rig(rig)
        for frame in opened.read_all_frames():
            transform = cameras.world_to_camera[row_of(images[frame.frame_id].name)]
            frame.rig_from_world = pycolmap.Rigid3d(pycolmap.Rotation3d(transform[:3, :3]), transform[:3, 3])
            model.add_frame(frame)
        for image in images.values():
            model.add_image(image)
            model.register_frame(image.frame_id)
    return model


def _matching(settings: FeatureSettings) -> Any:  # noqa: ANN401
    pycolmap = library()

    matching = pycolmap.FeatureMatchingOptions(num_threads=1, use_gpu=False)
    matching.sift.max_ratio = settings.ratio
    return matching

"""Structure from motion of photographs of which nothing is known, by COLMAP: features, matches, incremental mapping."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avs.sfm.colmap_workspace import library
from avs.system.files import temporary_folder

_NEIGHBOURS = 10
"""Frames of a video that follow each and are matched with it; COLMAP adds those 16, 32 and so on frames later."""


@dataclass(frozen=True)
class MappedModel:
    """A model that was found.

    Attributes:
        registered: names of the photographs in it, ascending.
        points: number of its points.
        error: mean reprojection error in pixels.
    """

    registered: tuple[str, ...]
    points: int
    error: float


def map_photographs(
    images: Path,
    names: Sequence[str],
    out: Path,
    *,
    lens: str,
    one_camera: bool,
    ordered: bool,
    tell: Callable[[str], None],
) -> list[MappedModel]:
    """Find poses, intrinsics and points, and write the models to ``out/0``, ``out/1`` and so on, the largest first.

    It runs on all cores, so that the order of sums, and with it the last digits, differ from run to run.

    Args:
        images: the folder of the photographs.
        names: of the photographs in it.
        out: folder of the models; it is made.
        lens: COLMAP's name of the model of all cameras, such as ``SIMPLE_RADIAL``.
        one_camera: whether all photographs share one camera; else each has its own.
        ordered: whether names in ascending order follow a path, as the frames of a video: each is then matched with
            those near it alone, and not with all.
        tell: receives a line for each step.
    """
    pycolmap = library()

    with temporary_folder("avs-poses-") as folder:
        database = folder / "database.db"
        tell(f"features of {len(names)} photographs")
        mode = pycolmap.CameraMode.SINGLE if one_camera else pycolmap.CameraMode.PER_IMAGE
        pycolmap.extract_features(
            database,
            images,
            image_names=sorted(names),
            camera_mode=mode,
            reader_options=pycolmap.ImageReaderOptions(camera_model=lens),
            extraction_options=pycolmap.FeatureExtractionOptions(use_gpu=False),
            device=pycolmap.Device.cpu,
        )
        _match(database, len(names), ordered, tell)
        models = _map(database, images, folder, len(names), tell)
        out.mkdir(parents=True)
        for number, model in enumerate(models):
            (out / str(number)).mkdir()
            model.write(out / str(number))
    return [_told(model) for model in models]


def _match(database: Path, count: int, ordered: bool, tell: Callable[[str], None]) -> None:
    pycolmap = library()

    matching = pycolmap.FeatureMatchingOptions(use_gpu=False)
    verification = pycolmap.TwoViewGeometryOptions()
    verification.ransac.random_seed = 0
    if ordered:
        tell(f"matches of each with about {2 * _NEIGHBOURS} others near it")
        pairing = pycolmap.SequentialPairingOptions(overlap=_NEIGHBOURS, quadratic_overlap=True, loop_detection=False)
        pycolmap.match_sequential(database, matching, pairing, verification, device=pycolmap.Device.cpu)
        return
    tell(f"matches of {count * (count - 1) // 2} pairs")
    pycolmap.match_exhaustive(database, matching, verification_options=verification, device=pycolmap.Device.cpu)


def _map(database: Path, images: Path, folder: Path, count: int, tell: Callable[[str], None]) -> list[Any]:
    """Return the models, the one with most photographs first."""
    pycolmap = library()

    options = pycolmap.IncrementalPipelineOptions(random_seed=0, min_model_size=3)
    pycolmap.set_random_seed(0)
    (folder / "models").mkdir()
    placed = 2

    def first() -> None:
        nonlocal placed
        placed = 2
        tell("mapping begins with a pair of photographs")

    def more() -> None:
        nonlocal placed
        placed += 1
        tell(f"mapping: {placed} of {count} photographs have a pose")

    models = pycolmap.incremental_mapping(
        database,
        images,
        folder / "models",
        options=options,
        initial_image_pair_callback=first,
        next_image_callback=more,
    )
    return sorted(models.values(), key=lambda model: (-model.num_reg_images(), -model.num_points3D()))


def _told(model: Any) -> MappedModel:  # noqa: ANN401
    names = sorted(image.name for image in model.images.values() if image.has_pose)
    return MappedModel(tuple(names), model.num_points3D(), float(model.compute_mean_reprojection_error()))

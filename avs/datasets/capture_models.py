"""Which model of a capture is read: structure from motion often leaves several, each of a part of the images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from avs.scene.cameras import FloatArray
from avs.scene.colmap import Model, find_model, has_model, read_model, read_other_form
from avs.scene.colmap.conversion import rotation_matrix
from avs.system.errors import UserError

_DIGITS = 1e-4
"""Relative difference, or absolute one in the model's unit, within which two are one: programs write six digits."""


@dataclass(frozen=True)
class ChosenModel:
    """A model of a capture.

    Attributes:
        folder: where it lies.
        model: what it holds.
        notes: what became of other models.
    """

    folder: Path
    model: Model
    notes: list[str]


def choose_model(capture: Path) -> ChosenModel:
    """Return the model with most images; of equal ones, the first of ``sparse/0``, ``sparse/1`` and so on.

    ``sparse`` itself may be a model, and ``colmap/sparse`` is looked at as well, where nerfstudio's ``ns-process-data``
    keeps its models.

    Raises:
        UserError: there is no model, or one of several is damaged, so that no one knows which is the largest.
    """
    folders = [folder for folder in _candidates(capture) if has_model(folder)]
    if not folders:
        if not any((capture / part).is_dir() for part in ("sparse", "colmap/sparse")):
            fault, remedy = "there is no such folder", "put cameras, images and points3D there, as .bin or as .txt"
            raise UserError(capture / "sparse" / "0", fault, remedy)
        find_model(capture / "sparse" / "0")  # says that there is none
    models = {folder: read_model(folder) for folder in folders}
    largest = max(folders, key=lambda folder: len(models[folder].images))  # the first of equal ones
    if not models[largest].images:
        raise UserError(find_model(largest)[1], "registers no image", "run the structure from motion again")
    notes = []
    if len(folders) > 1:
        counts = [f"{folder.relative_to(capture)} has {len(models[folder].images)} images" for folder in folders]
        notes.append(f"of several models {largest.relative_to(capture)} is used: {', '.join(counts)}")
    notes += _other_form(capture, largest, models[largest])
    return ChosenModel(largest, models[largest], notes)


def _other_form(capture: Path, folder: Path, model: Model) -> list[str]:
    """Return a note where the text form beside a binary one is another model: no one knows which is meant."""
    name = folder.relative_to(capture)
    try:
        other = read_other_form(folder)
    except UserError:
        return [f"{name}: the .bin files are used; those of .txt beside them cannot be read"]
    parts = [] if other is None else _differing(model, other)
    said = f"{name}: the .bin files are used; those of .txt beside them have other {', '.join(parts)}"
    return [said] if parts else []


def _differing(model: Model, other: Model) -> list[str]:
    """Return the parts in which two models differ by more than the digits of their forms."""
    found = []
    if not _same_entries(_cameras(model), _cameras(other)):
        found.append("cameras")
    if not _same_entries(_poses(model), _poses(other)):
        found.append("images or poses")
    positions = model.positions.shape == other.positions.shape and np.allclose(
        model.positions, other.positions, rtol=_DIGITS, atol=_DIGITS
    )
    return found if positions else [*found, "points"]


def _cameras(model: Model) -> dict[str, FloatArray]:
    return {
        f"{identifier} {camera.model}": np.array([camera.width, camera.height, *camera.params], dtype=np.float64)
        for identifier, camera in model.cameras.items()
    }


def _poses(model: Model) -> dict[str, FloatArray]:
    """Return rotation as a matrix, of which a quaternion and its negative give the same, and translation, by name."""
    return {
        image.name: np.column_stack([rotation_matrix(image.quaternion), image.translation])
        for image in model.images.values()
    }


def _same_entries(own: dict[str, FloatArray], others: dict[str, FloatArray]) -> bool:
    return own.keys() == others.keys() and all(
        np.allclose(values, others[name], rtol=_DIGITS, atol=_DIGITS) for name, values in own.items()
    )


def _candidates(capture: Path) -> list[Path]:
    """Return the folders that may hold a model, in order of preference: ascending numbers, then ``sparse`` itself."""
    found = []
    for part in (capture / "sparse", capture / "colmap" / "sparse"):
        if part.is_dir():
            numbered = [path for path in part.iterdir() if path.name.isdecimal() and path.is_dir()]
            found += [*sorted(numbered, key=lambda path: (int(path.name), path.name)), part]
    unique: list[Path] = []
    for folder in found:
        if not any(folder.samefile(other) for other in unique):
            unique.append(folder)
    return unique

"""Which model of a capture is read: structure from motion often leaves several, each of a part of the images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from avs.scene.colmap import Model, find_model, has_model, read_model
from avs.system.errors import UserError


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
    return ChosenModel(largest, models[largest], notes)


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

"""``scene.json``: what the COLMAP files of a scene do not say, and the hashes of all that they do."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal, Self

from pydantic import Field

from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from avs.system.files import canonical_json, file_hash
from avs.system.models import StrictModel
from avs.system.records import read_record

REMEDY = "prepare the scene again"
"""What to do about a scene that was damaged or edited."""

_MODEL_FILES = ("sparse/0/cameras.bin", "sparse/0/images.bin", "sparse/0/points3D.bin")


class SceneFile(StrictModel):
    """``scene.json``: what the COLMAP files do not say, and the hashes of all that they do."""

    schema_version: Literal[2] = 2
    name: str = Field(description="identifier, [a-z0-9_]+", pattern=r"^[a-z0-9_]+$")
    dataset: str = Field(description="name of the data set it belongs to, such as orbit or captures")
    test: list[str] = Field(description="names of the test images, ascending; all others are the pool")
    extent: float = Field(
        gt=0,
        description="1.1 times the greatest distance of a camera centre of the pool from their mean (3DGS), stray "
        "cameras left out; in scene units",
    )
    to_capture: Similarity = Field(
        description="from scene coordinates to those of the capture, as the mapper wrote them"
    )
    source: str = Field(description="where the pictures come from, one line")
    licence: str = Field(description="licence of the pictures, one line")
    notes: list[str] = Field(description="what a reader should know about the scene, such as images that were left out")
    images: dict[str, str] = Field(description="image name to the SHA-256 of its size and pixels")
    files: dict[str, str] = Field(description="path of every other file of the scene to the SHA-256 of its bytes")
    content_hash: str = Field(default="", description="SHA-256 over all other fields in canonical JSON")

    def hashed(self) -> Self:
        """Return the same with its content hash."""
        content = canonical_json(self.model_dump(mode="json", exclude={"content_hash"}))
        return self.model_copy(update={"content_hash": hashlib.sha256(content.encode()).hexdigest()})


def read_scene_file(folder: Path) -> SceneFile:
    """Read ``scene.json`` in ``folder`` and check that the model's files are the ones that it lists.

    Raises:
        UserError: a file is missing, damaged or another one.
    """
    path = folder / "scene.json"
    if not path.is_file():
        raise UserError(path, "is missing", REMEDY)
    listed = read_record(path, SceneFile, REMEDY)
    if listed.content_hash != listed.hashed().content_hash:
        raise UserError(path, "its content hash does not fit what it says", REMEDY)
    for name in _MODEL_FILES:
        if name not in listed.files or not (folder / name).is_file():
            raise UserError(folder / name, "is missing", REMEDY)
        if file_hash(folder / name) != listed.files[name]:
            raise UserError(folder / name, "is not the file that scene.json lists", REMEDY)
    return listed

"""The JSON schemas of what the workflow reads and writes, generated from the typed models."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel

from avs.config.run_config import Config
from avs.coverage.coverage_record import Coverage, CoverageMeta, Reference
from avs.nvs.common_states_record import CommonStates
from avs.nvs.program import ViewList
from avs.nvs.record import Episode, EpisodeMeta
from avs.nvs.timing_record import Runtime
from avs.scene.scene import SceneFile
from avs.slam.loop.exploration_record import ExplorationMeta, ExplorationRecord
from avs.system.computed_by import ComputedBy
from avs.system.files import write_json
from avs.system.records import DIGEST

SCHEMAS: dict[str, type[BaseModel]] = {
    "config.json": Config,
    "scene.json": SceneFile,
    "episode.json": Episode,
    "episode.meta.json": EpisodeMeta,
    "views.json": ViewList,
    "common_states.json": CommonStates,
    "runtime.json": Runtime,
    "coverage.json": Coverage,
    "coverage.meta.json": CoverageMeta,
    "computed_by.json": ComputedBy,
    "reference.json": Reference,
    "exploration.json": ExplorationRecord,
    "exploration.meta.json": ExplorationMeta,
}


_WITHOUT_DIGEST = (Config, ViewList)  # written by others than the suite


def schema(model: type[BaseModel]) -> dict[str, Any]:
    """Return the JSON schema of a model, with the digest that every record carries on disk."""
    found = model.model_json_schema()
    if model not in _WITHOUT_DIGEST:
        told = "SHA-256 over the canonical JSON of all other entries"
        found["properties"][DIGEST] = {"description": told, "type": "string"}
        found["required"] = [*found.get("required", []), DIGEST]
    return found


def write_schemas(folder: Path) -> None:
    """Write one schema per model to ``folder``; a test fails when they are out of date."""
    for name, model in SCHEMAS.items():
        write_json(folder / name, schema(model))

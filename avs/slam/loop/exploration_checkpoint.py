"""An exploration on disk while it runs, so that a killed one goes on from its last checkpoint to the same bytes."""

from __future__ import annotations

import json
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np

from avs.selection.registry import find
from avs.slam.building.robot_camera import Pose
from avs.slam.loop.exploration_loop import Exploration
from avs.slam.loop.exploration_record import CoveragePoint, Decision
from avs.slam.loop.slam_settings import SlamSettings
from avs.slam.mapping.mapper_state import mapper_arrays, restore_mapper
from avs.slam.scoring.path_settings import SelectorPathSettings
from avs.system.code_inputs import sources, stamp
from avs.system.errors import UserError
from avs.system.tensor_files import read_tensors, write_tensors

_HEADER = "exploration"


def save_exploration(path: Path, exploration: Exploration, code: str) -> None:
    """Write a checkpoint atomically; ``code`` is what ``program_of`` returns."""
    grid = exploration.grid
    arrays, mapper = mapper_arrays(exploration.mapper)
    arrays |= {
        "grid.occupied": grid.occupied,
        "grid.free": grid.free,
        "grid.blocked": grid.blocked,
        "seen": exploration.surface.seen,
        "trajectory": np.array([astuple(pose) for pose in exploration.trajectory]).reshape(-1, 4),
        "targets": np.array(exploration.targets).reshape(-1, 2),
    }
    clocks = exploration.clocks
    values = {
        "made_of": _made_of(exploration, code),
        "mapper": mapper,
        "pose": list(astuple(exploration.pose)),
        "step": exploration.step,
        "length": exploration.length,
        "collisions": exploration.collisions,
        "decisions": [decision.model_dump(mode="json") for decision in exploration.decisions],
        "curve": [point.model_dump(mode="json") for point in exploration.curve],
        "clocks": [clocks.seconds, clocks.decisions, clocks.scores, clocks.memory],
    }
    write_tensors(path, arrays, _HEADER, values)


def load_exploration(path: Path, exploration: Exploration, code: str) -> bool:
    """Put an exploration that has not begun into the state of a checkpoint; return whether there was one to go on from.

    One that is damaged, or of another building, seed or program, of other settings or weights, is none.
    """
    if not path.is_file():
        return False
    try:
        arrays, values = read_tensors(path, _HEADER, "delete it")
    except UserError:
        return False
    if values["made_of"] != _made_of(exploration, code):
        return False
    restore_mapper(exploration.mapper, arrays, values["mapper"])
    grid = exploration.grid
    for name, array in (("occupied", grid.occupied), ("free", grid.free), ("blocked", grid.blocked)):
        array[:] = arrays[f"grid.{name}"]
    exploration.surface.seen[:] = arrays["seen"]
    exploration.trajectory = [Pose(*row) for row in arrays["trajectory"].tolist()]
    exploration.targets = list(arrays["targets"])
    exploration.pose = Pose(*values["pose"])
    exploration.step, exploration.length = values["step"], values["length"]
    exploration.collisions = values["collisions"]
    exploration.decisions = [Decision.model_validate_json(json.dumps(each)) for each in values["decisions"]]
    exploration.curve = [CoveragePoint.model_validate_json(json.dumps(each)) for each in values["curve"]]
    clocks = exploration.clocks
    clocks.seconds, clocks.decisions, clocks.scores, clocks.memory = values["clocks"]
    return True


def program_of(settings: SlamSettings, weights: Path | None) -> str:
    """Return a digest of all that makes an exploration beside building, settings and seed.

    That is the code, the module of a method of Task A that chooses its paths, and the file of its weights.
    """
    scorer = settings.scorer
    own = [find(scorer.method).module] if isinstance(scorer, SelectorPathSettings) else []
    files = sources("avs.slam.loop.exploration_run", *own)
    return stamp(files if weights is None else [*files, str(weights)])


def _made_of(exploration: Exploration, code: str) -> dict[str, Any]:
    return {
        "code": code,
        "building": exploration.world.name,
        "mesh": exploration.world.digest,
        "seed": exploration.seed,
        "settings": exploration.settings.model_dump(mode="json"),
    }

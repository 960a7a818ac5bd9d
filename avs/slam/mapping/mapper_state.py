"""All that a mapper's further frames depend on, as arrays and plain values; from them it goes on to the bit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import Parameter

from avs.scene.cameras import Cameras
from avs.slam.mapping.gaussian_map import NAMES
from avs.slam.mapping.keyframes import Keyframe
from avs.slam.mapping.mapper import Mapper

Arrays = dict[str, npt.NDArray[Any]]


def mapper_arrays(mapper: Mapper) -> tuple[Arrays, dict[str, Any]]:
    """Return the state of a mapper: arrays by name, and values that JSON can hold.

    Optimisers have none: each optimisation of the map begins with new ones.
    """
    keyframes = mapper.keyframes
    arrays: Arrays = {f"map.{name}": mapper.tensors[name].detach().numpy() for name in NAMES}
    arrays["poses"] = np.array(mapper.poses).reshape(-1, 4, 4)
    if keyframes:
        arrays |= {
            "keyframes.number": np.array([each.number for each in keyframes], np.int64),
            "keyframes.pose": np.concatenate([each.camera.world_to_camera for each in keyframes]),
            "keyframes.intrinsics": np.concatenate([each.camera.intrinsics for each in keyframes]),
            "keyframes.rgb": np.stack([each.rgb for each in keyframes]),
            "keyframes.millimetres": np.stack([each.millimetres for each in keyframes]),
        }
    generator = mapper.rng.bit_generator.state
    return arrays, {"radius": mapper.radius, "generator": generator, "seconds": mapper.seconds}


def restore_mapper(mapper: Mapper, arrays: Mapping[str, npt.NDArray[Any]], values: Mapping[str, Any]) -> None:
    """Put a mapper of the same settings into the state that ``mapper_arrays`` returned."""
    mapper.tensors = {name: Parameter(torch.from_numpy(arrays[f"map.{name}"].copy())) for name in NAMES}
    mapper.poses = list(arrays["poses"])
    mapper.keyframes = []
    for row, number in enumerate(arrays.get("keyframes.number", ())):
        rgb, depth = arrays["keyframes.rgb"][row], arrays["keyframes.millimetres"][row]
        size = np.array([[depth.shape[1], depth.shape[0]]], np.int64)
        poses, intrinsics = arrays["keyframes.pose"], arrays["keyframes.intrinsics"]
        camera = Cameras(poses[row : row + 1], intrinsics[row : row + 1], size)
        mapper.keyframes.append(Keyframe(int(number), camera, rgb, depth))
    mapper.radius = float(values["radius"])
    mapper.rng.bit_generator.state = values["generator"]
    mapper.seconds = dict(values["seconds"])

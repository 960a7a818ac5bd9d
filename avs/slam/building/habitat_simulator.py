"""Pictures rendered by Habitat-Sim, where it is installed, behind the contract of the simulator of this suite.

Only the pictures are Habitat's. The floor, the robot's motion and what is measured come from the mesh, as they do
without it, so that explorations with either can be compared. Habitat-Sim comes by conda alone
(github.com/facebookresearch/habitat-sim); its public interface is that of version 0.2.4 and later.
"""

from __future__ import annotations

import importlib
import math
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol

import numpy as np

from avs.scene.cameras import Cameras
from avs.slam.building.building_mesh import Building
from avs.slam.building.simulator import Frame, Simulator
from avs.system.errors import UserError

_COLOR, _DEPTH = "color", "depth"

# Habitat's world has y upwards, its cameras look along -z with y upwards.
_TO_HABITAT = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
_TO_OPENGL = np.diag([1.0, -1.0, -1.0])


class _Opened(Protocol):
    """What is used of ``habitat_sim.Simulator``."""

    def get_agent(self, agent_id: int) -> Any: ...  # noqa: ANN401 - has no types

    def get_sensor_observations(self) -> dict[str, Any]: ...

    def close(self) -> None: ...


class HabitatSimulator(Simulator):
    """A building that Habitat-Sim renders."""

    def __init__(self, path: Path, raw: Building, building: Building) -> None:
        """Open the mesh.

        Args:
            path: of its file, which Habitat reads itself.
            raw: as it stands in the file.
            building: the same, upright and in metres.

        Raises:
            UserError: Habitat-Sim is not installed, or would see the mesh lying or in another unit.
        """
        super().__init__(building, samples=1)
        self._library = _library()
        self._path = path
        self._opened: dict[tuple[bytes, bytes], _Opened] = {}
        if not np.allclose(building.vertices @ _TO_HABITAT.T, raw.vertices, atol=1e-3):
            fault = "has another upward axis than y or another unit than metres, which Habitat-Sim would not notice"
            raise UserError(path, fault, "convert the mesh, or render by rays (slam.robot.simulator.renderer)")

    def observe(self, camera: Cameras) -> Frame:
        """Return what one camera sees, as Habitat renders it.

        Args:
            camera: a batch of one, with its principal point in the middle and square pixels.
        """
        simulator = self._simulator(camera)
        pose = camera.world_to_camera[0]
        state = self._library.AgentState()
        state.position = (_TO_HABITAT @ camera.centers[0]).astype(np.float32)
        state.rotation = _quaternion(_TO_HABITAT @ pose[:3, :3].T @ _TO_OPENGL)
        simulator.get_agent(0).set_state(state)
        seen = simulator.get_sensor_observations()
        depth = np.ascontiguousarray(seen[_DEPTH], dtype=np.float32)
        rgb = np.where(depth[..., None] > 0, seen[_COLOR][..., :3], 0).astype(np.uint8)
        return Frame(rgb, depth)

    def _simulator(self, camera: Cameras) -> _Opened:
        """Return the simulator with sensors of this lens, which is opened once."""
        key = (camera.intrinsics[0].tobytes(), camera.sizes[0].tobytes())
        if key not in self._opened:
            for other in self._opened.values():
                other.close()
            self._opened = {key: self._open(camera)}
        return self._opened[key]

    def _open(self, camera: Cameras) -> _Opened:
        library, matrix = self._library, camera.intrinsics[0]
        width, height = (int(side) for side in camera.sizes[0])
        if not np.allclose([matrix[0, 2], matrix[1, 2], matrix[0, 0]], [width / 2, height / 2, matrix[1, 1]]):
            raise ValueError("Habitat-Sim's pinhole has square pixels and its principal point in the middle")
        sensors = []
        for name, kind in ((_COLOR, library.SensorType.COLOR), (_DEPTH, library.SensorType.DEPTH)):
            sensor = library.CameraSensorSpec()
            sensor.uuid, sensor.sensor_type = name, kind
            sensor.resolution, sensor.position = [height, width], [0.0, 0.0, 0.0]
            sensor.hfov = math.degrees(2 * math.atan(width / 2 / matrix[0, 0]))
            sensors.append(sensor)
        scene, agent = library.SimulatorConfiguration(), library.agent.AgentConfiguration()
        scene.scene_id, scene.enable_physics = str(self._path), False
        agent.sensor_specifications = sensors
        opened: _Opened = library.Simulator(library.Configuration(scene, [agent]))
        return opened


def _library() -> ModuleType:
    try:
        return importlib.import_module("habitat_sim")
    except ImportError as error:
        remedy = "install it by conda (aihabitat.org), or render by rays"
        raise UserError("slam.robot.simulator.renderer", f"habitat_sim cannot be imported ({error})", remedy) from error


def _quaternion(rotation: np.ndarray[Any, np.dtype[np.float64]]) -> list[float]:
    """Return a rotation as Habitat takes it from a list: x, y, z, w."""
    from scipy.spatial.transform import Rotation

    return [float(value) for value in Rotation.from_matrix(rotation).as_quat()]

"""Habitat-Sim behind the simulator's contract, held to a stand-in with its conventions that renders by rays."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from building_factory import room, textured, write_glb
from scipy.spatial.transform import Rotation

from avs.datasets.embedded.apartment import ply_bytes
from avs.scene.cameras import Cameras
from avs.slam.building.opened_building import open_simulator
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.building.simulator_settings import SimulatorSettings
from avs.system.errors import UserError

HABITAT = SimulatorSettings(renderer="habitat")
CAMERA = CameraSettings(width=48, height=32)


class StandIn:
    """Renders as Habitat does: a world with y upwards, cameras that look along -z, rotations as x, y, z, w."""

    def __init__(self, configuration):
        scene, (agent,) = configuration
        self.scene, self.sensors = scene, agent.sensor_specifications
        self.simulator = open_simulator(Path(scene.scene_id), RAYS)
        self.closed = False

    def get_agent(self, number):
        assert number == 0
        return SimpleNamespace(set_state=lambda state: setattr(self, "state", state))

    def close(self):
        self.closed = True

    def get_sensor_observations(self):
        sensor = self.sensors[0]
        height, width = sensor.resolution
        focal = width / 2 / np.tan(np.radians(sensor.hfov) / 2)
        turned = Rotation.from_quat(self.state.rotation).as_matrix()
        forward, up, right = -turned[:, 2], turned[:, 1], turned[:, 0]
        # world (x, y, z) of Habitat is (x, -z, y) with z upwards
        upright = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        rotation = np.stack([upright @ right, -upright @ up, upright @ forward])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = rotation, -rotation @ upright @ self.state.position
        lens = np.array([[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]])
        frame = self.simulator.observe(Cameras(pose[None], lens[None], np.array([[width, height]])))
        alpha = np.full((height, width, 1), 255, np.uint8)
        return {"color": np.concatenate([frame.rgb, alpha], axis=2), "depth": frame.depth}


RAYS = SimulatorSettings(samples=1)


@pytest.fixture
def habitat(monkeypatch):
    plain = dict.fromkeys(("AgentState", "CameraSensorSpec", "SimulatorConfiguration"), SimpleNamespace)
    library = SimpleNamespace(
        **plain,
        SensorType=SimpleNamespace(COLOR="color", DEPTH="depth"),
        agent=SimpleNamespace(AgentConfiguration=SimpleNamespace),
        Configuration=lambda scene, agents: (scene, agents),
        Simulator=StandIn,
    )
    monkeypatch.setitem(sys.modules, "habitat_sim", library)


@pytest.fixture
def glb(tmp_path):
    """A wall and a floor, y upwards, of different colours by their place."""
    positions = [(2, 0, 1), (2, 0, -2), (2, 2.5, -2), (2, 2.5, 1), (-1, 0, 1), (-1, 0, -2)]
    write_glb(tmp_path / "wall.glb", positions, [(0, 0)] * 6, [[0, 1, 2], [0, 2, 3], [4, 5, 1], [4, 1, 0]])
    return tmp_path / "wall.glb"


@pytest.mark.parametrize("yaw", [0.0, 0.7, -1.1])
def test_poses_and_lens_are_handed_over_in_its_conventions(habitat, glb, yaw):
    camera = camera_at(Pose(0.2, 0.4, 0.0, yaw), CAMERA)
    seen, expected = open_simulator(glb, HABITAT).observe(camera), open_simulator(glb, RAYS).observe(camera)
    assert (expected.depth > 0).any()
    assert np.allclose(seen.depth, expected.depth, atol=1e-4)
    assert np.mean(seen.rgb == expected.rgb) > 0.99


def test_another_lens_opens_it_anew_and_closes_the_first(habitat, glb):
    simulator = open_simulator(glb, HABITAT)
    simulator.observe(camera_at(Pose(0, 0, 0, 0), CAMERA))
    (first,) = simulator._opened.values()
    simulator.observe(camera_at(Pose(0, 0, 0, 0.1), CAMERA))
    assert list(simulator._opened.values()) == [first]
    wide = CameraSettings(width=48, height=32, field_of_view=60)
    assert simulator.observe(camera_at(Pose(0, 0, 0, 0), wide)).depth.shape == (32, 48)
    assert first.closed


def test_a_mesh_that_it_would_see_lying_is_refused(habitat, tmp_path):
    mesh = textured(room())
    (tmp_path / "room.ply").write_bytes(ply_bytes(mesh.vertices, mesh.triangles))
    with pytest.raises(UserError, match="another upward axis than y or another unit"):
        open_simulator(tmp_path / "room.ply", HABITAT)


def test_without_it_one_line_says_what_to_do(monkeypatch, glb):
    monkeypatch.setitem(sys.modules, "habitat_sim", None)
    with pytest.raises(UserError, match=r"habitat_sim cannot be imported .* render by rays"):
        open_simulator(glb, HABITAT)


def test_rays_remain_the_default(glb):
    assert type(open_simulator(glb, SimulatorSettings())) is Simulator

"""Views of a textured room, and maps of them, that several tests share."""

import numpy as np
from building_factory import room, textured

from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.mapping.gaussian_map import map_seen
from avs.slam.mapping.mapper import Mapper

CAMERA = CameraSettings(width=96, height=72)
PIXELS = 96 * 72
SIMULATOR = Simulator(textured(room(things=[((2.5, 1.0, 0.0), (3.2, 1.9, 1.1))])))


def view(x=1.0, y=1.5, yaw=0.0):
    """Return what is seen in the room, and the camera."""
    camera = camera_at(Pose(x, y, 0.0, yaw), CAMERA)
    return SIMULATOR.observe(camera), camera


def errors_of(settings, spoil=lambda frame, camera: (frame, camera), turn=0.1):
    """Map a turn on the spot from spoilt frames; return the median ratio of depth to truth and the error of colour."""
    mapper = Mapper(settings, 0)
    poses = [(1.0, 1.5, turn * k) for k in range(8)]
    for pose in poses:
        mapper.add(*spoil(*view(*pose)))
    ratios, colors = [], []
    for pose in poses:
        frame, camera = view(*pose)
        seen = map_seen(mapper.tensors, camera)
        ratios.append((seen.depth / seen.alpha).numpy() / frame.depth)
        colors.append(np.abs(seen.rgb.numpy() - frame.rgb / 255).mean())
    return np.median(ratios), np.mean(colors), mapper

"""The simulator: depth and colours of rooms whose every measure is known, and meshes that are troublesome."""

import io

import numpy as np
import pytest
from building_factory import box_faces, building, room, write_glb
from PIL import Image

from avs.datasets.embedded.apartment import ply_bytes
from avs.slam.building.building_files import read_building
from avs.slam.building.building_frame import FrameSettings, upright
from avs.slam.building.opened_building import open_simulator
from avs.slam.building.robot_camera import CameraSettings, Pose, camera_at
from avs.slam.building.simulator import Simulator
from avs.slam.building.simulator_settings import SimulatorSettings
from avs.system.errors import UserError

CAMERA = CameraSettings(width=64, height=48)


def test_depth_is_along_the_optical_axis():
    frame = Simulator(room()).observe(camera_at(Pose(1.0, 1.5, 0.0, 0.0), CAMERA))
    # the wall ahead is 3 m away over all columns that it fills, not only in the middle
    assert np.allclose(frame.depth[24, 17:47], 3.0, atol=1e-5)
    # a pixel of the floor: the camera is 1.25 m above it, f is 32
    assert frame.depth[47, 32] == pytest.approx(1.25 * 32 / 23.5, abs=1e-5)


@pytest.mark.parametrize(("yaw", "wall"), [(0.0, 3), (np.pi / 2, 5), (np.pi, 2), (-np.pi / 2, 4)])
def test_yaw_turns_from_x_towards_y(yaw, wall):
    colors = np.zeros((6, 3))
    colors[wall] = (1.0, 0.6, 0.0)
    mesh = building(box_faces((0, 0, 0), (4, 3, 2.5)), colors)
    frame = Simulator(mesh, samples=1).observe(camera_at(Pose(2.0, 1.5, 0.0, yaw), CAMERA))
    assert frame.rgb[24, 32].tolist() == [255, 153, 0]


def test_what_is_to_the_left_appears_on_the_left():
    colors = np.zeros((6, 3))
    colors[5] = 1.0  # the wall at high y, which is to the left of one who looks along x
    mesh = building(box_faces((0, 0, 0), (4, 3, 2.5)), colors)
    frame = Simulator(mesh, samples=1).observe(camera_at(Pose(2.0, 1.5, 0.0, 0.0), CAMERA))
    assert frame.rgb[24, 0].tolist() == [255] * 3
    assert frame.rgb[24, 63].tolist() == [0] * 3


def test_a_hole_has_neither_depth_nor_colour():
    mesh = building(box_faces((0, 0, 0), (4, 3, 2.5))[:3])
    frame = Simulator(mesh).observe(camera_at(Pose(2.0, 1.5, 0.0, 0.0), CAMERA))
    assert frame.depth[24, 32] == 0
    assert frame.rgb[24, 32].tolist() == [0, 0, 0]


def test_a_wall_without_thickness_is_seen_from_both_sides():
    wall = [np.array([(2, 0, 0), (2, 3, 0), (2, 3, 2.5), (2, 0, 2.5)], np.float32)]
    simulator = Simulator(building(wall), samples=1)
    for x, yaw in ((1.0, 0.0), (3.0, np.pi)):
        frame = simulator.observe(camera_at(Pose(x, 1.5, 0.0, yaw), CAMERA))
        assert frame.depth[24, 32] == pytest.approx(1.0, abs=1e-5)
        assert frame.rgb[24, 32].tolist() == [128, 128, 128]


def test_depth_alone_is_that_of_the_frame():
    simulator, camera = Simulator(room()), camera_at(Pose(1.0, 1.5, 0.0, 0.4), CAMERA)
    assert np.array_equal(simulator.depth(camera), simulator.observe(camera).depth)


def picture():
    """Return a PNG whose quarters are red, green (above), blue, white (below)."""
    pixels = np.zeros((64, 64, 3), np.uint8)
    pixels[:32, :32], pixels[:32, 32:] = (255, 0, 0), (0, 255, 0)
    pixels[32:, :32], pixels[32:, 32:] = (0, 0, 255), (255, 255, 255)
    stream = io.BytesIO()
    Image.fromarray(pixels).save(stream, "PNG")
    return stream.getvalue()


def wall_glb(path, height=2.5, **options):
    """Write a wall at x = 2 with y upwards, whose picture stands upright for who looks at it from the origin."""
    # turned upright, y becomes z and z becomes -y: the wall spans y = -1..2 there, left is high y
    positions = [(2, 0, 1), (2, 0, -2), (2, height, -2), (2, height, 1)]
    coordinates = [(1, 1), (0, 1), (0, 0), (1, 0)]  # v runs downwards in glTF
    write_glb(path, positions, coordinates, [[0, 1, 2], [0, 2, 3]], **options)


def test_a_texture_stands_upright(tmp_path):
    wall_glb(tmp_path / "wall.glb", picture=picture())
    simulator = open_simulator(tmp_path / "wall.glb", SimulatorSettings(samples=1))
    frame = simulator.observe(camera_at(Pose(0.5, 0.5, 0.0, 0.0), CAMERA))
    corners = [frame.rgb[row, column].tolist() for row, column in ((20, 20), (20, 44), (28, 20), (28, 44))]
    assert corners == [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]]


def test_a_texture_is_interpolated():
    mesh = building([np.array([(2, 0, 0), (2, 3, 0), (2, 3, 2.5), (2, 0, 2.5)], np.float32)], [(1, 1, 1)])
    corners = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    texture = np.array([[[0] * 3, [200] * 3]], np.uint8)
    mesh = type(mesh)(mesh.vertices, mesh.triangles, mesh.vertex_colors, corners, np.zeros(2, np.int32), (texture,))
    camera = camera_at(Pose(0.5, 1.5, 0.0, 0.0), CameraSettings(width=65, height=65))
    # in the middle between the texels' centres
    assert Simulator(mesh, samples=1).observe(camera).rgb[32, 32].tolist() == [100] * 3


def test_faces_of_four_corners_are_read_whole(tmp_path):
    # Replica's meshes are of such faces
    names = [f"float {axis}" for axis in "xyz"] + [f"uchar {name}" for name in ("red", "green", "blue")]
    header = ["ply", "format ascii 1.0", "element vertex 4", *(f"property {name}" for name in names)]
    header += ["element face 1", "property list uchar int vertex_indices", "end_header"]
    corners = ["2 0 0", "2 3 0", "2 3 2.5", "2 0 2.5"]
    lines = [*header, *(f"{corner} 255 128 0" for corner in corners), "4 0 1 2 3"]
    (tmp_path / "wall.ply").write_text("\n".join(lines) + "\n")
    simulator = open_simulator(tmp_path / "wall.ply", SimulatorSettings(samples=1))
    frame = simulator.observe(camera_at(Pose(0.5, 1.5, 0.0, 0.0), CAMERA))
    assert frame.rgb[24, [15, 32, 48]].tolist() == [[255, 128, 0]] * 3
    # all of the wall: f is 32 and it is 1.5 m away, the lower part of the picture ends 0.12 m above the floor
    assert np.count_nonzero(frame.depth) == 64 * 48


def test_a_plain_mesh_is_grey_and_says_so(tmp_path):
    mesh = room()
    (tmp_path / "plain.ply").write_bytes(ply_bytes(mesh.vertices, mesh.triangles))
    assert read_building(tmp_path / "plain.ply").notes == ("surfaces without texture and colours are grey",)


@pytest.mark.parametrize(
    ("scale", "told"), [(100, "centimetres"), (1000, "millimetres"), (1 / 0.0254, "inches"), (1 / 0.3048, None)]
)
def test_a_wrong_unit_is_found_by_the_height(scale, told):
    mesh = room()
    mesh = type(mesh)(**{**vars(mesh), "vertices": mesh.vertices * np.float32(scale)})
    found = upright(mesh, FrameSettings(), ".ply", "mesh")
    if told is None:  # 8.2 feet are a possible height in metres: the user has to say
        assert found.box[1][2] == pytest.approx(2.5 * scale, rel=1e-5)
        assert found.notes == ("its unit is taken for metres, in which it is 8.2 m high",)
        assert not upright(mesh, FrameSettings(metres=1), ".ply", "mesh").notes
        assert not upright(mesh, FrameSettings(up="z"), ".glb", "mesh").notes  # the format's unit is the metre
    else:
        assert np.allclose(found.box[1], (4, 3, 2.5), atol=1e-4)
        assert told in found.notes[0]
    assert np.allclose(upright(mesh, FrameSettings(metres=1 / scale), ".ply", "mesh").box[1], (4, 3, 2.5), atol=1e-4)


def test_the_upward_axis_is_found_and_said():
    mesh = room()
    turned = type(mesh)(**{**vars(mesh), "vertices": mesh.vertices[:, [0, 2, 1]] * np.array([1, 1, -1], np.float32)})
    found = upright(turned, FrameSettings(), ".ply", "mesh")
    assert np.allclose(found.vertices, mesh.vertices)
    assert "y is taken for the upward axis" in found.notes[0]
    assert not upright(turned, FrameSettings(), ".glb", "mesh").notes


def test_a_texture_of_a_ply_file_is_said_not_to_be_read(tmp_path):
    mesh = room()
    content = ply_bytes(mesh.vertices, mesh.triangles)
    (tmp_path / "a.ply").write_bytes(content.replace(b"\nelement", b"\ncomment TextureFile wall.png\nelement", 1))
    assert "the texture that it names is not read" in read_building(tmp_path / "a.ply").notes[-1]


def test_what_is_no_building_is_refused():
    mesh = room()
    flat = type(mesh)(**{**vars(mesh), "vertices": mesh.vertices * np.array([1, 1, 1e-3], np.float32)})
    with pytest.raises(UserError, match="which is no building"):
        upright(flat, FrameSettings(up="z"), ".ply", "mesh")


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        ({"extensionsRequired": ["KHR_texture_basisu"]}, "Basis textures"),
        ({"extensionsUsed": ["KHR_draco_mesh_compression"]}, "Draco"),
        ({"mime": "image/ktx2"}, "Basis textures"),
    ],
)
def test_contents_that_would_be_left_out_are_refused(tmp_path, options, fault):
    wall_glb(tmp_path / "wall.glb", picture=picture(), **options)
    with pytest.raises(UserError, match=fault):
        read_building(tmp_path / "wall.glb")


def test_damaged_and_missing_files_are_one_line(tmp_path):
    wall_glb(tmp_path / "wall.glb", picture=picture())
    content = (tmp_path / "wall.glb").read_bytes()
    for name, damaged in {"cut.glb": content[:100], "text.glb": b"hello", "empty.ply": b"", "empty.obj": b""}.items():
        (tmp_path / name).write_bytes(damaged)
        with pytest.raises(UserError, match=name):
            read_building(tmp_path / name)
    for name in ("none.ply", "mesh.stl"):
        with pytest.raises(UserError, match=name):
            read_building(tmp_path / name)


def test_a_pose_with_nan_is_refused():
    with pytest.raises(ValueError, match="finite"):
        camera_at(Pose(float("nan"), 0, 0, 0), CAMERA)

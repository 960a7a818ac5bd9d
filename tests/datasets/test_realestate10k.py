"""RealEstate10K: a miniature of its texts, with a video that the test makes, becomes a scene; faults."""

import re
from pathlib import Path

import av
import numpy as np
import pytest

from avs.datasets.realestate10k import RealEstate10K, read_posed_frames
from avs.datasets.video_frames import frames_at
from avs.system.errors import UserError
from tests import tolerances
from tests.datasets.reader_checks import assert_refused, first_scene
from tests.datasets.textured_factory import (
    CENTER,
    FOCAL,
    SIZE,
    assert_points_lie_on_the_surfaces,
    assert_poses_are,
    photograph,
    poses,
)

SHARED = Path(__file__).parents[3] / "shared" / "formats" / "realestate10k"
RATE, FIRST, COUNT = 10, 20, 10
"""Frames a second; the scene's first frame in the video; frames of the scene."""


def write_video(path, frames, codec="libx264"):
    """A video without loss, or nearly, so that features stay where they are."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=RATE)
        stream.width, stream.height, stream.pix_fmt = *SIZE, "yuv444p" if codec == "libx264" else "yuv420p"
        stream.options = {"crf": "4", "preset": "ultrafast", "g": "12"}
        for pixels in frames:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode())


def text_of(video="QShWPZxTDoE", late=7000):
    """The poses; each time is ``late`` microseconds after that of its frame."""
    shares = [FOCAL[0] / SIZE[0], FOCAL[1] / SIZE[1], CENTER[0] / SIZE[0], CENTER[1] / SIZE[1], 0, 0]
    lines = [f"https://www.youtube.com/watch?v={video}"]
    for row, pose in enumerate(poses(COUNT)):
        numbers = [*shares, *pose[:3].ravel()]
        lines.append(f"{(FIRST + row) * 1000000 // RATE + late} " + " ".join(f"{number:.9f}" for number in numbers))
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("realestate10k")
    grey = [np.full((SIZE[1], SIZE[0], 3), 5 * row, np.uint8) for row in range(FIRST)]
    write_video(folder / "videos" / "QShWPZxTDoE.mp4", [*grey, *map(photograph, poses(COUNT)), *grey])
    (folder / "test").mkdir()
    (folder / "test" / "0bf152ef84195293.txt").write_text(text_of())
    (folder / "test" / "1111111111111111.txt").write_text(text_of("aaaaaaaaaaa"))
    return folder


@pytest.fixture
def copy(original, tmp_path):
    """The same with a text of its own, that a test may damage."""
    (tmp_path / "test").mkdir()
    (tmp_path / "videos").mkdir()
    (tmp_path / "test" / "0bf152ef84195293.txt").write_text(text_of())
    content = (original / "videos" / "QShWPZxTDoE.mp4").read_bytes()
    (tmp_path / "videos" / "QShWPZxTDoE.mp4").write_bytes(content)
    return tmp_path


def reader(folder, **settings):
    return RealEstate10K(folder=str(folder / "test"), videos=str(folder / "videos"), **settings)


def prepared(folder, tmp_path, **settings):
    return first_scene(reader(folder, **settings), tmp_path, "realestate10k")


def test_the_frames_of_a_video_become_a_scene(original, tmp_path):
    scene = prepared(original, tmp_path)
    assert (scene.name, len(scene.names), scene.names[0]) == ("0bf152ef84195293", COUNT, "000002007000.png")
    assert_poses_are(scene, poses(COUNT), tolerances.POSES_OF_TEXT)
    np.testing.assert_allclose(scene.cameras.intrinsics[0, (0, 1, 0, 1), (0, 1, 2, 2)], [*FOCAL, *CENTER], atol=1e-6)
    assert_points_lie_on_the_surfaces(scene.to_capture.points(scene.points.positions), tolerances.TRIANGULATED)
    for index, pixels in enumerate(scene.views(np.arange(COUNT)).images):
        difference = np.abs(pixels.astype(int) - photograph(poses(COUNT)[index]))
        assert difference.mean() < tolerances.FRAME_OF_VIDEO


def test_two_videos_of_one_name_are_refused(copy, tmp_path):
    twin = copy / "videos" / "again" / "QShWPZxTDoE.webm"
    twin.parent.mkdir()
    twin.write_bytes(b"another encoding")
    with pytest.raises(UserError, match=r"second video of the name QShWPZxTDoE, beside .*; take one away"):
        prepared(copy, tmp_path)


def test_a_scene_without_its_video_is_named_and_the_others_go_on(original):
    chosen = reader(original, only=("0bf152ef84195293", "1111111111111111", "2222222222222222"))
    assert list(chosen.scenes()) == ["0bf152ef84195293"] == list(reader(original).scenes())
    assert "lacks its video, aaaaaaaaaaa" in str(chosen.left_out()["1111111111111111"])
    assert "is not there" in str(chosen.left_out()["2222222222222222"])
    assert [path.name for path in chosen.scenes()["0bf152ef84195293"].files()] == [
        "0bf152ef84195293.txt",
        "QShWPZxTDoE.mp4",
    ]
    with pytest.raises(UserError, match=r"videos: holds no video of the 1 wanted texts in .* \(aaaaaaaaaaa\)"):
        reader(original, only=("1111111111111111",)).scenes()


def test_of_two_texts_of_one_scene_name_one_is_left_out_with_the_reason(copy):
    """As train/0a.txt and test/0A.txt: the one that has the name itself stays, wherever it lies."""
    for part, name, late in (("train", "0A", 1), ("test", "0a", 2), ("train", "1B", 3), ("test", "1B", 4)):
        (copy / part).mkdir(exist_ok=True)
        (copy / part / f"{name}.txt").write_text(text_of(late=late))
    for only in (None, ("0a", "1b", "0bf152ef84195293")):
        chosen = RealEstate10K(folder=str(copy), videos=str(copy / "videos"), only=only)
        found = {name: Path(scene.folder).relative_to(copy).as_posix() for name, scene in chosen.scenes().items()}
        assert found == {
            "0a": "test/0a.txt",
            "0bf152ef84195293": "test/0bf152ef84195293.txt",
            "1b": "train/1B.txt",
        }
        assert {name: str(reason) for name, reason in chosen.left_out().items()} == {
            "train/0A.txt": "has the same scene name, 0a, as test/0a.txt: rename one",
            "test/1B.txt": "has the same scene name, 1b, as train/1B.txt: rename one",
        }


def test_one_clip_under_two_names_is_one_scene(copy):
    again = text_of().replace("watch?v=QShWPZxTDoE", "watch?app=desktop&v=QShWPZxTDoE").replace("\n", " \r\n")
    (copy / "test" / "again.txt").write_text(again)
    assert list(reader(copy).scenes()) == ["0bf152ef84195293"]
    assert str(reader(copy).left_out()["again.txt"]) == ("is the same clip as 0bf152ef84195293.txt: take one away")
    both = reader(copy, only=("again", "0bf152ef84195293"))
    assert list(both.left_out()) == ["again.txt"]
    alone = {path.stem: RealEstate10K(folder=str(path), videos="v") for path in (copy / "test").glob("*.txt")}
    one, other = alone["again"].identities(), alone["0bf152ef84195293"].identities()
    assert one[0] != other[0]
    assert one[1] == other[1]


def test_a_text_of_the_same_name_elsewhere_is_another_scene(copy, tmp_path):
    (tmp_path / "other").mkdir()
    path = tmp_path / "other" / "0bf152ef84195293.txt"
    path.write_text(text_of(late=1))
    (one,) = reader(copy).scenes().values()
    shared = set(one.identities()) & set(RealEstate10K(folder=str(path), videos="v").identities())
    assert shared == {("video", "QShWPZxTDoE")}


@pytest.mark.parametrize(
    ("only", "line"),
    [
        (None, r"empty: holds no texts <id>\.txt, nor does train or test in it; give the folder of the texts"),
        (("nosuch",), r"test: holds none of the texts that `only` names \(nosuch\); name some that are there"),
    ],
)
def test_a_folder_without_texts_is_told(only, line, copy):
    (copy / "empty").mkdir()
    folder = copy / ("test" if only else "empty")
    with pytest.raises(UserError, match=line):
        RealEstate10K(folder=str(folder), videos=str(copy / "videos"), only=only).scenes()


def test_frames_beyond_the_tolerance_are_left_out_and_counted(copy, tmp_path):
    text = copy / "test" / "0bf152ef84195293.txt"
    first, *lines = text.read_text().splitlines()
    moved = [line.replace("07000 ", "49000 ", 1) if row in (3, 5) else line for row, line in enumerate(lines)]
    text.write_text("\n".join([first, *moved]))
    scene = prepared(copy, tmp_path)
    assert len(scene.names) == 8
    assert scene.notes[0] == "2 of 10 frames are left out: the video has none within 0.02 s of their times"


def test_the_nearest_frame_is_taken_on_either_side(original):
    video = original / "videos" / "QShWPZxTDoE.mp4"
    means = {index: pixels.mean() for index, pixels in frames_at(video, [301_000, 399_000, 651_000], 10_000)}
    assert means.keys() == {0, 1}
    assert means[0] == pytest.approx(15, abs=2)
    assert means[1] == pytest.approx(20, abs=2)


def test_genuine_texts_are_read():
    if not SHARED.is_dir():
        pytest.skip("no genuine texts here")
    for path in sorted(SHARED.glob("*.txt")):
        told = read_posed_frames(path)
        assert len(told.times) == 16
        assert re.fullmatch(r"[\w-]{11}", told.video)
        rotations = told.world_to_camera[:, :3, :3]
        np.testing.assert_allclose(rotations @ rotations.swapaxes(1, 2), np.tile(np.eye(3), (16, 1, 1)), atol=1e-6)


def replaced(old, new):
    def damage(folder):
        path = folder / "test" / "0bf152ef84195293.txt"
        lines = path.read_text().splitlines()
        lines[3] = re.sub(old, new, lines[3], count=1)
        path.write_text("\n".join(lines))

    return damage


def video_of(content):
    def damage(folder):
        path = folder / "videos" / "QShWPZxTDoE.mp4"
        path.write_bytes(content(path.read_bytes()))

    return damage


FAULTS = {
    "time twice": (replaced(r"^\d+", "2107000"), r"has times that do not ascend, or one twice"),
    "line cut": (replaced(r" [^ ]+$", ""), r"line 4 has 18 numbers, not 19: it is damaged or cut off"),
    "NaN": (replaced(r" [^ ]+$", " nan"), r"line 4 has a number that is not finite"),
    "word": (replaced(r" [^ ]+$", " x"), r"line 4 is damaged: '2207000 "),
    "other columns": (replaced(r" 0\.000000000 0\.000000000", " 1 0"), r"the sixth and seventh are not zero"),
    "pose all zero": (
        replaced(r"(0\.000000000 0\.000000000).*", r"\1" + " 0" * 12),
        r"the pose at 2207000 is all zero; take the line out",
    ),
    "no rotation": (replaced(r"(0\.000000000 0\.000000000 )[^ ]+", r"\g<1>3"), r"000002207000\.png has no rotation"),
    "negative focal length": (replaced(r"^(\d+) ", r"\1 -"), r"camera \d has a focal length that is not positive"),
    "no frames": (
        lambda folder: (folder / "test" / "0bf152ef84195293.txt").write_text(text_of().splitlines()[0]),
        r"0bf152ef84195293\.txt: has no frames",
    ),
    "video of noise": (video_of(lambda content: bytes(range(256)) * 40), r"mp4: the video cannot be decoded"),
    "empty video": (video_of(lambda content: b""), r"mp4: the video cannot be decoded"),
    "video cut": (video_of(lambda content: content[: len(content) // 2]), r"mp4: the video cannot be decoded"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_told_in_one_line_and_leaves_nothing(fault, copy, tmp_path):
    damage, message = FAULTS[fault]
    damage(copy)
    assert_refused(lambda: prepared(copy, tmp_path), message, tmp_path)


def test_a_video_that_ends_early_is_told(copy, tmp_path):
    write_video(copy / "videos" / "QShWPZxTDoE.mp4", [photograph(poses(1)[0])] * 8)
    with pytest.raises(UserError, match=r"mp4: has 0 of the 10 frames that 0bf152ef84195293\.txt names"):
        prepared(copy, tmp_path)

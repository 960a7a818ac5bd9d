"""The page's files: what they say, that nothing is dropped silently, and that equal records are equal bytes."""

import base64
import io
import json
import shutil

import numpy as np
import pytest
from PIL import Image

from avs.nvs.record import Episode
from avs.report.document import Document, Group, Listing, Row
from avs.report.page.method_facts import method_sources
from avs.report.page.page_settings import PageSettings
from avs.report.page.script_files import plain_tree, script_text
from avs.report.page.site import SCRIPTS, STATIC, static_files
from avs.report.page.splat_bytes import splat_bytes
from avs.report.page.table_facts import table_place
from avs.representations.gaussians.ply import write_ply
from avs.scene.similarity import Similarity
from avs.system.errors import UserError
from avs.system.records import read_record
from tests.report.page_run import ABSENT, METHODS, write_run, write_whole_page
from tests.representations.test_ply import gaussians

LITTLE = 0.13
"""Megabytes that hold the numbers and pictures of the lowest seed, and not all models."""


def held(path):
    """Return the name and the value that a script of data hands to the page."""
    text = path.read_text()
    assert text.startswith("avs.receive(")
    assert text.endswith(");\n")
    name, _, value = text.removeprefix("avs.receive(").removesuffix(");\n").partition(",")
    return json.loads(name), json.loads(value)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    root = tmp_path_factory.mktemp("run")
    return root, write_run(root)


@pytest.fixture(scope="module")
def page(run, tmp_path_factory):
    return write_whole_page(*run, tmp_path_factory.mktemp("page"))


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_equal_records_give_equal_bytes(run, page, tmp_path):
    assert contents(write_whole_page(*run, tmp_path)) == contents(page)


def test_a_program_of_its_own_is_called_as_in_the_tables():
    rows = (Row("Theirs", (), identifier="theirs"), Row("all", ()))
    table = Document("nvs", (), (), (Group("3D-based", rows),), (), Listing((), ()))
    named, unknown = method_sources(["theirs", "nowhere"], {}, [table, table])
    assert (named["label"], named["group"], named["source"]) == ("Theirs", "3D-based", "a program of its own")
    assert unknown["label"] == "nowhere"


def test_every_script_is_called_by_its_place(page):
    for path in page.rglob("*.js"):
        if STATIC not in path.parts:
            assert held(path)[0] == path.relative_to(page).with_suffix("").as_posix()


def test_the_frame_loads_nothing_but_files_of_the_folder(page):
    text = (page / "index.html").read_text()
    assert "http" not in text
    assert 'type="module"' not in text
    for name in SCRIPTS:
        assert f'src="{STATIC}/{name}.js"' in text
        assert (page / STATIC / f"{name}.js").is_file()
    names = {path.stem for path in static_files() if path.suffix == ".js"}
    assert names == {*SCRIPTS, "splats.bundle"}


def test_an_episode_says_what_its_record_says(run, page):
    _, inputs = run
    path = next(path for path in inputs["toy"].episodes if "ours-repvit" in path.parts)
    record = read_record(path, Episode)
    told, scene = held(page / "scenes/toys/toy/ours-repvit-0.js")[1], held(page / "scenes/toys/toy/scene.js")[1]
    names = scene["names"]
    assert [names[place] for place in told["initial"]] == record.initial
    assert [names[place] for place in told["selected"]] == record.selected
    left, before = [], None
    for step, own in zip(told["steps"], record.steps, strict=True):
        left = step["candidates"] or [place for place in left if place not in before["chosen"]]
        before = step
        assert [names[place] for place in left] == own.candidates
        assert step["scores"] == pytest.approx(own.scores, rel=1e-4)
        assert [names[place] for place in step["chosen"]] == own.chosen
    psnr = np.mean([image.psnr for image in record.curve[-1].images])
    assert scene["episodes"]["ours-repvit-0"]["curve"][-1][3] == pytest.approx(psnr, rel=1e-5)
    assert told["provenance"]["scene_hash"] == record.scene_hash
    pictures = held(page / "scenes/toys/toy/ours-repvit-0-pictures.js")[1]
    assert {"final_000", "choice_00_0_rendering", "choice_00_0_predicted", "choice_00_0_true"} <= pictures.keys()
    content = base64.b64decode(pictures["choice_00_0_rendering"].partition(",")[2])
    assert Image.open(io.BytesIO(content)).size == (24, 16)


def test_a_method_that_did_not_run_is_there_with_its_reason(page):
    for method in (held(page / "index.js")[1]["methods"], held(page / "scenes/toys/toy/scene.js")[1]["methods"]):
        assert [each["id"] for each in method] == METHODS
        assert {each["id"]: each["absent"] for each in method if each["absent"]} == {"niqe": str(ABSENT["niqe"])}


def test_photographs_that_no_episode_captured_are_left_out(page):
    scene = held(page / "scenes/toys/toy/scene.js")[1]
    shown = {int(place) for place in held(page / "scenes/toys/toy/photographs.js")[1]["pictures"]}
    episodes = [held(path)[1] for path in page.glob("scenes/toys/toy/*-[01].js") if "states" not in path.name]
    assert shown == {place for each in episodes for place in [*each["initial"], *each["selected"], *each["kept"]]}
    assert len(shown) < len(scene["names"])


def test_what_the_limit_leaves_out_says_so(run, tmp_path):
    page = write_whole_page(*run, tmp_path, PageSettings(megabytes=LITTLE))
    told = [held(path)[1] for path in page.glob("scenes/toys/toy/*-[01].js") if "states" not in path.name]
    left_out = [each for each in told if each["no_splats"]]
    assert len(left_out) > 0
    assert all(f"limit of {LITTLE} MB (report.page.megabytes" in each["no_splats"] for each in left_out)
    for each in told:
        there = (page / f"scenes/toys/toy/{each['method']}-{each['seed']}-splats.js").exists()
        assert there == (each["no_splats"] is None)
    assert not next(each for each in told if each["seed"] == 0)["no_pictures"], "the lowest seed comes first"


def test_coverage_and_states_are_there_where_they_were_measured(page):
    told = held(page / "scenes/toys/toy/random-0.js")[1]
    levels = np.frombuffer(base64.b64decode(told["coverage"]["distances"]), dtype=np.uint8)
    # Distances 0 to 2 of an extent of 10, at a threshold of 0.01 extents: one is at it, those beyond 1 at the end.
    assert (levels[0], levels[-1]) == (0, 255)
    assert np.all(np.diff(levels.astype(int)) >= 0)
    assert "coverage" not in held(page / "scenes/toys/toy/farthest-0.js")[1]
    assert held(page / "scenes/toys/toy/scene.js")[1]["states"] == [0]
    assert held(page / "scenes/toys/attic/scene.js")[1]["states"] == []
    states = held(page / "scenes/toys/toy/states-0.js")[1]
    assert states["states"][1]["gain"] is None
    assert states["methods"][0]["scores"][1][1] is None


def test_another_version_of_the_scene_is_refused(run, tmp_path):
    root, inputs = run
    with pytest.raises(UserError, match="is not the scene of random's episode"):
        write_whole_page(root, {"toy": _with_folder(inputs["toy"], inputs["attic"].folder)}, tmp_path)


def _with_folder(inputs, folder):
    return type(inputs)(folder, inputs.episodes, inputs.coverage, inputs.states)


def test_a_folder_of_an_earlier_page_is_replaced(run, tmp_path):
    stale = tmp_path / "scenes" / "toys" / "toy" / "gone-0.js"
    stale.parent.mkdir(parents=True)
    stale.write_text("old")
    write_whole_page(*run, tmp_path)
    assert not stale.exists()


def test_splats_are_the_model_in_the_scenes_unit(tmp_path):
    model = gaussians(count=50)
    to_capture = Similarity(scale=2.0, translation=(1.0, 2.0, 3.0))
    write_ply(tmp_path / "splats.ply", model, to_capture)
    content, count = splat_bytes(tmp_path / "splats.ply", to_capture, 50)
    assert (len(content), count) == (50 * 32, 50)
    numbers = np.frombuffer(content, dtype="<f4").reshape(50, 8)[:, :6]
    places = model["means"].numpy()
    order = [int(np.argmin(np.abs(places - row[:3]).sum(axis=1))) for row in numbers]
    assert sorted(order) == list(range(50))
    np.testing.assert_allclose(numbers[:, :3], places[order], atol=1e-5)
    np.testing.assert_allclose(numbers[:, 3:], np.exp(model["scales"].numpy())[order], rtol=1e-4)
    bytes_ = np.frombuffer(content, dtype=np.uint8).reshape(50, 32)[:, 24:].astype(float)
    colours = np.clip(0.5 + 0.28209479 * model["sh"].numpy()[order, 0], 0, 1)
    np.testing.assert_allclose(bytes_[:, :3] / 255, colours, atol=0.5 / 255 + 1e-6)
    np.testing.assert_allclose(bytes_[:, 3] / 255, 1 / (1 + np.exp(-model["opacities"].numpy()[order])), atol=0.003)
    turns = model["quats"].numpy()[order]
    turns = turns / np.linalg.norm(turns, axis=1, keepdims=True)
    np.testing.assert_allclose((bytes_[:, 4:] - 128) / 128, np.minimum(turns, 127 / 128), atol=0.5 / 128 + 1e-6)
    few, count = splat_bytes(tmp_path / "splats.ply", to_capture, 10)
    assert (few, count) == (content[:320], 50)


def test_tables_have_their_place():
    assert table_place("nvs_orbit") == ("View synthesis", "orbit (twin of Mip-NeRF360)")
    assert table_place("runtime_memory") == ("Selection times", "time and memory")
    assert table_place("conjured") == ("Other", "conjured")


def test_data_cannot_break_out_of_a_script():
    hostile = {"a": "</script><script>alert(1)</script>\u2028", "b": "é\\\"'"}
    text = script_text("tables/x", hostile)
    assert text.isascii()
    assert json.loads(text.partition(",")[2].removesuffix(");\n")) == hostile
    with pytest.raises(ValueError, match="not JSON compliant"):
        script_text("x", float("nan"))
    assert plain_tree({"a": [1 / 3, "x", None, 10**9]}) == {"a": [0.333333, "x", None, 10**9]}


def test_damaged_inputs_are_one_line(run, tmp_path):
    root, inputs = run
    copy = tmp_path / "run"
    shutil.copytree(root / "episodes", copy / "episodes")
    path = copy / inputs["toy"].episodes[0].relative_to(root)
    path.with_name("pictures.zip").write_bytes(b"no archive")
    broken = type(inputs["toy"])(inputs["toy"].folder, [path])
    with pytest.raises(UserError, match=r"pictures\.zip: is not the file that the record beside it tells of"):
        write_whole_page(root, {"toy": broken}, tmp_path / "page")

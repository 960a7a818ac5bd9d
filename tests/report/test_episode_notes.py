"""What records tell a reader of a table: each note once, settings of one method, views that never differ."""

import pytest

from avs.iqa.resizing import ResizeSettings
from avs.report.tables.changed_settings import changed_settings
from avs.selection import registry
from avs.selection.contract import Method, Settings
from avs.selection.registry import Registered
from avs.system.reasons import Reason
from tests.report.view_synthesis_tables import METHODS, TableWriter


@pytest.fixture
def table(tmp_path, written):
    return TableWriter(tmp_path, written)


def test_notes_of_episodes_are_repeated_once(episode, table):
    note = "attic: budget 5 instead of 6, because its pool has 10 views"
    rows, markdown, latex = table([episode(method, budget=5, notes=[note]) for method in METHODS])
    assert markdown.count(note) == 1
    assert latex.count(note) == 1
    assert rows["random", "psnr"]["note"].endswith(note)


def test_settings_of_one_method_are_told(episode, table):
    own = episode("random").protocol | {"views_per_step": 4}
    apart = episode("piqe", protocol=own, own=["views_per_step"])
    _, markdown, _ = table([episode("random"), episode("farthest"), apart], METHODS[:3])
    said = "has settings of the loop for itself, which are part of its row: views_per_step 4 instead of 1\n"
    assert f"- PIQE {said}" in markdown


def test_settings_of_a_method_that_are_not_its_defaults_are_told(episode, table):
    own = {"resize": {"side": "long", "pixels": 96}}
    episodes = [episode(name, selector=own) for name in ("piqe", "ours-repvit")] + [episode("fisherrf", selector={})]
    _, markdown, _ = table(episodes, ["piqe", "ours-repvit", "fisherrf"])
    assert "- PIQE, Ours-RepViT, not as by default: resize.pixels 96 instead of 518\n" in markdown
    assert "FisherRF, not" not in markdown


def test_a_section_that_is_left_out_by_default_or_here_is_told(monkeypatch):
    class Resized(Settings):
        resize: ResizeSettings | None = None
        fit: ResizeSettings | None = ResizeSettings(pixels=20)

    own = Method("Own", "2D-based", "A test.", "lowest", lambda *_: None, settings=Resized)
    monkeypatch.setattr(registry, "methods", lambda: {"own": Registered(own, "own")})
    assert changed_settings("own", {"resize": None, "fit": {"side": "long", "pixels": 20}}) == ""
    told = changed_settings("own", {"resize": {"pixels": 64}, "fit": None})
    assert told == "resize.pixels 64 instead of None, fit None instead of side long, pixels 20"


def test_where_each_method_has_its_own_settings_none_counts_as_the_common_one(episode, table):
    """The records do not tell what the run's are."""
    usual = episode("random").protocol
    own = {"random": usual | {"additions": [1, 2]}, "farthest": usual | {"additions": [3, 4], "views_per_step": 2}}
    names = {"random": ["additions"], "farthest": ["additions", "views_per_step"]}
    episodes = [episode(name, protocol=each, own=names[name], group="Own schedule") for name, each in own.items()]
    _, markdown, _ = table(episodes, [*own])
    said = "has settings of the loop for itself, which are part of its row"
    assert f"- Random {said}: additions 1, 2\n" in markdown
    assert f"- FVS {said}: additions 3, 4, views_per_step 2 instead of 1\n" in markdown


@pytest.mark.parametrize("order", [("random", "piqe", "musiq"), ("piqe", "musiq", "random")])
def test_whose_settings_are_their_own_depends_on_no_majority_and_no_order(episode, table, order):
    own = episode("random").protocol | {"views_per_step": 2}
    episodes = {
        "random": episode("random"),
        **{name: episode(name, protocol=own, own=["views_per_step"]) for name in ("piqe", "musiq")},
    }
    _, markdown, _ = table([episodes[name] for name in order], [*order])
    said = "has settings of the loop for itself, which are part of its row: views_per_step 2 instead of 1\n"
    assert f"- PIQE {said}" in markdown
    assert f"- musiq {said}" in markdown
    assert "Random has settings" not in markdown


def test_enough_seeds_are_not_said_to_be_too_few(episode, table):
    cells = [("random", 0), ("random", 1), ("random", 2), ("farthest", 0)]
    _, markdown, _ = table([episode(method, seed=seed) for method, seed in cells], ["random", "farthest"])
    assert "no spread over seeds is printed of fewer than 3 seeds; some rows have fewer that are complete" in markdown


def test_one_test_image_is_no_images(episode, table):
    _, markdown, _ = table([episode("random", psnr=(20.0,))], ["random"])
    assert "1 test image a scene" in markdown


def test_a_note_of_several_scenes_is_told_once_with_their_names(episode, table):
    notes = {"attic": ["attic: 2 images are undistorted"], "cellar": ["cellar: 2 images are undistorted", "cold"]}
    episodes = [episode("random", scene, notes=notes.get(scene, [])) for scene in ("attic", "cellar", "hall")]
    _, markdown, _ = table(episodes, ["random"])
    assert "- attic, cellar: 2 images are undistorted\n- cold\n" in markdown
    _, markdown, _ = table(episodes[:2], ["random"])
    assert "- every scene: 2 images are undistorted\n" in markdown


def test_folders_that_are_no_scenes_are_counted_and_told_by_reason(episode, table):
    reason = Reason(cause="cannot be read (permission denied)", remedy="give yourself the permission")
    _, markdown, _ = table(
        [episode("random")], ["random"], left_out={"lost+found": reason, "b": reason, "c": Reason(cause="x")}
    )
    assert "Left out: 3 folders of it that cannot be a scene. Representation: gaussians, " in markdown
    assert f"- left out, lost+found, b: {reason}\n- left out, c: x\n" in markdown
    assert "eft out" not in table([episode("random")], ["random"])[1]


def test_views_that_do_not_depend_on_the_seed_are_told(episode, table):
    """By the views, not by the name of the method."""
    said = "the same views with every seed; what differs between seeds is the noise of the optimisation alone"
    own = [episode("random", scene, seed, selected=[f"{seed}", scene]) for scene in ("a", "b") for seed in (0, 1)]
    fixed = [episode("piqe", scene, seed, selected=["x", scene]) for scene in ("a", "b") for seed in (0, 1)]
    _, markdown, _ = table(own + fixed)
    assert f"- PIQE: {said}\n" in markdown
    assert markdown.count(said) == 1
    _, markdown, _ = table([each for each in own + fixed if each.seed == 0])
    assert said not in markdown


def test_methods_that_choose_the_same_views_are_told(episode, table):
    chosen = [("random", ["u", "v"]), ("piqe", ["x", "y"]), ("fisherrf", ["x", "y"])]
    _, markdown, _ = table([episode(method, selected=views) for method, views in chosen])
    assert "- PIQE, FisherRF: the same views in every episode; what differs between these rows" in markdown
    _, markdown, _ = table([episode(method, selected=[method, "y"]) for method, _ in chosen])
    assert "the same views" not in markdown


def test_methods_that_call_themselves_the_same_are_told_apart(episode, table):
    programs = [episode(name, label="Mine") for name in ("first", "second")]
    _, markdown, _ = table([*programs, episode("random", label="Theirs")], ["first", "second", "random"])
    assert "| Mine (first) |" in markdown
    assert "| Mine (second) |" in markdown
    assert "| Theirs |" in markdown


def test_a_program_that_calls_itself_like_a_method_that_is_not_there_is_told_apart(episode, table):
    absent = {"topiq": Reason(cause="weights topiq absent", remedy="fetch them")}
    _, markdown, _ = table(
        [episode("mine", label="TOPIQ"), episode("random")], ["topiq", "mine", "random"], absent=absent
    )
    assert "| TOPIQ (mine) |" in markdown
    assert "| TOPIQ | weights topiq absent |" in markdown

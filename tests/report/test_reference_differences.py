"""Differences to the reference method: every interval that exists, and the words for what it covers."""

import csv

import pytest

from tests.report.view_synthesis_tables import TableWriter, two_scenes


@pytest.fixture
def table(tmp_path, written):
    return TableWriter(tmp_path, written)


def differences(tmp_path):
    with open(tmp_path / "tables" / "nvs_orbit_differences.csv", newline="") as stream:
        return [list(row.values()) for row in csv.DictReader(stream) if row["metric"] == "psnr"]


def test_every_interval_that_exists_is_listed_with_what_it_is_over(episode, table, tmp_path):
    two_seeds = two_scenes(episode, "random", [0.0, 1.0]) + two_scenes(episode, "farthest", [1.0, 3.0])
    table(two_seeds, ["random", "farthest"], reference="random")
    # Differences 1 and 2 in both scenes.
    assert differences(tmp_path) == [
        ["farthest", "psnr", "random", "1.5000", "2", "2", "scenes", "1.5000", "1.5000", "1.00"],
        ["farthest", "psnr", "random", "1.5000", "2", "2", "seeds", "-0.0212", "3.0212", "2.00"],
    ]
    table([each for each in two_seeds if each.seed == 0], ["random", "farthest"], reference="random")
    assert [row[6] for row in differences(tmp_path)] == ["scenes"]
    table([each for each in two_seeds if each.scene == "attic"], ["random", "farthest"], reference="random")
    assert [row[6] for row in differences(tmp_path)] == ["seeds"]
    table([episode("random"), episode("farthest")], ["random", "farthest"], reference="random")
    assert differences(tmp_path) == [["farthest", "psnr", "random", "0.0000", "1", "1", "", "", "", ""]]


@pytest.mark.parametrize(
    ("scenes", "seeds", "said"),
    [
        (3, 1, "95% interval over scenes (other scenes of this kind with any seeds):"),
        (3, 3, "95% interval over scenes (other scenes of this kind with any seeds):"),
        (2, 3, "95% interval over seeds (other seeds on these 2 scenes; not other scenes):"),
        (1, 2, "95% interval over seeds (other seeds on this scene; not other scenes):"),
        (2, 1, "95% interval over scenes (other scenes of this kind with any seeds, very wide with two of them):"),
        (1, 1, "one scene with one seed has no interval:"),
    ],
)
def test_the_heading_says_what_intervals_cover(episode, table, scenes, seeds, said):
    episodes = [
        episode(method, f"scene_{scene}", seed, psnr=(20.0 + scene * seed * rise,))
        for method, rise in (("random", 0.0), ("farthest", 0.1))
        for scene in range(scenes)
        for seed in range(seeds)
    ]
    _, markdown, latex = table(episodes, ["random", "farthest"], reference="random")
    title = "Difference to Random, paired, before rounding; "
    assert f"{title}{said}" in markdown
    assert title in latex
    assert ("- each interval is by itself: of 20 methods equal to" in markdown) == ("no interval" not in said)


def test_the_reference_is_the_method_that_is_named_or_none(episode, table, tmp_path):
    episodes = [episode("random"), episode("ours-repvit", psnr=(22.0, 24.0))]
    _, markdown, _ = table(episodes, reference="random")
    assert "Difference to Random" in markdown
    assert "| Ours-RepViT | +2.00 |" in markdown
    _, markdown, _ = table(episodes, reference=None)
    assert differences(tmp_path) == []
    assert "Difference to" not in markdown
    assert "Difference to" not in table(episodes, reference="farthest")[1]


def test_a_reference_without_a_complete_seed_is_told(episode, table):
    complete = two_scenes(episode, "random", [0.0])
    said = "- no difference to Ours-RepViT is printed, because it has no seed with an episode of every scene\n"
    for own in ([], [episode("ours-repvit")]):
        _, markdown, _ = table([*complete, *own], ["random", "ours-repvit"])
        assert said in markdown
        assert "Difference to" not in markdown
    _, markdown, _ = table(complete, ["random"])
    assert said not in markdown

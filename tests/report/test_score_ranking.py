"""The ranking table: values by hand, orientation of scores and truth, what is missing and why."""

import csv
import random

import pytest

from avs.nvs.record import Step, StepTruth
from avs.report.tables.score_ranking import FIELDS, write_ranking_table
from avs.report.tables.score_ranking_numbers import oriented
from avs.selection.contract import ORACLE
from avs.system.errors import UserError
from avs.system.reasons import Reason

METHODS = ["random", "fisherrf", "ours-repvit"]


def step(scores, ssim=None, psnr=None, gain=None, number=0):
    measured = ssim is not None or psnr is not None or gain is not None
    truth = StepTruth(psnr=psnr or ssim, ssim=ssim, gain=gain) if measured else None
    names = [f"{index}.png" for index in range(len(ssim or gain or scores))]
    return Step(
        step=number,
        iteration=5,
        primitives=9,
        candidates=names,
        scores=scores,
        chosen=names[:1],
        captured=[5],
        truth=truth,
    )


@pytest.fixture
def table(tmp_path, written):
    """Write the table of some episodes; return its rows by (method, target, statistic), its Markdown and LaTeX."""

    def write(episodes, methods=METHODS, absent=None):
        out = tmp_path / "tables" / "ranking_orbit"
        write_ranking_table(written(episodes), methods, "orbit", out, absent or {})
        with open(f"{out}.csv", newline="") as stream:
            reader = csv.DictReader(stream)
            rows = {(row["method"], row["target"], row["statistic"]): row for row in reader}
        assert tuple(reader.fieldnames) == FIELDS
        return rows, *(out.with_name(out.name + ending).read_text() for ending in (".md", ".tex"))

    return write


# Against 1, 2, 3, 4: one exchange of neighbours has rho 1 - 6 * 2 / (4 * 15) = 0.8 and tau 4/6; two have 0.6 and 2/6.
ORDERED, ONE, TWO = [1.0, 2.0, 3.0, 4.0], [2.0, 1.0, 3.0, 4.0], [2.0, 1.0, 4.0, 3.0]


def test_values_by_hand(episode, table):
    episodes = [
        episode("fisherrf", scene, seed, chooses="lowest", steps=[step(first, ORDERED), step(second, ORDERED)])
        for scene, seed, first, second in [
            ("attic", 0, ORDERED, ONE),  # mean rho 0.9
            ("cellar", 0, ONE, TWO),  # 0.7
            ("attic", 1, ONE, ONE),  # 0.8
            ("cellar", 1, ORDERED, ORDERED),  # 1.0
            ("attic", 2, ORDERED, ONE),  # 0.9
            ("cellar", 2, ONE, ONE),  # 0.8
        ]
    ]
    rows, markdown, latex = table(episodes)
    row = rows["fisherrf", "ssim", "spearman"]
    # Seeds have 0.8, 0.9 and 0.85.
    assert (row["mean"], row["spread"], row["over"]) == ("0.8500", "0.0500", "seeds")
    assert (row["scenes"], row["seeds"], row["steps"], row["group"]) == ("2", "3", "12", "3D-based")
    assert rows["fisherrf", "ssim", "kendall"]["mean"] == "0.7500"  # 5/6, 1/2; 2/3, 1; 5/6, 2/3
    assert "| 3D-based | FisherRF | **0.85 ± 0.05** | **0.75 ± 0.08** |" in markdown
    assert "standard deviation over seeds" in markdown
    assert r"\label{tab:ranking-orbit}" in latex
    assert r"& FisherRF & \cellcolor[HTML]{F4CCCC}0.85 $\pm$ 0.05 &" in latex


def test_with_few_seeds_the_spread_is_over_scenes_and_of_two_there_is_none(episode, table):
    episodes = [
        episode("random", scene, chooses="lowest", steps=[step(scores, ORDERED)])
        for scene, scores in (("attic", ORDERED), ("cellar", TWO), ("hall", ONE))
    ]
    rows, markdown, _ = table(episodes)
    row = rows["random", "ssim", "spearman"]
    assert (row["mean"], row["spread"], row["over"]) == ("0.8000", "0.2000", "scenes")
    assert "standard deviation over scenes" in markdown
    rows, markdown, _ = table(episodes[:2])
    row = rows["random", "ssim", "spearman"]
    assert (row["mean"], row["spread"], row["over"]) == ("0.8000", "", "")
    assert "±" not in markdown


@pytest.mark.parametrize(
    ("chooses", "target", "value"),
    [
        ("lowest", "ssim", 1.0),
        ("highest", "ssim", -1.0),
        ("lowest", "psnr", 1.0),
        ("lowest", "gain", -1.0),
        ("highest", "gain", 1.0),
    ],
)
def test_one_is_the_order_of_the_truth(episode, table, chooses, target, value):
    """The lowest score of a quality method should meet the lowest SSIM; the largest information the largest gain."""
    steps = [step(ORDERED, ssim=[0.1, 0.2, 0.3, 0.9], psnr=[9.0, 10.0, 11.0, 20.0], gain=[-1.0, 0.0, 0.5, 2.0])]
    rows, markdown, latex = table([episode("random", chooses=chooses, steps=steps)])
    assert float(rows["random", target, "spearman"]["mean"]) == value
    assert float(rows["random", target, "kendall"]["mean"]) == value
    # What ranks by quality ranks against the gain here, so that both signs occur.
    assert "−1.00" in markdown  # noqa: RUF001
    assert "$-$1.00" in latex


def test_only_candidates_with_score_and_truth_count():
    scores, gain = [4.0, None, 2.0, 3.0, 9.0], [0.1, 0.2, None, 0.4, 0.5]
    first, second = oriented(step(scores, gain=gain), "highest", "gain")
    assert first.tolist() == [4.0, 3.0, 9.0]
    assert second.tolist() == [0.1, 0.4, 0.5]
    assert oriented(step(None, ORDERED), True, "ssim") is None
    assert oriented(step(ORDERED), True, "ssim") is None
    assert oriented(step(ORDERED, ORDERED), "highest", "gain") is None


def test_selections_without_order_are_left_out_and_counted(episode, table):
    steps = [step([1.0, 1.0, 1.0, 1.0], ORDERED), step(ONE, ORDERED), step([1.0, 2.0], [1.0, 2.0])]
    rows, markdown, _ = table([episode("random", chooses="lowest", steps=steps)], ["random"])
    row = rows["random", "ssim", "spearman"]
    assert (row["mean"], row["steps"]) == ("0.8000", "1")
    assert (
        row["note"]
        == "1 selection left out, all values are equal; 1 selection left out, fewer than 3 candidates have both"
    )
    assert (
        "- Random (SSIM, Spearman; SSIM, Kendall; PSNR, Spearman; PSNR, Kendall): 1 selection left out, all" in markdown
    )


@pytest.mark.parametrize(
    ("steps", "note"),
    [
        ([step(None, ORDERED)], "the method records no scores"),
        ([step(ORDERED)], "not measured (protocol.truth.image_every)"),
        ([step([5.0, 5.0, 5.0], [1.0, 2.0, 3.0])], "attic: all values are equal"),
    ],
)
def test_a_correlation_that_is_missing_says_why(episode, table, steps, note):
    rows, markdown, latex = table([episode("random", steps=steps)], ["random"])
    row = rows["random", "ssim", "spearman"]
    assert (row["mean"], row["spread"], row["steps"], row["note"]) == ("", "", "0", note)
    assert note in markdown
    assert note.replace("_", r"\_") in latex


def test_methods_without_episodes_keep_their_row(episode, table):
    complete = [episode("random", scene, steps=[step(ONE, ORDERED)]) for scene in ("attic", "cellar")]
    partly = [episode("fisherrf", "attic", steps=[step(ONE, ORDERED)])]
    reason = Reason(cause="weights absent", remedy="fetch them")
    rows, markdown, _ = table(complete + partly, absent={"ours-repvit": reason})
    assert rows["fisherrf", "ssim", "spearman"]["note"] == "no episode of cellar"
    assert rows["ours-repvit", "gain", "kendall"]["note"] == "weights absent: fetch them"
    assert "- Ours-RepViT: weights absent: fetch them\n" in markdown


def test_oracles_stand_last_and_are_not_ranked(episode, table):
    oracle = episode("oracle-ssim", group=ORACLE, chooses="lowest", steps=[step(ORDERED, ORDERED)])
    other = episode("random", chooses="lowest", steps=[step(TWO, ORDERED)])
    _, markdown, _ = table([oracle, other], ["oracle-ssim", "random"])
    assert "| Oracle | oracle-ssim | 1.00 | 1.00 |" in markdown
    assert "**0.60**" in markdown
    assert markdown.index("Random") < markdown.index("oracle-ssim")


def test_the_way_the_gain_was_measured_is_told(episode, table):
    truth = {"image_every": 1, "gain_every": 5, "gain_candidates": 8, "gain_passes": 2}
    one = episode("random")
    _, markdown, _ = table([one.model_copy(update={"protocol": one.protocol | {"truth": truth}})], ["random"])
    assert "- gain: 8 random candidates at one in 5 selections" in markdown
    assert "used 2 times\n" in markdown


def test_equal_records_give_equal_bytes_in_any_order(episode, written, tmp_path):
    episodes = [
        episode(method, scene, seed, steps=[step(TWO, ONE, gain=ORDERED)])
        for method in METHODS
        for scene in ("attic", "cellar")
        for seed in (0, 1)
    ]
    contents = []
    for name in ("first", "second"):
        random.Random(name).shuffle(episodes)
        write_ranking_table(written(episodes), METHODS, "orbit", tmp_path / name / "ranking_orbit", {})
        contents.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert set(contents[0]) == {"ranking_orbit.csv", "ranking_orbit.md", "ranking_orbit.tex"}


def test_episodes_of_another_data_set_are_refused(episode, table):
    with pytest.raises(UserError, match="got episodes of handheld"):
        table([episode("random"), episode("random", dataset="handheld", scene="hut")])

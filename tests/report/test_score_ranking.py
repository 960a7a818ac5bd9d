"""The ranking table: values by hand, orientation of scores and truth, what is missing and why."""

import csv
import random

import pytest

from avs.report.tables.gain_reliability import FIELDS as GAIN_FIELDS
from avs.report.tables.score_ranking import FIELDS, STATE_FIELDS, write_ranking_table
from avs.report.tables.score_ranking_numbers import oriented
from avs.selection import registry
from avs.system.computed_by import ComputedBy
from avs.system.errors import UserError
from avs.system.reasons import Reason
from avs.system.records import write_record
from tests.report.state_records import DEFAULT, ONE, ORDERED, TWO, make_states, scored, state

METHODS = ["random", "fisherrf", "ours-repvit"]


@pytest.fixture
def written(tmp_path):
    def write(records):
        paths = []
        for number, record in enumerate(records):
            paths.append(tmp_path / "records" / f"{number}.json")
            write_record(paths[-1], record)
        return paths

    return write


@pytest.fixture
def table(tmp_path, written):
    """Write the table of some records; return its rows by (method, target, statistic), its Markdown and LaTeX."""

    def write(records, methods=METHODS, absent=None):
        out = tmp_path / "tables" / "ranking_orbit"
        write_ranking_table(written(records), methods, "orbit", out, absent or {})
        with open(f"{out}.csv", newline="") as stream:
            reader = csv.DictReader(stream)
            rows = {(row["method"], row["target"], row["statistic"]): row for row in reader}
        assert tuple(reader.fieldnames) == FIELDS
        return rows, *(out.with_name(out.name + ending).read_text() for ending in (".md", ".tex"))

    return write


def listing(tmp_path, ending):
    with open(tmp_path / "tables" / f"ranking_orbit{ending}.csv", newline="") as stream:
        reader = csv.DictReader(stream)
        return list(reader), tuple(reader.fieldnames)


def test_values_by_hand(table, tmp_path):
    records = [
        make_states([state(), state(views=12)], [scored("fisherrf", first, second)], scene, seed)
        for scene, seed, first, second in [
            ("attic", 0, ORDERED, ONE),
            ("cellar", 0, ONE, TWO),
            ("attic", 1, ONE, ONE),
            ("cellar", 1, ORDERED, ORDERED),
        ]
    ]
    rows, markdown, latex = table(records)
    row = rows["fisherrf", "ssim", "spearman"]
    # 1, 0.8, 0.8, 0.6, 0.8, 0.8, 1, 1: their mean is 0.85, their squared distances from it sum up to 0.14.
    assert (row["mean"], row["spread"]) == ("0.8500", "0.1414")
    assert (row["states"], row["scenes"], row["seeds"], row["group"]) == ("8", "2", "2", "3D-based")
    assert rows["fisherrf", "ssim", "kendall"]["mean"] == "0.7500"
    assert "| 3D-based | FisherRF | **0.85 ± 0.14** | **0.75 ± 0.24** |" in markdown
    assert "at 8 common states: 2 scenes (attic, cellar), 2 seeds (0, 1), 6, 12 captured views after 5 " in markdown
    assert "after 5 iterations, 4 candidates a state; representation: gaussians, 9 primitives. " in markdown
    assert "standard deviation over the 8 states" in markdown
    assert r"\label{tab:ranking-orbit}" in latex
    states, fields = listing(tmp_path, "_per_state")
    assert fields == STATE_FIELDS
    own = [
        each
        for each in states
        if (each["method"], each["target"], each["statistic"]) == ("fisherrf", "ssim", "spearman")
    ]
    assert [(each["scene"], each["seed"], each["views"], each["candidates"], each["value"]) for each in own[:2]] == [
        ("attic", "0", "6", "4", "1.0000"),
        ("attic", "0", "12", "4", "0.8000"),
    ]
    assert len(own) == 8


def test_the_interval_is_over_scenes(table):
    values = {"attic": ORDERED, "cellar": ONE, "hall": TWO}
    rows, _, _ = table([make_states([state()], [scored("random", scores)], scene) for scene, scores in values.items()])
    row = rows["random", "ssim", "spearman"]
    # 1, 0.8, 0.6: deviation 0.2; Student's t of two degrees of freedom is 4.3027, times 0.2 over the root of three.
    assert (row["mean"], row["low"], row["high"]) == ("0.8000", "0.3032", "1.2968")
    rows, _, _ = table([make_states([state(), state(views=12)], [scored("random", ONE, TWO)])])
    assert (rows["random", "ssim", "spearman"]["low"], rows["random", "ssim", "spearman"]["high"]) == ("", "")


def test_two_states_have_no_spread(table):
    rows, markdown, _ = table([make_states([state(), state(views=12)], [scored("random", ONE, ONE)])])
    assert (rows["random", "ssim", "spearman"]["mean"], rows["random", "ssim", "spearman"]["spread"]) == ("0.8000", "")
    assert "plus-minus" not in markdown
    assert "0.80 ±" not in markdown


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
def test_one_is_the_order_of_the_truth(table, chooses, target, value):
    """The lowest score of a quality method should meet the lowest SSIM; the largest information the largest gain."""
    gain = [-1.0, 0.0, 0.5, 2.0]
    truth = state([0.1, 0.2, 0.3, 0.9], [9.0, 10.0, 11.0, 20.0], [gain, gain])
    rows, markdown, latex = table([make_states([truth], [scored("random", ORDERED, chooses=chooses)])])
    assert float(rows["random", target, "spearman"]["mean"]) == value
    assert float(rows["random", target, "kendall"]["mean"]) == value
    # What ranks by quality ranks against the gain here, so that both signs occur.
    assert "−1.00" in markdown  # noqa: RUF001
    assert "$-$1.00" in latex


def test_only_candidates_with_score_and_truth_count():
    first, second = oriented([4.0, None, 2.0, 3.0, 9.0], "highest", [0.1, 0.2, None, 0.4, 0.5], "gain")
    assert first.tolist() == [4.0, 3.0, 9.0]
    assert second.tolist() == [0.1, 0.4, 0.5]


def test_the_gain_is_the_mean_of_two_measurements_and_their_agreement_is_printed(table, tmp_path):
    # Means 1.5, 1.5, 3.5, 3.5 and a candidate that is in no sample.
    gains = ([1.0, 2.0, 3.0, 4.0, None], [2.0, 1.0, 4.0, 3.0, None])
    five = [1.0, 2.0, 3.0, 4.0, 5.0]
    records = [
        make_states([state(five, five, gains)], [scored("random", [1.0, 1.0, 2.0, 2.0, 9.0], chooses="highest")])
    ]
    rows, markdown, _ = table(records, ["random"])
    assert rows["random", "gain", "spearman"]["mean"] == "1.0000"
    # Two exchanges of neighbours: 0.6. The mean of two: 2 * 0.6 / 1.6 = 0.75, whose root is 0.866.
    assert "Spearman correlation is 0.60 (mean of 1 state)" in markdown
    assert "reliability of 0.75 (Spearman-Brown)" in markdown
    assert "by more than the root, 0.87." in markdown
    assert "| Measurement | gain, measured again | – | – | – | – | 0.60 | 0.33 |" in markdown  # noqa: RUF001
    assert "|  | bound for any score | – | – | – | – | 0.87 | – |" in markdown  # noqa: RUF001
    (row,), fields = listing(tmp_path, "_gain")
    assert fields == GAIN_FIELDS
    # The means deviate by 1 from 2.5, four of them: sqrt(4/3). The differences are 1 or -1: sqrt(4/3) / sqrt(2).
    assert (row["candidates"], row["spearman"], row["spread_db"], row["noise_db"]) == (
        "4",
        "0.6000",
        "1.1547",
        "0.8165",
    )


def test_measurements_that_disagree_bound_everything_to_nothing(table):
    _, markdown, _ = table([make_states([state(gains=(ORDERED, ORDERED[::-1]))], [scored("random", ONE)])], ["random"])
    assert "Spearman correlation is -1.00" in markdown
    assert "by more than the root, 0.00." in markdown


def test_states_without_order_are_left_out_and_counted(table):
    states = [state(), state(views=12), state([1.0, 2.0], [1.0, 2.0], ([1.0, 2.0], [1.0, 2.0]), views=18)]
    scores = ([1.0, 1.0, 1.0, 1.0], ONE, [1.0, 2.0])
    rows, markdown, _ = table([make_states(states, [scored("random", *scores)])], ["random"])
    row = rows["random", "ssim", "spearman"]
    assert (row["mean"], row["states"]) == ("0.8000", "1")
    assert row["note"] == "1 state left out, all values are equal; 1 state left out, fewer than 3 candidates have both"
    assert "- Random: 1 state left out, all values are equal; no rank\n" in markdown


def test_a_mean_of_fewer_states_is_not_ranked(table):
    ties = [1.0, 1.0, 1.0, 1.0]
    told = make_states([state(), state(views=12)], [scored("random", ONE, ties), scored("farthest", ONE, ONE)])
    _, markdown, _ = table([told], ["random", "farthest"])
    rows = {name: line for line in markdown.splitlines() for name in ("Random", "FVS") if f"| {name} |" in line}
    assert "**" in rows["FVS"]
    assert "**" not in rows["Random"]
    assert "(2)" not in rows["Random"]


def test_a_scene_without_any_order_says_why(table):
    equal = [5.0, 5.0, 5.0, 5.0]
    attic = make_states([state()], [scored("random", equal)])
    rows, _, _ = table([attic, make_states([state()], [scored("random", ONE)], "cellar")], ["random"])
    assert rows["random", "psnr", "spearman"]["note"] == "attic with seed 0: all values are equal"
    rows, _, _ = table([attic, make_states([state()], [scored("random", equal)], "cellar")], ["random"])
    assert rows["random", "psnr", "spearman"]["note"] == "all values are equal"


def test_a_failure_is_the_reason_of_its_row_alone(table):
    failed = scored("fisherrf", None, failure="RuntimeError: no luck")
    both = [scored("random", ONE), failed]
    rows, markdown, _ = table([make_states([state()], both)], ["random", "fisherrf"])
    assert rows["random", "ssim", "spearman"]["mean"] == "0.8000"
    assert rows["fisherrf", "ssim", "spearman"]["note"] == "it failed: RuntimeError: no luck"
    assert "- FisherRF: it failed: RuntimeError: no luck\n" in markdown
    records = [make_states([state()], both), make_states([state()], [both[0], scored("fisherrf", ONE)], "cellar")]
    rows, _, _ = table(records, ["random", "fisherrf"])
    # No mean over the scenes that happen to be there.
    assert rows["fisherrf", "ssim", "spearman"]["mean"] == ""
    assert rows["fisherrf", "ssim", "spearman"]["note"] == "it failed: attic with seed 0: RuntimeError: no luck"


def test_rows_without_scores_say_why(table):
    reason = Reason(cause="weights absent", remedy="fetch them")
    rows, markdown, _ = table([make_states([state()], [scored("random", None)])], absent={"ours-repvit": reason})
    assert rows["random", "ssim", "spearman"]["note"] == "the method records no scores"
    assert rows["fisherrf", "ssim", "spearman"]["note"] == "not scored"
    assert rows["ours-repvit", "gain", "kendall"]["note"] == "weights absent: fetch them"
    assert "- Ours-RepViT: weights absent: fetch them\n" in markdown


def test_a_gain_that_is_not_measured_says_why(table):
    rows, markdown, _ = table([make_states([state(gains=None)], [scored("random", ONE)])], ["random"])
    assert rows["random", "gain", "spearman"]["note"] == "not measured: the reconstruction cannot be copied"
    assert rows["random", "ssim", "spearman"]["mean"] == "0.8000"
    assert "measured again" not in markdown


def test_an_oracle_has_a_truth_as_its_score_and_no_correlation_with_it(table):
    truth = state(ORDERED, ONE, (TWO, TWO))
    rows, markdown, _ = table([make_states([truth], [scored("random", TWO)])], ["random", "oracle-ssim", "oracle-gain"])
    assert rows["oracle-ssim", "ssim", "spearman"]["note"] == "is this truth itself"
    assert rows["oracle-ssim", "psnr", "spearman"]["mean"] == "0.8000"
    # The lowest SSIM comes first, and the highest gain: against one another they are turned.
    assert (
        rows["oracle-ssim", "gain", "spearman"]["mean"] == rows["oracle-gain", "ssim", "spearman"]["mean"] == "-0.6000"
    )
    assert rows["oracle-gain", "gain", "kendall"]["note"] == "is this truth itself"
    assert "- Oracle (gain): the gain that these states measure, in test PSNR; its episodes choose by" in markdown
    assert markdown.index("Random") < markdown.index("Oracle (SSIM)")
    assert "**0.80" not in markdown.split("Oracle (SSIM)")[1]


def test_a_twin_and_what_methods_say_of_themselves_are_noted(table):
    own = scored("random", ONE, own_fit=True, notes=["Random: it is said"])
    _, markdown, _ = table([make_states([state()], [own], notes=["attic: budget 7"])], ["random"])
    assert "- Random: scores a twin of the reconstruction, fitted its way on the same views; the truth" in markdown
    assert "- Random: it is said\n" in markdown
    assert "- attic: budget 7\n" in markdown
    assert "- gain: of 4 random candidates; a copy fitted with the candidate against" in markdown
    assert "until each view was used 8 times; twice, with independent orders of the views\n" in markdown


def test_settings_that_are_not_the_defaults_are_told(table):
    usual = registry.create_settings("fisherrf", {}).model_dump(mode="json")
    own = scored("fisherrf", ONE, selector=usual | {"regularisation": 1e9})
    _, markdown, _ = table([make_states([state()], [own, scored("random", ONE)])], ["random", "fisherrf"])
    assert f"- FisherRF, not as by default: regularisation {1e9} instead of {usual['regularisation']}\n" in markdown
    assert markdown.count("not as by default") == 1


def test_equal_records_give_equal_bytes_in_any_order(written, tmp_path):
    records = [
        make_states([state(ssim=TWO)], [scored(method, ONE) for method in METHODS], scene, seed)
        for scene in ("attic", "cellar")
        for seed in (0, 1)
    ]
    contents = []
    for name in ("first", "second"):
        random.Random(name).shuffle(records)
        write_ranking_table(written(records), METHODS, "orbit", tmp_path / name / "ranking_orbit", {})
        contents.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    assert len(contents[0]) == 6


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"dataset": "handheld"}, "is of the data set handheld; pass records of orbit only"),
        ({}, "repeats .*; pass one record for each scene and seed"),
        ({"scene": "cellar", "protocol": {}}, "not comparable with other records of orbit, protocol differ"),
        ({"scene": "cellar", "settings": DEFAULT | {"views": [5]}}, "common_states differ"),
        ({"scene": "cellar", "methods": [scored("random", ONE, weights_hash="1")]}, "the weights of methods differ"),
        ({"seed": 1, "scene_hash": "another"}, "the versions of the scene differ"),
    ],
)
def test_records_that_do_not_belong_together_are_refused(table, changes, fault):
    methods = [scored("random", ONE)]
    with pytest.raises(UserError, match=fault):
        table([make_states([state()], methods), make_states([state()], **({"methods": methods} | changes))])


def test_what_records_were_computed_with_is_told_where_it_differs(tmp_path, table):
    records = [make_states([state()], [scored("random", ONE)], scene) for scene in ("attic", "cellar")]
    for number, device, version in ((0, "cpu", "0.1.15"), (1, "cuda", "0.1.16")):
        machine = {"processor": "Intel", "numerics": "native"}
        told = ComputedBy(device=device, machine=machine, packages={"pyiqa": version}, revision=None)
        write_record(tmp_path / "records" / f"{number}.meta.json", told)
    _, markdown, _ = table(records, ["random"])
    assert "- 1 of 2 computed with native numerics" in markdown
    assert "- device differs between records of common states" in markdown
    assert "pyiqa differs between records of common states, and numbers may differ with it: 0.1.15 in 1" in markdown


def test_no_records_are_refused(table):
    with pytest.raises(UserError, match="none given"):
        table([])

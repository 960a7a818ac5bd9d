"""Every table compiles: each kind of table is read strictly, and compiled where a LaTeX is installed."""

import re
from dataclasses import replace

import pytest

from avs.report.collect import read_episodes
from avs.report.document import Cell, Column, Comparison, Difference, Document, Group, Listing, Row
from avs.report.formats.latex import document_latex
from avs.report.tables.data_sets_side_by_side import ShownDataSet, side_by_side
from avs.report.tables.method_significance import method_significance
from avs.report.tables.runtime_summary import runtime_summary
from avs.report.tables.scene_by_scene import scene_by_scene
from avs.report.tables.selection_times import selection_times
from avs.report.tables.view_synthesis import view_synthesis
from avs.selection import registry
from avs.system.reasons import Reason
from metrics.definitions import Metric
from tests import tolerances
from tests.report.latex_subset import PROGRAM, check_latex, compile_latex
from tests.report.timing_records import make_record
from tests.workflow.project import ROOT

PUBLISHED = ROOT / "results" / "published"
METHODS = sorted(registry.methods())
ABSENT = {"musiq": Reason(cause="weights musiq absent", remedy="python -m avs weights fetch musiq_koniq")}
EVERY_CHARACTER = "".join(map(chr, [*range(0x20, 0x7F), *range(0xA1, 0x180), 0x2013, 0x2212, 0x3B1, 0x4E2D, 0x1F4F7]))
HOSTILE = rf"50% of {{these}} & #those: a_b ~ c^d, $1 < 2 > 0, \end{{table*}} [t] {EVERY_CHARACTER}"


def hostile():
    """A table with every character in every place that text comes to."""
    columns = (Column(Metric("m", HOSTILE, True, 2, HOSTILE, ""), published=HOSTILE, difference=True, over=HOSTILE),)
    row = Row(HOSTILE, (Cell(1.0, 0.1, 1, "0.9"),))
    rows = (row, replace(row, cells=(Cell(cause=HOSTILE),), proposed=True), Row("[a]", (Cell(text="-3 (1 to 5)"),)))
    return Document(
        label="hostile_one",
        caption=(HOSTILE,),
        columns=columns,
        groups=(Group(HOSTILE, rows), Group("", rows[:1], columns[0].metric)),
        notes=(HOSTILE, "[b]"),
        listing=Listing((), ()),
        comparison=Comparison(HOSTILE, ((HOSTILE, (Difference(-1.0, (-2.0, 0.0)),)),)),
        rows_are=HOSTILE,
    )


@pytest.fixture
def texts(episode, written):
    """Every kind of table that this folder prints, with all methods, on three scenes with two seeds."""
    ran = [method for method in METHODS if method not in ABSENT]
    groups = {method: registry.find(method).method for method in ran}
    episodes = [
        episode(method, scene, seed, psnr=(20.0 + number + seed,), lpips=None, dataset=dataset, group=told.group)
        for dataset in ("orbit", "handheld")
        for number, (method, told) in enumerate(groups.items())
        for scene in ("attic", "garden", "hall_of_the_mountain_king")
        for seed in (0, 1)
    ]
    handheld, orbit = read_episodes(written(episodes), METHODS)
    means, scenes = PUBLISHED / "nvs_mipnerf360.csv", PUBLISHED / "nvs_mipnerf360_per_scene.csv"
    times = {"fisherrf": make_record(), "random": make_record("random")}
    garden = [PUBLISHED / "runtime_garden.csv"]
    sets = [ShownDataSet(each, METHODS, ABSENT, means) for each in (orbit, handheld)]
    documents = [
        view_synthesis(orbit, METHODS, means, ABSENT, "farthest"),
        scene_by_scene(orbit, METHODS, [scenes, means], ABSENT),
        side_by_side(sets, "re10k_mfr"),
        method_significance(orbit, METHODS, ABSENT),
        selection_times(times, orbit, METHODS, ABSENT, garden),
        runtime_summary("detail", times, orbit, METHODS, ABSENT, garden[0]),
    ]
    return [document_latex(document) for document in documents]


def test_every_table_is_read_strictly(texts):
    for text in [*texts, document_latex(hostile())]:
        check_latex(text)


@pytest.mark.skipif(PROGRAM is None, reason="no LaTeX is installed")
def test_every_table_compiles_and_fits_on_its_page(texts, tmp_path):
    said = compile_latex(tmp_path, texts)
    assert "undefined" not in said
    assert "too large for page" not in said
    assert "Missing character" not in said
    points = [float(each) for each in re.findall(r"Overfull \\hbox \(([\d.]+)pt", said)]
    assert max(points, default=0.0) < tolerances.LATEX_OVERFULL


@pytest.mark.skipif(PROGRAM is None, reason="no LaTeX is installed")
def test_every_character_compiles(tmp_path):
    assert "Missing character" not in compile_latex(tmp_path, [document_latex(hostile())])


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (r"\%", "%"),
        (r"\_", "_"),
        (r"\&", "&"),
        (r"\centering", r"\centering}"),
        (r"\midrule", r"\midrul"),
        (r"\end{tabular}", ""),
        (r"\cmidrule(lr){3-5}", r"\cmidrule(lr){3-9}"),
        (r"\multicolumn{3}", r"\multicolumn{4}"),
        (r"\multirow{3}", r"\multirow{5}"),
        (r"$\uparrow$", r"$\uparrow"),
    ],
)
def test_the_strict_reader_sees_damage(before, after):
    text = document_latex(hostile())
    assert before in text
    with pytest.raises(AssertionError):
        check_latex(text.replace(before, after, 1))


def test_characters_that_latex_does_not_know_keep_their_letter_or_number():
    latex = document_latex(replace(hostile(), notes=("Łódź, ångström, ﬁt, ą, 中",)))
    assert "{[}U+0141{]}ódz, ångström, fit, a, {[}U+4E2D{]}." in latex

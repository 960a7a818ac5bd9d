"""Numbers of the page are those of the tables, and its filters rank and count as they do. Skips without Node."""

import json
import shutil
import subprocess
from dataclasses import asdict, replace

import numpy as np
import pytest

from avs.report.document import Cell, Column, Document, Group, Listing, Row
from avs.report.formats.numbers import measured, signed
from avs.report.page.script_files import told_apart
from avs.report.page.site import FOLDER, STATIC
from avs.report.page.table_facts import table_facts, table_place
from metrics.definitions import Metric

NODE = shutil.which("node")
pytestmark = pytest.mark.skipif(NODE is None, reason="no Node: apt-get install nodejs")

PSNR = Metric("psnr", "PSNR", True, 2, "dB", "")
SEEN = Metric("within_a", "a", True, 2, "", "")


def in_page(expression, *values):
    """Return what an expression of the page's numbers and filters gives for each of some values, called ``told``."""
    files = [str(FOLDER / STATIC / f"{name}.js") for name in ("numbers", "table_filters", "episode_parts")]
    program = f"""
        const fs = require("fs"), vm = require("vm");
        global.avs = {{ views: {{}}, index: {{ methods: [] }} }};
        for (const file of {json.dumps(files)}) vm.runInThisContext(fs.readFileSync(file, "utf8"));
        const answers = JSON.parse(fs.readFileSync(0, "utf8")).map((told) => {expression});
        process.stdout.write(JSON.stringify(answers));
    """
    result = subprocess.run(
        [NODE, "-e", program], input=json.dumps(values), capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return json.loads(result.stdout)


def awkward_values():
    """Return numbers that lie halfway, near it, near zero on either side, and anywhere."""
    rng = np.random.default_rng(0)
    halves = [place / 8 for place in range(-400, 400)] + [place + 0.5 for place in range(-9, 10)]
    near = [15.51499, 15.515, 1.005, 2.675, 0.125, -0.001, -0.004, -0.005, 0.0, -0.0, 1e-9, -1e-9, 1e6 + 0.125]
    beside = [float(np.nextafter(value, end)) for value in halves for end in (-np.inf, np.inf)]
    return [*halves, *near, *beside, *rng.normal(scale=30, size=2000).tolist()]


@pytest.mark.parametrize("decimals", [0, 1, 2, 3, 4])
def test_printed_numbers_are_those_of_the_tables(decimals):
    values = awkward_values()
    found = in_page(f"[avs.fixed(told, {decimals}), avs.signed(told, {decimals})]", *values)
    minus = [[text.replace("\N{MINUS SIGN}", "-") for text in pair] for pair in found]
    assert minus == [[measured(Cell(value), decimals, " "), signed(value, decimals)] for value in values]


def test_methods_are_compared_at_the_same_number_of_views_also_between_choices():
    each = {"curve": [{"views": views, "psnr": 10 + views} for views in (4, 5, 6, 7, 8)]}
    own_schedule = {"curve": [{"views": views, "psnr": 10 + views} for views in (4, 8)]}
    assert in_page("avs.pointAt(told, 6)?.psnr ?? null", each, own_schedule) == [16, None]


def test_scores_keep_the_order_that_they_have_in_the_record():
    exact = np.random.default_rng(0).uniform(size=48)
    for offset in (0.0, 1e6, 1e8, -1e12):
        scores = (offset + exact).tolist()
        shown = told_apart([*scores, None])
        assert shown.pop() is None
        assert np.array_equal(np.argsort(shown), np.argsort(scores))
    assert told_apart([0.123456789, 0.2]) == [0.12345679, 0.2]


def document(rows, singles, fields=("method", "metric", "scene", "seed", "value"), columns=(PSNR,)):
    """Return a table: groups by the name of each row's, and the values of single scenes."""
    groups = tuple(Group(name, tuple(row for group, row in rows if group == name)) for name, _ in rows)
    listing = Listing(fields, tuple((*place, "") for *place, _ in singles), tuple(value for *_, value in singles))
    return Document(
        "table", ("caption",), tuple(map(Column, columns)), groups, (), Listing((), ()), None, {"_per_scene": listing}
    )


def filtered(told, **state):
    """Return what the page shows of a table with a filter."""
    return in_page(f"avs.filtered(told, {json.dumps(state)})", table_facts(told))[0]


def test_a_filter_ranks_the_rows_that_the_table_ranks():
    own = Row("Own", (Cell(21.0),), identifier="own")  # of an unranked group that no method of the run has
    fvs = Row("FVS", (Cell(20.0, rank=1),), identifier="farthest", ranked=True)
    told = document(
        [("Upper reference", own), ("Geometric", fvs)],
        [(name, "psnr", "s1", 0, value) for name, value in (("own", 21.0), ("farthest", 20.0))],
    )
    shown = filtered(told, scene="s1")
    assert [group["rows"][0]["cells"][0]["rank"] for group in shown["groups"]] == [None, 1]
    unranked = replace(told, groups=(replace(told.groups[1], rows=(replace(fvs, cells=(Cell(20.0),)),)),))
    assert filtered(unranked, scene="s1")["groups"][0]["rows"][0]["cells"][0]["rank"] is None


def test_a_filter_computes_with_all_digits():
    row = Row("FVS", (Cell(15.51499, rank=1),), identifier="farthest", ranked=True)
    told = document([("Geometric", row)], [("farthest", "psnr", "s1", 0, 15.51499)])
    cell = filtered(told, scene="s1")["groups"][0]["rows"][0]["cells"][0]
    assert cell["value"] == 15.51499
    assert in_page("avs.fixed(told, 2)", cell["value"]) == ["15.51"]


def test_the_table_of_scorers_is_filtered_by_scene():
    row = Row("Lite0", (Cell(0.5, rank=1), Cell(0.5)), identifier="lite0", ranked=True)
    fields = ("predictor", "dataset", "scene", "metric", "value")
    singles = [("lite0", "a", scene, "psnr", value) for scene, value in (("s1", 0.25), ("s2", 0.75))]
    told = document([("Networks", row)], singles, fields, (PSNR, SEEN))
    shown = filtered(told, scene="s1")
    assert shown["groups"][0]["rows"][0]["cells"] == [asdict(Cell(0.25, rank=1))]
    assert shown["caption"] == ["scene s1: means of the single values of this table, computed by the page."]
    one = document([("Networks", row)], [(*each[:2], "s1", 0, 20.0) for each in [("lite0", "psnr")]])
    assert filtered(one, seed="0")["caption"][0].startswith("1 scene, seed 0")
    assert table_place("scorer") == ("Scorers", "held-out scenes")


def test_a_filter_gives_no_mark_that_the_table_withholds():
    kept = Row("Mean", (Cell(0.5, rank=1),), identifier="mean", ranked=True)
    partial = Row("Lite0", (Cell(0.9, ranked=False),), identifier="lite0", ranked=True)
    singles = [(name, "psnr", "s1", 0, value) for name, value in (("mean", 0.5), ("lite0", 0.9))]
    told = document([("Networks", kept), ("Networks", partial)], singles)
    shown = filtered(told, scene="s1")
    ranks = {row["identifier"]: row["cells"][0]["rank"] for group in shown["groups"] for row in group["rows"]}
    assert ranks == {"mean": 1, "lite0": None}


def test_scenes_of_one_name_in_two_data_sets_are_two_scenes():
    row = Row("Lite0", (Cell(0.5),), identifier="lite0")
    singles = [("lite0", dataset, "fox", "psnr", value) for dataset, value in (("a", 0.25), ("b", 0.75))]
    told = document([("Networks", row)], singles, ("predictor", "dataset", "scene", "metric", "value"))
    shown = {scene: filtered(told, scene=scene)["groups"][0]["rows"][0]["cells"][0] for scene in ("a/fox", "b/fox")}
    assert {scene: cell["value"] for scene, cell in shown.items()} == {"a/fox": 0.25, "b/fox": 0.75}

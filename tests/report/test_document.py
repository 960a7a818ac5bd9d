"""A document printed: of no record at all, with columns that have a published value and columns that have none."""

from avs.report.document import Cell, Column, Comparison, Difference, Document, Group, Listing, Row
from avs.report.formats.delimited import document_csv
from avs.report.formats.latex import document_latex
from avs.report.formats.markdown import document_markdown
from avs.report.formats.writing import write_document
from metrics.definitions import Metric

COVERED = Metric("covered", "Covered", True, 1, "%", "")
ERROR = Metric("error", "Error", False, 2, "m", "")

DOCUMENT = Document(
    label="coverage-big_hall",
    caption=("Coverage.", "One seed."),
    columns=(Column(COVERED, published=True), Column(ERROR)),
    groups=(
        Group("A", (Row("One", (Cell(61.25, 0.5, 2, "60.0"), Cell(-0.25))),)),
        Group(
            "B",
            (
                Row("Two", (Cell(cause="no weights-file", published="50.5"), Cell())),
                Row("Three", (Cell(70.0, rank=1), Cell(0.126, rank=3)), proposed=True),
            ),
        ),
    ),
    notes=("first", "second"),
    listing=Listing(("method", "covered"), (("one", "61.250"), ("two", ""))),
    comparison=Comparison("Difference to Three", (("One", (Difference(-8.75, (-9.0, -8.5)), Difference(0.5, None))),)),
    appendices={"_per_scene": Listing(("scene",), (("hall",),))},
)


def test_markdown():
    assert document_markdown(DOCUMENT).splitlines() == [
        "Coverage. One seed. Best in bold, second and third numbered.",
        "",
        "|  | Method | Covered ↑ (%) | published | difference | Error ↓ (m) |",
        "| --- | --- | ---: | ---: | ---: | ---: |",
        "| A | One | 61.2 ± 0.5 (2) | 60.0 | +1.2 | −0.25 |",  # noqa: RUF001
        "| B | Two | no weights-file | 50.5 | – | – |",  # noqa: RUF001
        "|  | Three | **70.0** | – | – | 0.13 (3) |",  # noqa: RUF001
        "",
        "Difference to Three:",
        "",
        "| Method | Covered ↑ (%) | Error ↓ (m) |",
        "| --- | ---: | ---: |",
        "| One | −8.8 [−9.0, −8.5] | +0.50 [one pair] |",  # noqa: RUF001
        "",
        "Notes:",
        "",
        "- first",
        "- second",
    ]


def test_latex():
    lines = document_latex(DOCUMENT).splitlines()
    assert r"\label{tab:coverage-big-hall}" in lines
    start = lines.index(r"\begin{tabular}{llrrrr}")
    assert lines[start + 2 : start + 12] == [
        r" & & \multicolumn{3}{c}{Covered $\uparrow$ (\%)} & Error $\downarrow$ (m) \\",
        r"\cmidrule(lr){3-5}",
        r" & Method & here & paper & diff. &  \\",
        r"\midrule",
        r"\multirow{1}{*}{A} & One & \cellcolor[HTML]{FCE5CD}61.2 $\pm$ 0.5 & 60.0 & $+1.2$ & $-$0.25 \\",
        r"\midrule",
        r"\multirow{2}{*}{B} & Two & {\scriptsize no weights-file} & 50.5 & -- & -- \\",
        r"\cmidrule(l){2-6}",
        r" & Three & \cellcolor[HTML]{F4CCCC}70.0 & -- & -- & \cellcolor[HTML]{D9EAD3}0.13 \\",
        r"\bottomrule",
    ]


def test_files(tmp_path):
    assert document_csv(DOCUMENT) == "method,covered\none,61.250\ntwo,\n"
    write_document(DOCUMENT, tmp_path / "coverage_v1.5")
    names = {"coverage_v1.5.csv", "coverage_v1.5.md", "coverage_v1.5.tex", "coverage_v1.5_per_scene.csv"}
    assert {path.name for path in tmp_path.iterdir()} == names

"""A document printed: of no record at all, with columns that have a published value and columns that have none."""

from dataclasses import replace

import pytest

from avs.report.document import Cell, Column, Comparison, Difference, Document, Group, Listing, Row
from avs.report.formats.delimited import document_csv
from avs.report.formats.latex import document_latex
from avs.report.formats.markdown import document_markdown, escaped
from avs.report.formats.table_record import read_table_record
from avs.report.formats.writing import write_document
from metrics.definitions import Metric

COVERED = Metric("covered", "Covered", True, 1, "%", "")
ERROR = Metric("error", "Error", False, 2, "m", "")

DOCUMENT = Document(
    label="coverage-big_hall",
    caption=("Coverage.", "One seed."),
    columns=(Column(COVERED, published="published", difference=True), Column(ERROR)),
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
        "| One | −8.8 [−9.0, −8.5] | +0.50 |",  # noqa: RUF001
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
        r" & Method & here & published & diff. &  \\",
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
    endings = (".csv", ".json", ".md", ".tex", "_per_scene.csv")
    assert {path.name for path in tmp_path.iterdir()} == {f"coverage_v1.5{ending}" for ending in endings}
    assert read_table_record(tmp_path / "coverage_v1.5.json") == DOCUMENT


def test_published_values_without_a_difference():
    column = Column(COVERED, published="published, Another_Hall")
    document = replace(DOCUMENT, columns=(column, Column(ERROR)))
    lines = document_markdown(document).splitlines()
    assert lines[2] == "|  | Method | Covered ↑ (%) | published, Another_Hall | Error ↓ (m) |"
    assert lines[4] == "| A | One | 61.2 ± 0.5 (2) | 60.0 | −0.25 |"  # noqa: RUF001
    latex = document_latex(document)
    assert r" & & \multicolumn{2}{c}{Covered $\uparrow$ (\%)} & Error" in latex
    assert r"\cmidrule(lr){3-4}" in latex
    assert r" & Method & here & published, Another\_Hall &  \\" in latex
    assert "diff." not in latex


HOSTILE = "50% of\n\r\n{a} | *b* \\c_ _d e_f $1$ `g` <h> [i](j) ~k~ \x1b[0m\u202e #l"


def test_text_with_commands_stays_on_its_line_and_is_escaped():
    rows = (Row(HOSTILE, (Cell(1.0), Cell(cause=HOSTILE))),)
    document = replace(
        DOCUMENT,
        caption=(HOSTILE,),
        groups=(Group(HOSTILE, rows),),
        notes=(HOSTILE, "# heading"),
        comparison=Comparison(HOSTILE, ((HOSTILE, (None, None)),)),
        listing=Listing(("note",), ((HOSTILE,),)),
    )
    markdown, latex, listing = document_markdown(document), document_latex(document), document_csv(document)
    told = r"50% of {a} \| \*b\* \\c\_ \_d e_f \$1\$ \`g\` \<h\> \[i\](j) \~k\~ \[0m #l"
    assert markdown.count(told) == 7
    assert f"| {told} | {told} | 1.0 | – | – | {told} |" in markdown  # noqa: RUF001
    assert "- \\# heading\n" in markdown
    told = (
        r"50\% of \{a\} \textbar{} *b* \textbackslash{}c\_ \_d e\_f \$1\$ \`{}g\`{} \textless{}h\textgreater{} "
        r"{[}i{]}(j) \textasciitilde{}k\textasciitilde{} {[}0m \#l"
    )
    assert latex.count(told) == 7
    assert listing.count("\n") == 2
    assert all(character.isprintable() or character == "\n" for character in markdown + latex + listing)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("orbit_0, orbit_1", "orbit_0, orbit_1"),
        ("1. first", "1\\. first"),
        ("- a", "\\- a"),
        ("a - b", "a - b"),
        ("&lt; R&D", "\\&lt; R&D"),
        ("", ""),
    ],
)
def test_only_what_markdown_would_read_is_escaped(text, expected):
    assert escaped(text) == expected

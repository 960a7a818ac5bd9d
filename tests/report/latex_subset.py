"""A strict reader of the part of LaTeX that the suite prints, and a real one where it is installed."""

import re
import shutil
import subprocess

PROGRAM = shutil.which("pdflatex")

# What must be installed beside the program: Debian's texlive-latex-recommended and texlive-latex-extra.
PREAMBLE = (
    r"\documentclass[10pt,twocolumn]{article}\usepackage[margin=2cm]{geometry}"
    r"\usepackage{booktabs,graphicx,multirow}\usepackage[table]{xcolor}\begin{document}"
)

_TOKEN = re.compile(r"\\[A-Za-z]+\*?|\\.|[{}$&#^_~%]|\n|[^\\{}$&#^_~%\n]+")
_WORDS = """
    begin end centering small footnotesize scriptsize setlength tabcolsep caption label ref colorbox strut resizebox
    ifdim else fi width textwidth toprule midrule bottomrule cmidrule multicolumn multirow cellcolor pm uparrow
    downarrow medskip smallskip noindent par textbackslash textasciitilde textasciicircum textless textgreater textbar
"""
_COMMANDS = {f"\\{word}" for word in [*_WORDS.split(), *r"\{}$&#%_`"]}
_ENVIRONMENTS = ("table*", "tabular")


def check_latex(text):
    """Raise an AssertionError unless groups, environments, mathematics, cells and rules fit together."""
    lines = [line for line in text.splitlines() if not line.startswith("%")]
    tokens = _TOKEN.findall("\n".join(re.sub(r"(?<=[{}])%$", "", line) for line in lines))
    assert "".join(tokens) == "\n".join(re.sub(r"(?<=[{}])%$", "", line) for line in lines)
    _check_tokens(tokens)
    tables = re.findall(r"\\begin\{tabular\}\{(\w+)\}\n(.*?)\n\\end\{tabular\}", text, re.DOTALL)
    assert len(tables) == text.count(r"\begin{tabular}")
    for columns, body in tables:
        assert set(columns) <= set("lr")
        _check_rows(len(columns), body.splitlines())


def _check_tokens(tokens):
    opened, mathematics = [], False
    for place, token in enumerate(tokens):
        around = "".join(tokens[max(0, place - 5) : place + 5])
        if token.startswith("\\"):
            assert token in _COMMANDS, f"{token} in {around}"
        if token in (r"\begin", r"\end"):
            name = tokens[place + 2]
            assert name in _ENVIRONMENTS, around
            if token == r"\begin":
                opened.append(name)
            else:
                assert opened[-1:] == [name], around
                opened.pop()
        elif token == "{":
            opened.append("{")
        elif token == "}":
            assert opened[-1:] == ["{"], around
            opened.pop()
        elif token == "$":
            mathematics = not mathematics
        elif token == "&":
            assert "tabular" in opened, around
            assert not mathematics, around
        elif token == "~":
            assert tokens[place + 1] == r"\ref", around
        assert token not in ("#", "^", "_", "%"), around
        assert token != "\n" or not mathematics, around
    assert not opened
    assert not mathematics


def _check_rows(columns, lines):
    """Check the rows of a table: their cells, what rules lie under, and how many rows a heading spans."""
    spanned = 0
    for line in lines:
        ranges = re.findall(r"\\cmidrule\(\w+\)\{(\d+)-(\d+)\}", line)
        assert all(1 <= int(low) <= int(high) <= columns for low, high in ranges), line
        if ranges or line in (r"\toprule", r"\midrule", r"\bottomrule", ""):
            assert spanned <= 0 or ranges, f"a heading goes on over a rule: {line}"
            continue
        assert line.endswith(r" \\"), line
        cells = re.split(r"(?<!\\)&", line.removesuffix(r" \\"))
        widths = [int(span[1]) if (span := re.match(r" ?\\multicolumn\{(\d+)\}", cell)) else 1 for cell in cells]
        assert sum(widths) == columns, line
        heading = re.match(r"\\multirow\{(\d+)\}", line)
        spanned = (int(heading[1]) if heading else spanned) - 1
    assert spanned <= 0


def compile_latex(folder, texts):
    """Return what a real LaTeX says of tables on pages of their own."""
    for number, text in enumerate(texts):
        (folder / f"table{number}.tex").write_text(text, encoding="utf-8")
    pages = "".join(f"\\input{{table{number}}}\\clearpage\n" for number in range(len(texts)))
    (folder / "all.tex").write_text(f"{PREAMBLE}\n{pages}\\end{{document}}\n")
    command = [PROGRAM, "-interaction=nonstopmode", "-halt-on-error", "all.tex"]
    for _ in range(2):  # the second knows the numbers of tables
        result = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    said = result.stdout.decode(errors="replace")
    assert result.returncode == 0, said[-2000:]
    return said

"""The documentation names nothing that does not exist: files, modules, commands with their options, links."""

import ast
import functools
import importlib
import io
import re
import tokenize
from pathlib import Path

import pytest
import typer
import yaml

from avs.commands.main import app
from avs.config.configuration import load
from avs.system.models import laid_over

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted({*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("results/published/*.md")})
RULES = [ROOT / "Snakefile", *sorted(ROOT.glob("workflows/**/*.smk"))]
SETTINGS = sorted(ROOT.glob("workflows/config/*.yaml"))
SOURCES = sorted(path for room in ("avs", "metrics", "tests") for path in ROOT.glob(f"{room}/**/*.py"))

FILE = re.compile(
    r"(?<![\w/<>.$~-])(?:avs|metrics|workflows|tests|docs|results/published|results/reference)/[\w./*-]*\w"
)
MODULE = re.compile(r"(?<![\w/.])(?:avs|metrics)(?:\.(?!py\b)\w+)+")
COMMAND = re.compile(r"(?:python -m |`)avs ((?:(?:weights|data) )?[a-z_]+)([^\n`]*)")
OPTION = re.compile(r"(?<=\s)--[a-z-]+")
LINK = re.compile(r"\]\(([^)#:]+)(?:#[^)]*)?\)")
BLOCK = re.compile(r"^```\w+ (\S+)$", re.MULTILINE)
EXAMPLE = re.compile(r"^```yaml\n(\w.*?)^```$", re.MULTILINE | re.DOTALL)
"""Parts of a configuration that a page shows; one that begins within a section is none."""

ELSEWHERE = {"avs/weights"}
"""Paths that are not the repository's: the folder of weights in the user's folder of caches."""


def prose(path):
    """Return what a program says to its reader: docstrings and comments."""
    text = path.read_text(encoding="utf-8")
    nodes = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    found = [ast.get_docstring(node) or "" for node in ast.walk(ast.parse(text)) if isinstance(node, nodes)]
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return "\n".join([*found, *(token.string for token in tokens if token.type == tokenize.COMMENT)])


def text_of(path):
    """Return what of a file is documentation: all of it, but of a program the prose."""
    return prose(path) if path.suffix == ".py" else path.read_text(encoding="utf-8")


def missing_files(text):
    """Return the paths in a text that are not in the repository; files that a page shows in full are examples."""
    shown = set(BLOCK.findall(text))
    named = set(FILE.findall(text)) - shown - ELSEWHERE
    return sorted(name for name in named if not any(ROOT.glob(name)))


@functools.cache
def exists(name):
    """Whether a dotted name is a module of this project, or what one holds."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for part in parts[count:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


def missing_modules(text):
    """Return the dotted names in a text that are neither modules of this project nor anything in one."""
    return sorted(name for name in set(MODULE.findall(text)) if not exists(name))


def unknown_commands(text):
    """Return the commands in a text that the command line does not have, or whose options it does not have."""
    group = typer.main.get_command(app)
    found = []
    for words, rest in COMMAND.findall(text):
        command = group
        for word in words.split():
            command = getattr(command, "commands", {}).get(word)
            if command is None:
                found.append(words)
                break
        else:
            known = {option for parameter in command.params for option in parameter.opts} | {"--help"}
            found += [f"{words} {option}" for option in OPTION.findall(rest.split("#")[0]) if option not in known]
    return found


ALL = [*PAGES, *RULES, *SETTINGS, *SOURCES]


@pytest.mark.parametrize("path", ALL, ids=lambda path: str(path.relative_to(ROOT)))
def test_what_is_named_exists(path):
    text = text_of(path)
    assert missing_files(text) == []
    if path.suffix in (".py", ".md"):
        assert missing_modules(text) == []
        assert unknown_commands(text) == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_links_lead_somewhere(path):
    links = LINK.findall(path.read_text(encoding="utf-8"))
    assert [link for link in links if not (path.parent / link).exists()] == []


def test_targets_of_make_exist():
    targets = re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    for page in PAGES:
        named = re.findall(r"(?:^|`)make (\w+)", page.read_text(encoding="utf-8"), re.MULTILINE)
        assert set(named) <= set(targets)


def test_what_does_not_exist_is_found():
    assert missing_files("see `avs/nowhere.py`, docs/tables.md and tests/*.py") == ["avs/nowhere.py"]
    assert missing_files("```python avs/selectors/mine.py\n```\navs/selectors/mine.py") == []
    assert missing_modules("``avs.scene.scene.read_scene``, avs.scene.nothing, metrics.image") == ["avs.scene.nothing"]
    assert unknown_commands("python -m avs conjure --out x\n`avs weights list`") == ["conjure"]
    assert unknown_commands("python -m avs weights list --colour") == ["weights list --colour"]


def examples():
    """Return the parts of configurations that the pages show, each with the name of its page."""
    found = [(path, text) for path in PAGES for text in EXAMPLE.findall(path.read_text(encoding="utf-8"))]
    return [pytest.param(text, id=f"{path.stem}-{text.partition(':')[0]}") for path, text in found]


@pytest.mark.parametrize("text", examples())
def test_a_configuration_that_a_page_shows_can_be_read(text):
    """As a second file over the default scale, without that scale's own section of further runs."""
    values, shown = yaml.safe_load((ROOT / "workflows/config/ci.yaml").read_text()), yaml.safe_load(text)
    for section in ("agnostic", "sensitivity"):
        values |= {section: None} if section in shown else {}
    assert load(laid_over(values, shown))

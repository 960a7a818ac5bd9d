"""What YAML passes over in silence and a reader of a configuration does not mean."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from avs.system.errors import UserError

_MERGE = "<<"


def check_files(paths: Iterable[Path | str]) -> None:
    """Check that no section of a file has a key twice, of which the last would count, and no number is octal.

    Files that are no YAML are left to Snakemake, which tells of them.

    Raises:
        UserError: names the file, the line and the key.
    """
    for path in map(Path, paths):
        try:
            root = yaml.compose(path.read_text(encoding="utf-8"), Loader=yaml.SafeLoader)
        except (OSError, UnicodeDecodeError, yaml.YAMLError):
            continue
        for node in _nodes(root):
            place = f"line {node.start_mark.line + 1}"
            if isinstance(node, yaml.MappingNode):
                _check_keys(path, node)
            elif node.tag == "tag:yaml.org,2002:int" and re.fullmatch("[-+]?0[0-7_]+", node.value):
                meant = node.value.replace("_", "")
                fault = f"{node.value} is the octal number {int(meant, 8)}"
                raise UserError(path, f"{place}: {fault}", "write it without a zero in front")


def check_options(words: Sequence[str], read: Mapping[str, Any]) -> None:
    """Check that Snakemake has read every value of ``--config`` as it was given.

    It reads them as YAML, in which a number sign begins a remark, drops the quotes around them, and of several options
    of this name the last alone.

    Args:
        words: of the command.
        read: what Snakemake has made of them, by key.

    Raises:
        UserError: names the first value that is lost or cut.
    """
    for key, given in dict(_options(words)).items():
        if key not in read:
            fault = "is lost: of several options --config Snakemake reads the last alone"
            raise UserError(f"--config {key}", fault, "give all values after one of them")
        value = given.strip("'\"")  # as Snakemake does
        found = read[key]
        if isinstance(found, str) and found != value and value.strip()[:1] not in ("'", '"'):
            fault = f"{value} would be read as {found}: it is taken for YAML"
            quoted = shlex.quote(f"{key}= {json.dumps(value, ensure_ascii=False)} ")
            remedy = f"write --config {quoted}, with both blanks: quotes at the very ends are dropped"
            raise UserError(f"--config {key}", fault, remedy)


def _options(words: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield key and value of each word that ``--config`` is given."""
    within = False
    for word in words:
        told = re.fullmatch("--config=(.*)|-C=?(.*)", word, re.DOTALL)
        if word in ("--config", "-C"):
            within = True
        elif told is not None or word.startswith("-"):
            within = False
        rest = (told[1] or told[2] or "") if told is not None else word if within else ""
        key, equals, value = rest.partition("=")
        if equals:
            yield key, value


def _check_keys(path: Path, section: yaml.MappingNode) -> None:
    lines: dict[str, int] = {}
    for key, _ in section.value:
        line = key.start_mark.line + 1
        if not isinstance(key, yaml.ScalarNode) or key.value == _MERGE:
            continue
        if key.value in lines:
            fault = f"line {line}: {key.value} is there twice in one section, first in line {lines[key.value]}"
            raise UserError(path, fault, "remove one of them")
        lines[key.value] = line


def _nodes(root: yaml.Node | None) -> Iterator[yaml.Node]:
    """Yield each node below ``root`` once: a part that is named again is the same one."""
    waiting, seen = [] if root is None else [root], set()
    while waiting:
        node = waiting.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        yield node
        if isinstance(node, yaml.MappingNode):
            waiting += [each for pair in node.value for each in pair]
        elif isinstance(node, yaml.SequenceNode):
            waiting += node.value

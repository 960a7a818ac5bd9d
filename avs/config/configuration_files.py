"""What YAML passes over in silence and a reader of a configuration does not mean."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

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

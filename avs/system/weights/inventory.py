"""What the command line reports about the weights on this machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from avs.system.errors import UserError
from avs.system.files import file_hash
from avs.system.weights.cache import damage, find, folder, locate, recorded_hash, remedy
from avs.system.weights.manifest import MANIFEST, Weights
from avs.system.weights.reading import read_fault


def listing() -> list[str]:
    """Return one line per entry of the manifest, and one with the cache folder."""
    lines = []
    for name, entry in MANIFEST.items():
        size = "size told when fetched" if entry.bytes is None else f"{entry.bytes / 1e6:.0f} MB"
        hashed = "hash unknown" if entry.sha256 is None else f"sha256 {entry.sha256[:8]}"
        there = locate(name)
        place = f"absent: {remedy(name)}" if there is None else f"present: {there}"
        lines += [
            f"{name}: {place}",
            f"    {entry.url}",
            f"    {size}, {hashed}; {entry.licence}; used by {entry.used_by}",
        ]
    return [*lines, f"cache folder: {folder()}"]


def check(names: Sequence[str], report: Callable[[str], None]) -> None:
    """Compare local files with the manifest and read each; report one line for each.

    Args:
        names: entries of the manifest, whose absence is a fault then; none for all that are present.
        report: receives the lines.

    Raises:
        UserError: a file is damaged, or absent though named.
    """
    faulty = []
    for name in names or MANIFEST:
        path = locate(name)
        entry = find(name)
        if path is None:
            fault: str | None = "absent"
            report(f"{name}: absent")
        else:
            fault = damage(entry, path) or read_fault(path)
            report(f"{name}: {fault or _certainty(entry, path)}, {path}")
        if fault is not None and (path is not None or names):
            faulty.append(name)
    if faulty:
        raise UserError(f"weights {', '.join(faulty)}", "damaged or absent", remedy(*faulty))


def _certainty(entry: Weights, path: Path) -> str:
    """Return how well a good file is known."""
    if entry.sha256 is not None and (entry.exact or file_hash(path).startswith(entry.sha256)):
        return "as published"
    if recorded_hash(path) is not None:
        return "as downloaded"
    return "readable; no hash to compare with" if entry.sha256 is None else "readable; another file than the published"

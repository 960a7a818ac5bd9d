"""What the page tells of a table: its document as JSON, and where it stands among the others."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from avs.report.document import Document
from avs.report.published import headed

_PER_SCENE = "_per_scene"

_KINDS: tuple[tuple[str, str, str], ...] = (
    ("nvs_", "View synthesis", "{}"),
    ("scenes_", "Scene by scene", "{}"),
    ("significance_", "Which methods differ", "{}"),
    ("coverage_", "Coverage", "{}"),
    ("ranking_", "Scores against truth", "{}"),
    ("sensitivity_", "Settings", "{}"),
    ("agnostic_", "Representations", "{}"),
    ("runtime_memory", "Selection times", "time and memory"),
    ("runtime_detail", "Selection times", "time and PSNR"),
    ("runtime", "Selection times", "all that is measured"),
    ("active_slam", "Active SLAM", "buildings"),
    ("scorer", "Scorers", "held-out scenes"),
    ("re10k_mfr", "View synthesis", "two data sets side by side"),
)
"""How the name of a table begins, its section, and its title with the name of the data set."""

SECTIONS = tuple(dict.fromkeys(section for _, section, _ in _KINDS))
"""The sections of tables, in order."""


def table_place(name: str) -> tuple[str, str]:
    """Return the section and the title of a table by the name of its file without suffix."""
    for beginning, section, title in _KINDS:
        if name.startswith(beginning):
            return section, title.format(headed(name.removeprefix(beginning)))
    return "Other", name


def table_facts(document: Document) -> dict[str, Any]:
    """Return a document as the page has it.

    The long lists for other programs are left out but the values of single scenes, from which the page computes means
    over the scenes and seeds that a reader asks for.
    """
    told = asdict(document)
    appendices = told.pop("appendices")
    del told["listing"]
    told["per_scene"] = _singles(appendices.get(_PER_SCENE))
    return told


def _singles(listing: dict[str, Any] | None) -> dict[str, Any] | None:
    """Return the values of single scenes with all their digits: of rounded ones, other means can come out."""
    if listing is None:
        return None
    values = listing["exact"]
    records = [[*told, value] for (*told, _), value in zip(listing["records"], values, strict=True)]
    return {"fields": listing["fields"], "records": records}

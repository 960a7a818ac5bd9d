"""The page itself: its frame, the tables, the figures, and an index of what else there is."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from avs.report.document import Document
from avs.report.figures.captions import read_caption
from avs.report.formats.table_record import read_table_record
from avs.report.page.figure_places import FIGURE_SECTIONS, figure_place
from avs.report.page.method_facts import method_sources
from avs.report.page.script_files import plain_tree, script_text, write_script
from avs.report.page.table_facts import SECTIONS, table_facts, table_place
from avs.report.published import called
from avs.system.errors import UserError
from avs.system.files import atomic_folder, write_text
from avs.system.reasons import Reason

FOLDER = Path(__file__).parent
SCRIPTS = (
    "core",
    "route",
    "numbers",
    "chart",
    "table_view",
    "table_filters",
    "leaderboard",
    "scene_space",
    "score_bars",
    "image_slider",
    "player",
    "provenance",
    "coverage_part",
    "splat_view",
    "episode_parts",
    "episode_view",
    "episodes_view",
    "compare_view",
    "truth_view",
    "slam_view",
    "other_views",
    "main",
)
"""The scripts of the page without suffix, in the order in which they are loaded."""

STATIC = "static"


@dataclass(frozen=True)
class PageInputs:
    """What the page is made from.

    Attributes:
        tables: records of tables (``avs.report.formats.table_record``).
        figures: ``.png`` and ``.gif`` files; the caption of one may lie beside it as Markdown.
        cards: model cards of scorers.
    """

    tables: Sequence[Path] = ()
    figures: Sequence[Path] = ()
    cards: Sequence[Path] = ()


@dataclass(frozen=True)
class PageFacts:
    """What the page tells of the run.

    Attributes:
        scale: its name.
        scenes: names of the scenes by data set, in order.
        methods: identifiers, in order.
        absent: why one does not run, by identifier.
        config: the whole configuration, as JSON has it.
        explorations: methods and seeds of the explorations by building.
    """

    scale: str
    scenes: Mapping[str, Sequence[str]]
    methods: Sequence[str]
    absent: Mapping[str, Reason]
    config: Mapping[str, Any]
    explorations: Mapping[str, Sequence[tuple[str, int]]] = field(default_factory=dict)


def write_page(inputs: PageInputs, facts: PageFacts, page: Path) -> None:
    """Write ``index.html`` and all that it needs but the scripts of scenes; equal records give equal bytes.

    Args:
        inputs: what it is made from.
        facts: of the run.
        page: the page's folder, in which the scripts of scenes lie already.

    Raises:
        UserError: a file is missing or damaged.
    """
    tables = {path.stem: read_table_record(path) for path in inputs.tables}
    with atomic_folder(page / "tables") as temporary:
        for name, table in tables.items():
            (temporary / f"{name}.js").write_text(script_text(f"tables/{name}", table_facts(table)), encoding="ascii")
    with atomic_folder(page / "figures") as temporary:
        for path in inputs.figures:
            shutil.copyfile(path, temporary / path.name)
    with atomic_folder(page / STATIC) as temporary:
        for path in static_files():
            shutil.copyfile(path, temporary / path.name)
    write_script(page, "index", _index(inputs, facts, tables))
    write_text(page / "index.html", _frame(facts))


def static_files() -> list[Path]:
    """Return the files that every page has: scripts, the style, and what is bundled with its licences."""
    return sorted(path for path in (FOLDER / STATIC).iterdir() if path.is_file())


def _frame(facts: PageFacts) -> str:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(FOLDER), autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True
    )
    return environment.get_template("index.html.j2").render(scale=facts.scale, static=STATIC, scripts=SCRIPTS)


def _index(inputs: PageInputs, facts: PageFacts, tables: Mapping[str, Document]) -> dict[str, Any]:
    places = [(name, *table_place(name)) for name in tables]
    ordered = sorted(places, key=lambda place: SECTIONS.index(place[1]) if place[1] in SECTIONS else len(SECTIONS))
    figures = [_figure(path) for path in inputs.figures]
    return {
        "scale": facts.scale,
        "data_sets": [
            {"name": name, "called": called(name), "scenes": list(scenes)} for name, scenes in facts.scenes.items()
        ],
        "methods": method_sources(facts.methods, facts.absent, list(tables.values())),
        "tables": [{"name": name, "section": section, "title": title} for name, section, title in ordered],
        "figures": sorted(figures, key=lambda each: FIGURE_SECTIONS.index(each["section"])),
        "cards": {path.parent.name: _card(path) for path in inputs.cards},
        "explorations": {building: list(map(list, runs)) for building, runs in facts.explorations.items()},
        "config": plain_tree(facts.config),
    }


def _figure(path: Path) -> dict[str, Any]:
    section, title, text = figure_place(path.stem)
    return {
        "file": path.name,
        "section": section,
        "title": title,
        "caption": (read_caption(path) or text).replace("`", ""),
    }


def _card(path: Path) -> dict[str, Any]:
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UserError(path, "cannot be read", "run the job that makes it again") from error
    if not isinstance(told, dict):
        raise UserError(path, "is no model card", "run the job that makes it again")
    return told

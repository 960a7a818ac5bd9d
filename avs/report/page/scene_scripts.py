"""The scripts of one scene: its facts, photographs, episodes with their pictures and models, and common states."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from avs.nvs.common_states_record import CommonStates
from avs.nvs.pictures import read_pictures
from avs.nvs.record import Episode
from avs.report.collect import Episodes, read_dataset
from avs.report.page.coverage_facts import read_coverage_page
from avs.report.page.episode_facts import episode_facts
from avs.report.page.exported_model import SPLATS
from avs.report.page.page_pictures import picture, pictures
from avs.report.page.page_settings import PageSettings
from avs.report.page.scene_facts import scene_facts
from avs.report.page.script_files import encoded, script_text
from avs.report.page.splat_bytes import splat_bytes
from avs.report.page.states_facts import states_facts
from avs.scene.scene import Scene, read_scene
from avs.system.errors import UserError
from avs.system.files import atomic_folder
from avs.system.reasons import Reason
from avs.system.records import read_record


@dataclass(frozen=True)
class SceneInputs:
    """What the scripts of a scene are made from.

    Attributes:
        folder: of the scene.
        episodes: ``episode.json`` files; the times, pictures and model of each lie beside it.
        coverage: ``coverage.json`` files, with their clouds beside.
        states: records of the common states, one for each seed.
    """

    folder: Path
    episodes: Sequence[Path]
    coverage: Sequence[Path] = ()
    states: Sequence[Path] = ()


class Allowance:
    """How many bytes of pictures, models and clouds may still be written."""

    def __init__(self, limit: int, told: str) -> None:
        """Begin with ``limit`` bytes; ``told`` says what limits them, for a reader who misses something."""
        self._left = limit
        self.why_not = f"left out for {told}"

    def spend(self, size: int) -> None:
        """Count ``size`` bytes that are written in any case."""
        self._left -= size

    def take(self, size: int) -> bool:
        """Return whether ``size`` bytes fit into what is left, and count them if they do."""
        fits = size <= self._left
        self._left -= size if fits else 0
        return fits


def write_scene_scripts(
    inputs: SceneInputs,
    methods: Sequence[str],
    absent: Mapping[str, Reason],
    settings: PageSettings,
    share: float,
    out: Path,
) -> None:
    """Write the folder ``out``, whole or not at all; equal records give equal bytes.

    Args:
        inputs: what it is made from.
        methods: identifiers of all methods of the run, in order.
        absent: why one has no episode, by identifier.
        settings: of the page.
        share: of the page's limit of bytes, in 0..1.
        out: ``<page>/scenes/<data set>/<scene>``.

    Raises:
        UserError: a file is missing, damaged, or does not belong to the others.
    """
    scene = read_scene(inputs.folder)
    episodes = read_dataset(inputs.episodes, methods, scene.dataset)
    for episode in episodes.all:
        if episode.scene != scene.name or episode.scene_hash != scene.content_hash:
            raise UserError(inputs.folder, f"is not the scene of {episode.method}'s episode", "run the same line again")
    words = f"the page's limit of {settings.megabytes:g} MB (report.page.megabytes of the configuration)"
    allowance = Allowance(int(settings.megabytes * 1e6 * share), words)
    scripts = _Scripts(f"scenes/{scene.dataset}/{scene.name}", {}, allowance)
    facts = scene_facts(scene, episodes, methods, absent, settings)
    facts["states"] = _add_states(scripts, scene, inputs.states)
    scripts.add("scene", facts)
    told = _episodes(scripts, scene, episodes, inputs.coverage, settings)
    allowance.spend(sum(len(script_text(_stem(*key), each)) for key, each in told.items()))
    _add_photographs(scripts, scene, episodes, settings)
    _add_what_is_large(scripts, scene, episodes, told, settings)
    for key, each in told.items():
        scripts.texts[_stem(*key)] = script_text(f"{scripts.place}/{_stem(*key)}", each)
    with atomic_folder(out) as temporary:
        for name, text in scripts.texts.items():
            (temporary / f"{name}.js").write_text(text, encoding="ascii")


@dataclass(frozen=True)
class _Scripts:
    """The scripts of a scene by name, and what may still be added."""

    place: str
    texts: dict[str, str]
    allowance: Allowance

    def add(self, name: str, value: object) -> None:
        """Add a script in any case."""
        self.texts[name] = script_text(f"{self.place}/{name}", value)
        self.allowance.spend(len(self.texts[name]))

    def add_within(self, name: str, value: object) -> str | None:
        """Add a script if it fits, and return why it does not."""
        text = script_text(f"{self.place}/{name}", value)
        if not self.allowance.take(len(text)):
            return self.allowance.why_not
        self.texts[name] = text
        return None


def _add_photographs(scripts: _Scripts, scene: Scene, episodes: Episodes, settings: PageSettings) -> None:
    """Add the photographs that an episode captured, and those of its test images of which renderings are kept."""
    named: dict[str, None] = {}
    for episode in sorted(episodes.all, key=lambda each: each.seed):
        kept = [] if episode.pictures is None else episode.pictures.test
        named |= dict.fromkeys([*kept, *episode.initial, *episode.selected])
    found = {}
    for name in named:
        place = scene.names.index(name)
        address = picture(scene.views([place]).images[0], settings)
        if scripts.allowance.take(len(address)):
            found[str(place)] = address
    told = {"pictures": found, "why_not": scripts.allowance.why_not}
    scripts.texts["photographs"] = script_text(f"{scripts.place}/photographs", told)


_Facts = dict[tuple[str, int], dict[str, Any]]
"""What is told of each episode, by method and seed."""


def _episodes(
    scripts: _Scripts, scene: Scene, episodes: Episodes, coverage: Sequence[Path], settings: PageSettings
) -> _Facts:
    """Return the facts of each episode, by seed, then by method, and add the cloud that their coverage shares."""
    facts = {
        (each.method, each.seed): episode_facts(episodes.places[each.method, each.scene, each.seed], each, scene.names)
        for each in sorted(episodes.all, key=lambda each: each.seed)
    }
    for key, told in _coverage(scripts, coverage, scene, settings).items():
        if key in facts:
            facts[key]["coverage"] = told
    return facts


def _add_what_is_large(
    scripts: _Scripts, scene: Scene, episodes: Episodes, facts: _Facts, settings: PageSettings
) -> None:
    """Add pictures and models by seed, then by kind, then by method, as long as there is room; facts say why not."""

    def add_pictures(episode: Episode, path: Path) -> str | None:
        kept = read_pictures(path, episode)
        if not kept:
            return "the run kept none (pictures: null)"
        return scripts.add_within(f"{_stem(episode.method, episode.seed)}-pictures", pictures(kept, settings))

    def add_splats(episode: Episode, path: Path) -> str | None:
        if not path.with_name(SPLATS).exists():
            return "the reconstruction has no Gaussians to export"
        content, count = splat_bytes(path.with_name(SPLATS), scene.to_capture, settings.gaussians)
        told = {"count": count, "splats": encoded(content)}
        return scripts.add_within(f"{_stem(episode.method, episode.seed)}-splats", told)

    kinds: tuple[tuple[str, Callable[[Episode, Path], str | None]], ...] = (
        ("no_pictures", add_pictures),
        ("no_splats", add_splats),
    )
    for seed in episodes.seeds:
        for word, add in kinds:
            for each in episodes.all:
                if each.seed == seed:
                    path = episodes.places[each.method, each.scene, each.seed]
                    facts[each.method, seed][word] = add(each, path)


def _coverage(
    scripts: _Scripts, records: Sequence[Path], scene: Scene, settings: PageSettings
) -> dict[tuple[str, int], dict[str, Any]]:
    """Return what there is of coverage by method and seed, and add the cloud that all share."""
    found: dict[tuple[str, int], dict[str, Any]] = {}
    for path in records:
        read = read_coverage_page(path, scene.content_hash, settings.points)
        found[path.parents[1].name, int(path.parent.name)] = read.facts
        if read.cloud is not None and "cloud" not in scripts.texts:
            scripts.add("cloud", read.cloud)
    return found


def _add_states(scripts: _Scripts, scene: Scene, records: Sequence[Path]) -> list[int]:
    """Add the common states and return their seeds."""
    seeds = []
    for path in records:
        record = read_record(path, CommonStates)
        if record.scene_hash != scene.content_hash:
            raise UserError(path, "is of another version of the scene", "run the same line again")
        scripts.add(f"states-{record.seed}", states_facts(record, scene.names))
        seeds.append(record.seed)
    return seeds


def _stem(method: str, seed: int) -> str:
    return f"{method}-{seed}"

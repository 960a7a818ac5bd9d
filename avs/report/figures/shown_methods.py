"""Which methods, scenes and test images a figure of pictures shows: by rules that look at no picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import chain, zip_longest

import numpy as np

from avs.nvs.record import Episode
from avs.report.collect import Episodes, end_of_curve, image_mean
from avs.report.figure_settings import BEST, PROPOSED, REFERENCE
from avs.report.methods import presented


def shown_methods(episodes: Episodes, wanted: Sequence[str], reference: str | None) -> list[str]:
    """Return the identifiers of the methods that a figure of a data set shows, each once, in the order asked for.

    Args:
        episodes: of the data set.
        wanted: see ``FigureSettings.methods``.
        reference: the method that the tables compare with, or None.
    """
    meanings = {
        REFERENCE: [] if reference is None else [reference],
        PROPOSED: [method for method in episodes.cells if presented(method, episodes).proposed],
        BEST: best_methods(episodes)[:1],
    }
    found = chain.from_iterable(meanings.get(name, [name]) for name in wanted)
    return [method for method in dict.fromkeys(found) if episodes.cells.get(method)]


def best_methods(episodes: Episodes) -> list[str]:
    """Return the ranked methods by their mean test PSNR at the end, best first; ties in the order of the methods.

    Means are over the scenes and seeds that all of them have, so that they can be compared.
    """
    ranked = [method for method, cells in episodes.cells.items() if cells and presented(method, episodes).competes]
    if not ranked:
        return []
    shared = set.intersection(*(set(episodes.cells[method]) for method in ranked))
    means = {
        method: np.mean([_final_psnr(episodes.cells[method][cell]) for cell in sorted(shared)]) if shared else 0.0
        for method in ranked
    }
    return sorted(ranked, key=lambda method: -means[method])


def shown_scenes(datasets: Mapping[str, Sequence[str]], count: int) -> list[tuple[str, str]]:
    """Return the data sets and scenes that a figure shows: the first scene of each data set, then the second, ...

    Args:
        datasets: names of scenes by data set.
        count: how many at most.
    """
    rounds = zip_longest(*([(name, scene) for scene in scenes] for name, scenes in datasets.items()))
    return [pair for pair in chain.from_iterable(rounds) if pair is not None][:count]


def most_differing(episodes: Sequence[Episode]) -> str | None:
    """Return the name of the kept test image whose PSNR ranges most among these episodes, the first of equal ones.

    None where no test image is kept by all of them.
    """
    kept = [each.pictures.test for each in episodes if each.pictures is not None]
    names = [name for name in kept[0] if all(name in other for other in kept)] if kept else []
    if not names:
        return None
    values = [[image_psnr(each, name) for each in episodes if each.pictures is not None] for name in names]
    return names[int(np.argmax(np.round(np.ptp(values, axis=1), 6)))]


def image_psnr(episode: Episode, name: str) -> float:
    """Return the PSNR of a test image at the end of an episode."""
    return next(image.psnr for image in end_of_curve(episode).images if image.name == name)


def _final_psnr(episode: Episode) -> float:
    value = image_mean(end_of_curve(episode), "psnr")
    assert value is not None  # only LPIPS can be absent
    return value

"""Draws the test PSNR over the number of captured views."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from avs.report.collect import read_episodes
from avs.report.figures.captions import told_of_machines, write_caption
from avs.report.figures.curves import panels
from avs.report.figures.over_views import Wording, draw_over_views

_WORDING = Wording("test PSNR (dB)", "difference to the\nmean of methods (dB)", "end of optimisation")

_CAPTION = (
    "Mean PSNR of the test images over the number of captured views, and below it the difference to the mean of the "
    "methods in the same scene with the same seed, both over the scenes and seeds that all methods have. Thick lines "
    "are the reference method and the two with the highest last value, bands their intervals; a dot is the end of the "
    "optimisation."
)


def write_psnr_over_views(
    episodes: Sequence[Path], methods: Sequence[str], out: Path, reference: str | None = None
) -> None:
    """Write ``out`` as ``.pdf`` and ``.png``, and its caption as ``.md``: a pair of plots for each data set and budget.

    The upper plot has the mean test PSNR over scenes and seeds against the number of captured views, measured just
    before the next view is added; the last point, with a dot, is the end of the optimisation. The lower plot has the
    difference to the mean of the methods in the same scene with the same seed. Emphasised are the reference method and
    the two with the highest last value; their bands are the interval of ``avs.report.intervals``, over scenes or over
    seeds as the plot says, and may leave it. Differences between scenes, which are larger than those between methods,
    are thus not in the band. Scenes with a smaller budget have plots of their own, so that every point of a curve is a
    mean over the same scenes. Equal records give equal bytes.

    Args:
        episodes: ``episode.json`` files, of any data sets.
        methods: identifiers of the methods, in the order of their lines.
        out: path of the figure without suffix.
        reference: the method that the tables compare with, or None.

    Raises:
        UserError: no episodes; or a record is missing, damaged, or not comparable with the others of its data set.
    """
    drawn = [panel for collected in read_episodes(episodes, methods) for panel in panels(collected)]
    draw_over_views(drawn, reference, _WORDING, out)
    write_caption(out, _CAPTION + told_of_machines(episodes))

"""The metrics as data: identifier, printed name, direction, decimals and unit. Shading and ranking follow from it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Metric:
    """One metric.

    Attributes:
        identifier: the key in records and csv files.
        name: as printed.
        higher_is_better: its direction; None for a quantity without one, such as a count.
        decimals: digits after the point in a printed table.
        unit: printed unit, empty for a plain number.
        description: how it is computed, one sentence.
    """

    identifier: str
    name: str
    higher_is_better: bool | None
    decimals: int
    unit: str
    description: str


METRICS: dict[str, Metric] = {
    metric.identifier: metric
    for metric in (
        Metric("psnr", "PSNR", True, 2, "dB", "peak signal-to-noise ratio over all pixels and channels of an image"),
        Metric(
            "psnr_per_channel", "PSNR (channels)", True, 2, "dB", "mean of the three channels' PSNR, as in FisherRF"
        ),
        Metric("ssim", "SSIM", True, 3, "", "structural similarity, 11x11 Gaussian window of sigma 1.5, zero padding"),
        Metric("lpips", "LPIPS", False, 3, "", "learned perceptual image patch similarity, version 0.1"),
    )
}
"""Every metric by identifier, in the order of columns."""


COVERAGE: dict[str, Metric] = {
    metric.identifier: metric
    for metric in (
        Metric("scr_percent", "SCR", True, 2, "%", "share of the reference cloud near to the cloud of the views"),
        Metric("f_score", "F-score", True, 3, "", "mean over thresholds of the harmonic mean of precision and recall"),
        Metric("toolbox_f_score", "F (toolbox)", True, 3, "", "at one threshold, as the Tanks and Temples toolbox"),
        Metric("true_scr_percent", "true SCR", True, 2, "%", "share of the true surface near to the cloud"),
        Metric("true_f_score", "true F-score", True, 3, "", "the F-score against the true surface"),
        Metric("cloud_points", "points", None, 0, "", "points of the cloud of the views"),
        Metric("registered_views", "views", None, 1, "", "views that the cloud is made of"),
    )
}
"""The metrics of coverage by identifier, in the order of columns (``metrics/coverage.py``)."""

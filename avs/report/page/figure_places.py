"""Where each figure stands on the page and in Snakemake's report, and what it shows in a sentence."""

from __future__ import annotations

_FIGURES: tuple[tuple[str, str, str, str], ...] = (
    (
        "psnr_over_views_",
        "View synthesis",
        "PSNR over views: {}",
        "Mean PSNR of the test images over the number of captured views; below it, the difference to the mean of all "
        "methods in the same scene with the same seed, with intervals of the methods in bold.",
    ),
    ("qualitative", "View synthesis", "Renderings beside photographs", "Final renderings of test images."),
    ("selected_cameras_", "View synthesis", "Selected views: {}", "Which views each method selected, in which order."),
    (
        "score_maps_",
        "View synthesis",
        "Score maps: {}",
        "The rendering of the chosen view, the SSIM map that the method predicted of it, and the true one.",
    ),
    (
        "critical_difference_",
        "View synthesis",
        "Average ranks: {}",
        "Average ranks of the methods over scenes; bars lie over those that Nemenyi's test cannot tell apart.",
    ),
    ("teaser", "Selection times", "Selection time against PSNR", "Time of one selection against the test PSNR."),
    (
        "time_and_psnr",
        "Selection times",
        "Time and PSNR over views",
        "Time of each selection and the test PSNR over the number of captured views.",
    ),
    (
        "egocentric_and_phone",
        "Data",
        "Egocentric photographs and those of a phone",
        "Photographs of an egocentric device beside those of a phone, with their field of view and luminance.",
    ),
    (
        "coverage_maps",
        "Coverage",
        "Maps of coverage",
        "Distance of each point of the reference cloud to the cloud of the views that a method selected.",
    ),
    ("coverage_over_views", "Coverage", "Coverage over views", "Surface coverage ratio over the number of views."),
    (
        "slam_maps_",
        "Active SLAM",
        "Maps of explorations: {}",
        "What each robot covered of the building, from above, with its way, the candidates and the chosen ones.",
    ),
    ("slam_over_steps", "Active SLAM", "Coverage over actions", "Covered share of the surface over a robot's actions."),
    (
        "slam_",
        "Active SLAM",
        "An exploration: {}",
        "The camera's picture, the rendering of the final map there, and the way of the robot from above.",
    ),
)
"""How the name of a figure begins, its section, its title with the rest of the name, and what it shows."""

OTHER = "Other"
"""The section of a figure that is not known here, such as a plug-in's."""

FIGURE_SECTIONS = (*dict.fromkeys(section for _, section, _, _ in _FIGURES), OTHER)
"""The sections, in order."""


def figure_place(name: str) -> tuple[str, str, str]:
    """Return the section and the title of a figure, and what it shows, by the name of its file without suffix."""
    for beginning, section, title, text in _FIGURES:
        if name.startswith(beginning):
            return section, title.format(name.removeprefix(beginning)), text
    return OTHER, name, ""

"""The numbers and the figure of ``docs/hypothesis-study.md``: when is the worst view the one to capture?

    python -m tests.benchmarks.hypothesis_study RESULTS DATASET --figure FILE

RESULTS is the folder of a finished run whose methods include ``random``. Printed is, for each scene and for their mean
with its standard error over scenes:

- test PSNR and SSIM less those of random choice with the same seed;
- how the captured views lie: the distance of every view of the scene to the nearest captured one, less random
  choice's, in per cent of it;
- Spearman's rho between the scores of a moment and of a later one for the views that are candidates at both, of the
  oracles, which know the truth, and of others: how much of a view's quality is the view's own, whatever has been
  captured since.
"""

import argparse
from pathlib import Path

import matplotlib
import numpy as np
from scipy.spatial.distance import cdist
from scipy.stats import spearmanr

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from avs.config.run_episodes import episodes_of_run
from avs.report.collect import end_of_curve, image_mean, read_dataset
from avs.scene.scene import read_scene

LATER = 5
"""Selections between the two moments that are compared."""


def spacing(scene, episode):
    """Return the mean distance of all views of a scene to the nearest captured one, in its extents."""
    place = {name: index for index, name in enumerate(scene.names)}
    captured = [place[name] for name in (*episode.initial, *episode.selected)]
    centers = scene.cameras.centers
    return cdist(centers, centers[captured]).min(axis=1).mean() / scene.extent


def persistence(episode, later=LATER):
    """Return the mean of Spearman's rho between the scores of a step and of the ``later``-th after it."""
    known = [dict(zip(step.candidates, step.scores, strict=True)) for step in episode.steps]
    found = []
    for first, second in zip(known, known[later:], strict=False):
        shared = sorted(first.keys() & second.keys())
        if len(shared) > 2:
            found.append(spearmanr([first[name] for name in shared], [second[name] for name in shared]).statistic)
    return np.mean(found)


def measured(episodes, scenes, value, methods=None):
    """Return ``value`` of each method that has all episodes, ``[scenes, seeds]``, by its printed name."""
    return {
        next(iter(of.values())).label: np.array(
            [[value(scenes[name], of[name, seed]) for seed in episodes.seeds] for name in episodes.scenes]
        )
        for method, of in episodes.cells.items()
        if not episodes.lacking(method) and (methods is None or method in methods)
    }


def printed(title, rows, scenes, form):
    """Print a table of each method's means by scene, with the mean over scenes and its standard error."""
    print(f"\n{title}\n\n| | {' | '.join(scenes)} | mean |\n|---|{'---|' * (len(scenes) + 1)}")
    for method, values in rows.items():
        means = values.mean(axis=1)
        error = means.std(ddof=1) / len(means) ** 0.5 if len(means) > 1 else float("nan")
        cells = " | ".join(form % mean for mean in means)
        print(f"| {method} | {cells} | {form % means.mean()} +- {(form % error).lstrip('+')} |")


def drawn(gains, spacings, scenes, path):
    """Draw what each method gains over random choice, by scene, and against how its views lie."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), constrained_layout=True)
    methods = sorted(gains, key=lambda method: gains[method].mean())
    markers = "osD^vP*X"
    for row, method in enumerate(methods):
        for scene, values in enumerate(gains[method]):
            left.scatter(values.mean(), row, color=f"C{scene}", marker=markers[scene], s=22, zorder=3)
        mean = gains[method].mean()
        left.plot([mean, mean], [row - 0.32, row + 0.32], color="black", lw=1.6, zorder=2)
    left.axvline(0, color="0.6", lw=0.8)
    left.set_yticks(range(len(methods)), methods)
    left.set_xlabel("PSNR less Random's, dB\n(bar: mean over scenes)")
    for scene, name in enumerate(scenes):
        x = [100 * spacings[method][scene].mean() for method in methods]
        y = [gains[method][scene].mean() for method in methods]
        right.scatter(x, y, color=f"C{scene}", marker=markers[scene], s=22, label=name)
    right.axhline(0, color="0.6", lw=0.8)
    right.axvline(0, color="0.6", lw=0.8)
    right.set_xlabel("distance to the nearest captured view,\nper cent more than Random's")
    right.set_ylabel("PSNR less Random's, dB")
    right.legend(frameon=False, fontsize=8)
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path, dpi=150, metadata={"Software": None})


def main():
    """Print the tables of one run, and draw their figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("dataset")
    parser.add_argument("--figure", type=Path)
    told = parser.parse_args()
    paths = [path for path in episodes_of_run(told.results) if path.parts[-5] == told.dataset]
    methods = sorted({path.parts[-3] for path in paths})
    episodes = read_dataset(paths, methods, told.dataset)
    names = episodes.scenes
    lacking = sorted(method for method in episodes.cells if episodes.lacking(method))
    if "random" in lacking or "random" not in episodes.cells:
        parser.error(f"{told.dataset}: the run lacks episodes of random, which the others are held to; complete it")
    seeds = ", ".join(map(str, episodes.seeds))
    print(f"{told.dataset}: scenes {', '.join(names)}; means over the seeds {seeds}.")
    print(f"Without all episodes, and so left out: {', '.join(lacking) or 'no method'}.")
    scenes = {name: read_scene(told.results / "scenes" / told.dataset / name) for name in names}

    def difference(value):
        found = measured(episodes, scenes, value)
        return {method: values - found["Random"] for method, values in found.items() if method != "Random"}

    gains = difference(lambda _, episode: image_mean(end_of_curve(episode), "psnr"))
    printed("PSNR less Random's, dB", gains, names, "%+.2f")
    printed(
        "SSIM less Random's", difference(lambda _, episode: image_mean(end_of_curve(episode), "ssim")), names, "%+.3f"
    )
    found = measured(episodes, scenes, spacing)
    spacings = {method: values / found["Random"] - 1 for method, values in found.items() if method != "Random"}
    printed(
        "Distance to the nearest captured view, per cent of Random's more",
        {method: 100 * values for method, values in spacings.items()},
        names,
        "%+.0f",
    )
    pairs = np.array([[gains[m][s].mean(), spacings[m][s].mean()] for m in gains for s in range(len(names))])
    print(f"\nSpearman's rho of the two over methods and scenes: {spearmanr(*pairs.T).statistic:+.2f}")
    scored = ("oracle-ssim", "oracle-psnr", "ours-lite0", "statistics", "fisherrf")
    kept = measured(episodes, scenes, lambda _, episode: persistence(episode), scored)
    printed(f"Rho between the scores of a moment and of {LATER} captures later", kept, names, "%.2f")
    if told.figure:
        drawn(gains, spacings, names, told.figure)


if __name__ == "__main__":
    main()

"""Train variants of one scorer on the data of a run, and print how each orders the candidates of a moment.

    python -m tests.benchmarks.scorer_variants RESULTS SCORER --training NAMES --held-out NAMES
        --variant NAME training.steps=800 training.crop=154 ... --seeds 0 1 2

RESULTS is the folder of a run that has distortion data of the data sets in NAMES (with commas between); ``NAME/SCENE``
is one scene. Beginning with the run's own settings of SCORER, each variant changes some. Printed is Spearman's rho of
the scores and the true SSIM among the candidates of a moment, mean over moments, of every held-out scene; then the
mean of each held-out data set with its standard error over scenes; both are means over seeds.
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml
from scipy.stats import spearmanr

from avs.config.scorer_jobs import TrainingJob
from avs.iqa.cross_reference.distortions import read_distortions
from avs.iqa.cross_reference.scorer_checkpoint import load_network
from avs.iqa.cross_reference.scorer_settings import ScorerSettings
from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer
from avs.iqa.cross_reference.training import train
from avs.iqa.held_out.held_out_settings import ReferencesVariant
from avs.iqa.held_out.reference_variants import predict_variants
from avs.system.records import read_settings

LEAST_CANDIDATES = 3


def within_moments(data, scores):
    """Return the mean over moments of rho between scores and true SSIM among the candidates of each."""
    moments, candidates = np.array(data.moment_of), data.candidates
    found = []
    for moment in np.unique(moments):
        rows = (moments == moment) & candidates
        if rows.sum() >= LEAST_CANDIDATES:
            found.append(spearmanr(scores[rows], data.similarity[rows]).statistic)
    return float(np.mean(found))


def candidates_of(data):
    """Return distortion data without the renderings of views that were captured at their moment."""
    rows = np.flatnonzero(data.candidates)
    taken = {
        name: tuple(getattr(data, name)[row] for row in rows) for name in ("renderings", "maps", "images", "moment_of")
    }
    return replace(data, **taken, geometry=data.geometry[rows])


def changed(settings, changes, seed):
    """Return settings of a scorer with ``section.key=value`` laid over them."""
    told = settings.model_dump(mode="json") | {"seed": seed}
    for change in changes:
        path, _, value = change.partition("=")
        *sections, key = path.split(".")
        place = told
        for section in sections:
            place = place[section]
        place[key] = yaml.safe_load(value)
    return ScorerSettings.model_validate(told)


def files_of(results, names):
    """Return the distortion data of data sets, or of single scenes of them."""
    folder = results / "distortions"
    found = [[folder / f"{name}.safetensors"] if "/" in name else sorted((folder / name).iterdir()) for name in names]
    return [path for paths in found for path in paths]


def agreements(training, held_out, settings, batch):
    """Train a scorer, and return its rho of each held-out scene by data set and scene, and the seconds of training."""
    with TemporaryDirectory() as folder:
        weights = Path(folder, "weights.safetensors")
        start = time.process_time()
        train(training, held_out, weights, weights.with_name("card.json"), settings, print)
        seconds = time.process_time() - start
        network = load_network(weights, settings.network.backbone)
    scorer = CrossReferenceScorer(network, settings.training.resize, batch, "cpu", "float32")
    references = settings.training.references
    own = {"": ReferencesVariant(count=references.count, choice=references.choice)}
    found = {}
    for path in held_out:
        data = candidates_of(read_distortions(path))
        found[f"{path.parent.name}/{path.stem}"] = within_moments(
            data, predict_variants(scorer, data, data, own)[""].scores
        )
    return found, seconds


def told(name, found, seconds):
    """Print the means over seeds of one variant."""
    means = {scene: float(np.mean([each[scene] for each in found])) for scene in found[0]}
    print(f"{name}: {len(found)} seeds, {np.mean(seconds):.0f} s of processor time a training")
    for scene, value in means.items():
        seeds = " ".join(f"{each[scene]:.2f}" for each in found)
        print(f"    {scene:32} {value:.2f}   ({seeds})")
    for dataset in dict.fromkeys(scene.split("/")[0] for scene in means):
        values = [value for scene, value in means.items() if scene.split("/")[0] == dataset]
        error = f" +- {np.std(values, ddof=1) / np.sqrt(len(values)):.2f}" if len(values) > 1 else ""
        print(f"  {dataset:34} {np.mean(values):.2f}{error}", flush=True)


def main():
    """Read the command line, and print the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", type=Path)
    parser.add_argument("scorer")
    parser.add_argument("--training", required=True)
    parser.add_argument("--held-out", required=True)
    parser.add_argument("--variant", nargs="+", action="append", metavar=("NAME", "KEY=VALUE"))
    parser.add_argument("--seeds", nargs="+", type=int, default=[0])
    parser.add_argument("--batch", type=int, default=8)
    options = parser.parse_args()
    job = read_settings(options.results / "settings" / "scorer_train" / f"{options.scorer}.json", TrainingJob)
    training = files_of(options.results, options.training.split(","))
    held_out = files_of(options.results, options.held_out.split(","))
    for name, *changes in options.variant or [["as it is"]]:
        runs = [
            agreements(training, held_out, changed(job.scorer, changes, seed), options.batch) for seed in options.seeds
        ]
        told(name, [found for found, _ in runs], [seconds for _, seconds in runs])


if __name__ == "__main__":
    main()

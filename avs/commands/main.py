"""One command per step of the workflow, usable by hand; nothing but argument handling.

Rules pass every path that a command reads or writes. ``python -m avs COMMAND --help`` tells the arguments.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from avs.system.compatibility import limit_threads, prepare_environment
from avs.system.jobs import die_with_parent, job

HELP = "Active view selection. One command per step of the workflow; every path is an argument."

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False, help=HELP)
scorer = typer.Typer(no_args_is_help=True, help="Train the cross-reference scorer.")
weights = typer.Typer(no_args_is_help=True, help="Pretrained weights from elsewhere: list, fetch, check.")
app.add_typer(scorer, name="scorer")
app.add_typer(weights, name="weights")
niqe = typer.Typer(no_args_is_help=True, help="The quality metric NIQE.")
app.add_typer(niqe, name="niqe")

runtime = typer.Typer(no_args_is_help=True, help="Time the selections of each method.")
app.add_typer(runtime, name="runtime")

Device = Literal["cpu", "cuda"]
Log = Annotated[Path | None, typer.Option(help="file for everything that is printed")]
SettingsFile = Annotated[Path, typer.Option(help="settings, a JSON file written by the workflow")]
Out = Annotated[Path, typer.Option(help="what to write")]


def main() -> None:
    """Run the command line."""
    die_with_parent()
    prepare_environment()
    app()


@app.command()
def settings(values: Annotated[str, typer.Argument(help="JSON")], out: Out, log: Log = None) -> None:
    """Write a part of the configuration to a file, for the commands that read it."""
    from avs.system.files import write_json

    with job(log):
        write_json(out, json.loads(values))


@app.command()
def kernels(log: Log = None) -> None:
    """Compile the CPU kernels, so that no episode has to."""
    from avs.representations.gaussians.compilation import compile_kernels

    with job(log):
        limit_threads()
        compile_kernels()


@app.command()
def embedded(pattern: str, seed: int, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Make an embedded scene."""
    from avs.datasets.embedded import make_scene
    from avs.datasets.embedded.embedded_settings import EmbeddedSettings

    with job(log):
        make_scene(pattern, seed, EmbeddedSettings.model_validate(_read(settings)), out)


@app.command()
def capture(source: Path, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Turn a folder in COLMAP layout into a scene."""
    from avs.datasets.capture_settings import CaptureSettings
    from avs.datasets.captures import prepare

    with job(log):
        prepare(source, out, CaptureSettings.model_validate(_read(settings)))


@scorer.command()
def distortions(scene: Path, seed: int, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Fit a training scene and keep renderings of it with their SSIM maps."""
    from avs.iqa.cross_reference.renders import RenderJob, make_renders

    with job(log) as console:
        limit_threads()
        make_renders(scene, out, RenderJob.model_validate(_read(settings)), seed, console.progress)


@scorer.command()
def train(
    settings: SettingsFile,
    weights: Annotated[Path, typer.Option(help="checkpoint to write")],
    card: Annotated[Path, typer.Option(help="model card to write")],
    training: Annotated[list[Path], typer.Option(help="renderings of a training scene")],
    held_out: Annotated[list[Path], typer.Option(help="renderings of a scene that only measures")],
    log: Log = None,
) -> None:
    """Train the scorer on renderings."""
    from avs.iqa.cross_reference.scorer_settings import ScorerSettings
    from avs.iqa.cross_reference.training import train as run

    with job(log) as console:
        limit_threads()
        values = _read(settings)
        checked = ScorerSettings.model_validate(values["scorer"])
        run(training, held_out, weights, card, checked, console.progress, values["device"])


@app.command()
def episode(
    scene: Path,
    seed: int,
    settings: SettingsFile,
    out: Out,
    weights: Annotated[Path | None, typer.Option(help="checkpoint of the scorer that the method needs")] = None,
    views: Annotated[Path | None, typer.Option(help="views.json of a method that is a program of its own")] = None,
    log: Log = None,
) -> None:
    """Run one episode: one method on one scene with one seed."""
    from avs.nvs.experiment import EpisodeSettings, run_episode

    with job(log) as console:
        limit_threads()
        checked = EpisodeSettings.model_validate(_read(settings))
        run_episode(scene, checked, seed, weights, out, console.progress, views)


@app.command()
def replay(scene: Path, episode: Path, out: Out, device: Device = "cpu", log: Log = None) -> None:
    """Run an episode again on the views that its record lists."""
    from avs.nvs.experiment import replay_episode

    with job(log) as console:
        limit_threads()
        replay_episode(scene, episode, device, out, console.progress)


@app.command()
def table(
    episodes: list[Path],
    dataset: Annotated[str, typer.Option(help="data set whose episodes these are")],
    settings: SettingsFile,
    out: Annotated[Path, typer.Option(help="path of the tables without suffix")],
    log: Log = None,
) -> None:
    """Write the view selection table of a data set as csv, md and tex."""
    from avs.report.tables.view_synthesis import write_nvs_table

    with job(log):
        values = _read(settings)
        published = None if values["published"] is None else Path(values["published"])
        write_nvs_table(episodes, values["methods"], dataset, published, out, values["absent"])


@app.command()
def ranking(
    episodes: list[Path],
    dataset: Annotated[str, typer.Option(help="data set whose episodes these are")],
    settings: SettingsFile,
    out: Annotated[Path, typer.Option(help="path of the tables without suffix")],
    log: Log = None,
) -> None:
    """Write how well each method's scores rank the candidates of a data set, as csv, md and tex."""
    from avs.report.tables.ranking_table import write_ranking_table

    with job(log):
        values = _read(settings)
        write_ranking_table(episodes, values["methods"], dataset, out, values["absent"])


@app.command()
def figure(
    episodes: list[Path],
    settings: SettingsFile,
    out: Annotated[Path, typer.Option(help="path of the figure without suffix")],
    log: Log = None,
) -> None:
    """Draw the test PSNR over the number of captured views."""
    from avs.report.figures.psnr_over_views import write_psnr_over_views

    with job(log):
        write_psnr_over_views(episodes, _read(settings)["methods"], out)


@runtime.command("state")
def runtime_state(scene: Path, settings: SettingsFile, out: Out, log: Log = None) -> None:
    """Fit the reconstruction that methods are timed on."""
    from avs.nvs.timing import StateSettings, write_state

    with job(log):
        limit_threads()
        write_state(scene, StateSettings.model_validate(_read(settings)), out)


@runtime.command("measure")
def runtime_measure(
    scene: Path,
    state: Annotated[Path, typer.Option(help="checkpoint of the reconstruction")],
    settings: SettingsFile,
    out: Out,
    weights: Annotated[Path | None, typer.Option(help="checkpoint of the scorer that the method needs")] = None,
    log: Log = None,
) -> None:
    """Time the selections of one method; nothing else should run meanwhile."""
    from avs.nvs.timing import TimingSettings, time_method

    with job(log) as console:
        limit_threads()
        time_method(scene, state, TimingSettings.model_validate(_read(settings)), weights, out, console.progress)


@runtime.command("table")
def runtime_table(
    records: list[Path],
    settings: SettingsFile,
    out: Annotated[Path, typer.Option(help="path of the tables without suffix")],
    episode: Annotated[list[Path] | None, typer.Option(help="an episode on the scene, for the PSNR")] = None,
    published: Annotated[list[Path] | None, typer.Option(help="a file of results/published")] = None,
    log: Log = None,
) -> None:
    """Write the table of selection times as csv, md and tex."""
    from avs.report.tables.runtime_table import write_runtime_table

    with job(log):
        values = _read(settings)
        write_runtime_table(records, episode or [], values["methods"], values["absent"], published or [], out)


@app.command()
def schemas(out: Path = Path("workflows/schemas")) -> None:
    """Generate the JSON schemas of the configuration, the scene file and the records."""
    from avs.config.schemas import write_schemas

    with job(None):
        write_schemas(out)


@weights.command("list")
def list_weights() -> None:
    """List the pretrained weights: whence, how large, whose licence, used by which method, whether they are here."""
    from avs.system.weights.inventory import listing

    with job(None):
        print("\n".join(listing()))


@weights.command("fetch")
def fetch_weights(names: Annotated[list[str], typer.Argument(help="names that `avs weights list` shows")]) -> None:
    """Download pretrained weights into the cache folder and verify them; the only command that uses the network."""
    from avs.system.weights.download import fetch

    with job(None):
        for name in names:
            fetch(name, print)


@weights.command("check")
def check_weights(
    names: Annotated[list[str] | None, typer.Argument(help="weights that must be here; default: all that are")] = None,
) -> None:
    """Compare the weights on this machine with the manifest, and read them; exit status 2 if one is bad."""
    from avs.system.weights.inventory import check

    with job(None):
        check(names or [], print)


@niqe.command("fit")
def fit_niqe(
    scenes: Annotated[list[Path], typer.Argument(help="folders of scenes, none of which is evaluated")],
    out: Out,
    settings: Annotated[Path | None, typer.Option(help="settings, a JSON file written by the workflow")] = None,
    log: Log = None,
) -> None:
    """Fit NIQE's parameters on photographs, where the published ones are absent."""
    from avs.iqa.no_reference.niqe_fit import fit_scenes
    from avs.iqa.no_reference.niqe_settings import FitSettings

    with job(log) as console:
        limit_threads()
        checked = FitSettings.model_validate({} if settings is None else _read(settings))
        fit_scenes(scenes, checked, out, console.progress)


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def resume(context: typer.Context) -> None:
    """Complete a killed run: unlock, unless a run is alive, then call snakemake with the arguments that follow."""
    from avs.system.resume import resume as run

    with job(None):
        run(context.args)


def _read(path: Path) -> Any:  # noqa: ANN401 - the JSON is checked by the models that take it
    return json.loads(path.read_text(encoding="utf-8"))

# Active SLAM: one exploration per building, method and seed.

from avs.config.method_weights import files_read_exploring
from avs.config.paper_tables import FOLDER
from avs.config.slam_config import explorers
from avs.config.slam_jobs import absent_buildings, absent_explorers, explored
from avs.report.published import SLAM_NAME
from avs.slam.building.side_files import side_files

SLAM = f"{RESULTS}/slam/{{building}}"
EXPLORATION = f"{SLAM}/{{method}}/{{seed}}/exploration.json"


wildcard_constraints:
    building="[a-z0-9_]+",


# No exploration is asked for of a method that cannot run here, nor in a building that cannot be read; the table says why.
# Without a method, or without a building, there is none at all.
UNREAD = absent_buildings(settings)
UNABLE = absent_explorers(settings)
EXPLORED = explored(settings)
BUILDINGS = list(EXPLORED)
EXPLORING = EXPLORED[BUILDINGS[0]] if BUILDINGS else []

for name, reason in UNREAD.items() if workflow.is_main_process else ():
    print(f"left out of slam.buildings: {name}: {reason}", file=sys.stderr)

if (
    workflow.is_main_process
    and settings.slam
    and settings.slam.buildings
    and not BUILDINGS
):
    why = "; ".join(f"{name}: {each}" for name, each in (UNABLE | UNREAD).items())
    print(f"left out: slam: nothing can be explored here ({why})", file=sys.stderr)


def building_file(wildcards):
    """Return the mesh of a building: an embedded flat's, which a rule makes, or a file of the user's."""
    building = settings.slam.buildings[wildcards.building]
    return (
        f"{SLAM}/building/mesh.ply" if building.source == "apartment" else building.file
    )


def building_side_files(wildcards):
    """Return the files that the mesh of a building names, such as textures."""
    if wildcards.building in UNREAD:
        return []
    return list(map(str, side_files(Path(building_file(wildcards)))))


def explorer(method):
    """Return the identifier of the method of Task A that chooses paths under this name, or None."""
    told = explorers(settings.slam).get(method)
    return None if told is None else told.method


def exploration_weights(wildcards):
    method = explorer(wildcards.method)
    return [] if method is None else weights_of_method(method)


def exploration_downloads(wildcards):
    """Return the published weights on this machine, and files that settings name, that a method of Task A reads."""
    return list(map(str, files_read_exploring(settings, wildcards.method)))


def exploration_code(wildcards):
    """Return the source files of an exploration, and those of the method of Task A that chooses its paths, if any."""
    method = explorer(wildcards.method)
    own = [] if method is None else [registry.find(method).module]
    return sources("avs.slam.loop.exploration_run", *own)


def explorations(path, buildings=None, seeds=None):
    """Return the files at ``path`` of explorations, in order of building, method and seed."""
    if not BUILDINGS:
        return []
    return expand(
        path,
        building=buildings or BUILDINGS,
        method=EXPLORING,
        seed=seeds or settings.slam.seeds,
    )


def all_explorations(wildcards):
    return explorations(EXPLORATION)


def mapped_explorations(file):
    """Return the function that gives the files of this name of all methods, in one building with the first seed."""

    def files(wildcards):
        path = EXPLORATION.replace("exploration.json", file)
        return explorations(path, [wildcards.building], settings.slam.seeds[:1])

    return files


def slam_tables(wildcards):
    """Return the table of explorations and their figures where the target ``tables`` is to make them, too."""
    return (
        exploration_tables(wildcards) if BUILDINGS and settings.slam.with_tables else []
    )


def exploration_tables(wildcards):
    """Return the table of explorations and their figures, for the target ``explore``."""
    if not BUILDINGS:
        return []
    maps = expand(
        f"{RESULTS}/figures/slam_maps_{{building}}.pdf",
        building=BUILDINGS,
    )
    shown = expand(
        f"{RESULTS}/figures/slam_{{building}}_{{method}}_{{seed}}.gif",
        building=BUILDINGS[:1],
        method=EXPLORING[-1:],
        seed=settings.slam.seeds[:1],
    )
    return [
        f"{RESULTS}/tables/active_slam.csv",
        f"{RESULTS}/figures/slam_over_steps.pdf",
        *maps,
        *shown,
    ]


def maps_options(wildcards, input):
    return repeated("--maps", input.maps)


rule building:
    input:
        settings=f"{RESULTS}/settings/building/{{building}}.json",
        code=sources("avs.datasets.embedded.apartment"),
    output:
        mesh=f"{SLAM}/building/mesh.ply",
        rooms=f"{SLAM}/building/apartment.json",
    log:
        f"{SLAM}/building.log".replace(RESULTS, LOGS),
    priority: 2  # all explorations of the building wait for it
    params:
        made_of=made_of,
        folder=subpath(output.mesh, parent=True),
    message:
        "building {wildcards.building}"
    shell:
        "{AVS} --made-of {params.made_of} building"
        " --settings {input.settings} --out {params.folder} --log {log}"


rule exploration:
    input:
        mesh=building_file,
        beside=building_side_files,
        weights=exploration_weights,
        downloads=exploration_downloads,
        kernels=KERNELS.format(kind="gaussians"),  # what maps are made of
        settings=f"{RESULTS}/settings/exploration/{{building}}/{{method}}.json",
        code=exploration_code,
    output:
        record=EXPLORATION,
        meta=EXPLORATION.replace(".json", ".meta.json"),
        maps=EXPLORATION.replace("exploration.json", "maps.safetensors"),
    log:
        EXPLORATION.replace(RESULTS, LOGS).replace("/exploration.json", ".log"),
    priority: 1  # longer than an episode
    params:
        made_of=made_of,
        mesh=lambda wildcards, input: shlex.quote(str(input.mesh)),
        weights=weights_option,
        folder=subpath(output.record, parent=True),
    message:
        "exploration of {wildcards.building} by {wildcards.method}, seed {wildcards.seed}"
    shell:
        "{AVS} --made-of {params.made_of} exploration"
        " {params.mesh} {wildcards.building} {wildcards.method} {wildcards.seed} --settings {input.settings}"
        " {params.weights} --out {params.folder} --log {log}"


rule active_slam:
    input:
        records=all_explorations,
        settings=f"{RESULTS}/settings/slam_figure.json",
        published=f"{FOLDER}/{SLAM_NAME}",
        code=sources("avs.report.tables.active_slam"),
    output:
        multiext(
            f"{RESULTS}/tables/active_slam",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_per_run.csv",
            "_curves.csv",
        ),
    log:
        f"{LOGS}/tables/active_slam.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "table of active SLAM"
    shell:
        "{AVS} --made-of {params.made_of} active_slam"
        " {input.records} --settings {input.settings} --published {input.published}"
        " --out {params.stem} --log {log}"


rule slam_maps:
    input:
        records=mapped_explorations("exploration.json"),
        maps=mapped_explorations("maps.safetensors"),
        code=sources("avs.report.figures.slam_maps"),
    output:
        multiext(f"{RESULTS}/figures/slam_maps_{{building}}", ".pdf", ".png"),
    log:
        f"{LOGS}/figures/slam_maps_{{building}}.log",
    params:
        made_of=made_of,
        maps=maps_options,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: maps of explorations of {wildcards.building}"
    shell:
        "{AVS} --made-of {params.made_of} slam_maps"
        " {input.records} {params.maps} --out {params.stem} --log {log}"


rule slam_animation:
    input:
        record=EXPLORATION,
        maps=EXPLORATION.replace("exploration.json", "maps.safetensors"),
        mesh=building_file,
        beside=building_side_files,
        code=sources("avs.report.figures.slam_animation"),
    output:
        f"{RESULTS}/figures/slam_{{building}}_{{method}}_{{seed}}.gif",
    log:
        f"{LOGS}/figures/slam_{{building}}_{{method}}_{{seed}}.log",
    params:
        made_of=made_of,
        mesh=lambda wildcards, input: shlex.quote(str(input.mesh)),
    message:
        "animation of the exploration of {wildcards.building} by {wildcards.method}"
    shell:
        "{AVS} --made-of {params.made_of} slam_animation"
        " {input.record} --maps {input.maps} --mesh {params.mesh} --out {output} --log {log}"


rule slam_over_steps:
    input:
        records=all_explorations,
        settings=f"{RESULTS}/settings/slam_figure.json",
        code=sources("avs.report.figures.slam_over_steps"),
    output:
        multiext(f"{RESULTS}/figures/slam_over_steps", ".pdf", ".png"),
    log:
        f"{LOGS}/figures/slam_over_steps.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: coverage over the actions of a robot"
    shell:
        "{AVS} --made-of {params.made_of} slam_over_steps"
        " {input.records} --settings {input.settings} --out {params.stem} --log {log}"


localrules:
    explore,


if BUILDINGS:

    rule explore:
        input:
            exploration_tables,

elif settings.slam and settings.slam.buildings:

    rule explore:
        shell:
            "echo 'error: configuration: slam: nothing can be explored here, as a line above says why;"
            " add a method, such as nearest, or a building that can be read' >&2; exit 2"

else:

    rule explore:
        shell:
            "echo 'error: configuration: slam: no building is named; add one (docs/active-slam.md)' >&2; exit 2"

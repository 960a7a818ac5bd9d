# Coverage of the scene by the views of each episode, in structure from motion: one reference per scene, the cloud of all
# its views, and one job per episode, which holds the cloud of its views against it.

from avs.config.jobs import coverage_lacking
from avs.config.method_weights import files_read_by_back_end
from avs.config.scenes import scene_named
from avs.report.published import COVERAGE_NAME
from avs.sfm.back_end_registry import find as find_back_end

COVERAGE_FOLDER = f"{RESULTS}/coverage/{{dataset}}/{{scene}}"
REFERENCE = f"{COVERAGE_FOLDER}/reference"
COVERAGE = f"{COVERAGE_FOLDER}/{{method}}/{{seed}}"

# The data sets with coverage.
COVERED = settings.with_table("coverage")

# Without its back end nothing is measured; the table says why.
MEASURES_COVERAGE = settings.coverage is not None and coverage_lacking(settings) is None


def mapped_scene():
    """Return the data set and the scene of the maps: by default the first of the first data set with coverage."""
    wanted = settings.coverage.scene
    first = COVERED[0] if COVERED else None
    wanted = wanted or (f"{first}/{SCENES[first][0]}" if first else None)
    try:
        return scene_named(settings, wanted, "coverage.scene")
    except UserError as error:
        sys.exit(f"error: {error}")


# Says that the kernels of dense stereo, which no other back end has, have been compiled here.
STEREO_KERNELS = f"{RESULTS}/stereo_kernels"
COMPILED = (
    [STEREO_KERNELS]
    if settings.coverage is not None and settings.coverage.sfm.back_end == "dense"
    else []
)


def back_end_code(*modules):
    """Return the source files of these modules and of the back end."""
    if settings.coverage is None:
        return []
    back_end = find_back_end(settings.coverage.sfm.back_end)
    return sources(*modules, back_end.module)


# What the back end reads on this machine, such as the weights of its network.
BACK_END_FILES = list(map(str, files_read_by_back_end(settings)))


def coverages(path, dataset, scenes=None, methods=None, seeds=None):
    """Return the files at ``path`` of the coverage of episodes, in order of method, scene and seed."""
    if not MEASURES_COVERAGE:
        return []
    return expand(
        path,
        dataset=dataset,
        method=methods or RUNNABLE[dataset],
        scene=scenes or SCENES[dataset],
        seed=seeds or settings.seeds,
    )


def dataset_coverages(wildcards):
    return coverages(f"{COVERAGE}/coverage.json", wildcards.dataset)


def covered_episodes(wildcards):
    return [path for dataset in COVERED for path in episodes(dataset)]


def all_coverages(wildcards):
    return [
        path
        for dataset in COVERED
        for path in coverages(f"{COVERAGE}/coverage.json", dataset)
    ]


def mapped(file):
    """Return the function that gives the files of this name of all methods, of the scene of the maps and the first seed."""

    def files(wildcards):
        dataset, scene = mapped_scene()
        return coverages(
            f"{COVERAGE}/{file}", dataset, [scene], seeds=settings.seeds[:1]
        )

    return files


def mapped_scene_file(wildcards):
    dataset, scene = mapped_scene()
    return SCENE.format(dataset=dataset, scene=scene)


def coverage_options(wildcards, input):
    return repeated("--coverage", input.records)


def covered_options(wildcards, input):
    return repeated("--covered", input.covered)


def coverage_tables(wildcards):
    """Return the coverage table of each data set, unless the configuration leaves it out."""
    return expand(f"{RESULTS}/tables/coverage_{{dataset}}.csv", dataset=COVERED)


def coverage_figures(wildcards):
    """Return the figures of coverage, if it can be measured."""
    if not MEASURES_COVERAGE or not COVERED:
        return []
    return expand(
        f"{RESULTS}/figures/{{figure}}.pdf",
        figure=["coverage_maps", "coverage_over_views"],
    )


rule stereo_kernels:
    input:
        code=sources("avs.sfm.stereo_compilation"),
    output:
        touch(STEREO_KERNELS),
    log:
        f"{LOGS}/stereo_kernels.log",
    message:
        "compilation of the kernels of dense stereo"
    shell:
        "{AVS} stereo_kernels --log {log}"


rule coverage_reference:
    input:
        scene=SCENE,
        kernels=COMPILED,
        weights=BACK_END_FILES,
        settings=f"{RESULTS}/settings/coverage_reference.json",
        code=back_end_code("avs.coverage.reference_cloud"),
    output:
        record=f"{REFERENCE}/reference.json",
        meta=f"{REFERENCE}/reference.meta.json",
        cloud=f"{REFERENCE}/reference.ply",
        surface=f"{REFERENCE}/surface.ply",
    log:
        f"{REFERENCE}.log".replace(RESULTS, LOGS),
    priority: 1  # all coverage of the scene waits for it
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        folder=subpath(output.record, parent=True),
    message:
        "cloud of all views of {wildcards.scene} of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} coverage_reference"
        " {params.scene} --settings {input.settings} --out {params.folder} --log {log}"


rule coverage:
    input:
        scene=SCENE,
        episode=EPISODE,
        reference=f"{REFERENCE}/reference.json",
        clouds=[f"{REFERENCE}/reference.ply", f"{REFERENCE}/surface.ply"],
        kernels=COMPILED,
        weights=BACK_END_FILES,
        settings=f"{RESULTS}/settings/coverage.json",
        code=back_end_code("avs.coverage.episode_coverage"),
    output:
        record=f"{COVERAGE}/coverage.json",
        meta=f"{COVERAGE}/coverage.meta.json",
        cloud=f"{COVERAGE}/cloud.ply",
        covered=f"{COVERAGE}/covered.ply",
        surface=f"{COVERAGE}/covered_surface.ply",
    log:
        f"{COVERAGE}.log".replace(RESULTS, LOGS),
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        reference=subpath(input.reference, parent=True),
        folder=subpath(output.record, parent=True),
    message:
        "coverage: {wildcards.method} on {wildcards.scene} of {wildcards.dataset}, seed {wildcards.seed}"
    shell:
        "{AVS} --made-of {params.made_of} coverage"
        " {params.scene} {input.episode} --reference {params.reference} --settings {input.settings}"
        " --out {params.folder} --log {log}"


rule coverage_table:
    input:
        episodes=dataset_episodes,
        records=dataset_coverages,
        settings=f"{RESULTS}/settings/coverage_table/{{dataset}}.json",
        published=f"results/published/{COVERAGE_NAME}",
        code=sources("avs.report.tables.scene_coverage"),
    output:
        multiext(
            f"{RESULTS}/tables/coverage_{{dataset}}",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_per_scene.csv",
            "_differences.csv",
            "_agreement.csv",
        ),
    log:
        f"{LOGS}/tables/coverage_{{dataset}}.log",
    params:
        made_of=made_of,
        records=coverage_options,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "coverage of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} coverage_table"
        " {input.episodes} {params.records} --dataset {wildcards.dataset} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule coverage_maps:
    input:
        scene=mapped_scene_file,
        records=mapped("coverage.json"),
        covered=mapped("covered.ply"),
        settings=f"{RESULTS}/settings/coverage_maps.json",
        code=sources("avs.report.figures.coverage_maps"),
    output:
        multiext(f"{RESULTS}/figures/coverage_maps", ".pdf", ".png", ".md"),
    log:
        f"{LOGS}/figures/coverage_maps.log",
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        covered=covered_options,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: maps of coverage"
    shell:
        "{AVS} --made-of {params.made_of} coverage_maps"
        " {params.scene} {input.records} {params.covered} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule coverage_over_views:
    input:
        episodes=covered_episodes,
        records=all_coverages,
        settings=f"{RESULTS}/settings/coverage_over_views.json",
        code=sources("avs.report.figures.coverage_over_views"),
    output:
        multiext(f"{RESULTS}/figures/coverage_over_views", ".pdf", ".png", ".md"),
    log:
        f"{LOGS}/figures/coverage_over_views.log",
    params:
        made_of=made_of,
        records=coverage_options,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: coverage over views"
    shell:
        "{AVS} --made-of {params.made_of} coverage_over_views"
        " {input.episodes} {params.records} --settings {input.settings} --out {params.stem} --log {log}"

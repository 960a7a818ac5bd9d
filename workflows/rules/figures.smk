# Figures, from records and what lies beside them.

from avs.report.figures.shown_methods import shown_scenes


def row_scenes():
    """Return the data sets and scenes that a figure with one row for each scene shows."""
    return shown_scenes(SCENES, settings.report.figures.rows)


def first_episodes(dataset, scene):
    """Return the records of all methods on a scene with the first seed."""
    return expand(
        EPISODE,
        dataset=dataset,
        scene=scene,
        method=RUNNABLE[dataset],
        seed=min(settings.seeds),
    )


def pictures_of(records):
    """Return the pictures that lie beside records of episodes."""
    return [path.replace("episode.json", PICTURES) for path in records]


def row_scene_files(wildcards):
    return [SCENE.format(dataset=dataset, scene=scene) for dataset, scene in row_scenes()]


def row_pictures(wildcards):
    return [path for pair in row_scenes() for path in pictures_of(first_episodes(*pair))]


def scene_options(wildcards, input):
    """Return the folders of the scenes of a figure as options."""
    files = [input.scenes] if isinstance(input.scenes, str) else input.scenes
    return repeated("--scene", [Path(path).parent for path in files])

rule psnr_over_views:
    input:
        episodes=all_episodes,
        settings=f"{RESULTS}/settings/psnr_over_views.json",
        code=sources("avs.report.figures.psnr_over_views"),
    output:
        multiext(f"{RESULTS}/figures/psnr_over_views", ".pdf", ".png"),
    log:
        f"{LOGS}/figures/psnr_over_views.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: PSNR over views"
    shell:
        "{AVS} --made-of {params.made_of} psnr_over_views"
        " {input.episodes} --settings {input.settings} --out {params.stem} --log {log}"


rule qualitative:
    input:
        episodes=all_episodes,
        pictures=row_pictures,
        scenes=row_scene_files,
        settings=f"{RESULTS}/settings/qualitative.json",
        code=sources("avs.report.figures.qualitative"),
    output:
        multiext(f"{RESULTS}/figures/qualitative", ".pdf", ".png", ".md"),
    log:
        f"{LOGS}/figures/qualitative.log",
    params:
        made_of=made_of,
        scenes=scene_options,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: renderings of several methods"
    shell:
        "{AVS} --made-of {params.made_of} qualitative"
        " {input.episodes} {params.scenes} --settings {input.settings} --out {params.stem} --log {log}"


rule figures:
    input:
        f"{RESULTS}/figures/psnr_over_views.pdf",
        f"{RESULTS}/figures/qualitative.pdf",
        coverage_figures,
        CRITICAL_DIFFERENCES,

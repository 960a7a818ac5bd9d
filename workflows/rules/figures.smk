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
    return [
        SCENE.format(dataset=dataset, scene=scene) for dataset, scene in row_scenes()
    ]


def row_pictures(wildcards):
    return [
        path for pair in row_scenes() for path in pictures_of(first_episodes(*pair))
    ]


def first_scene_file(wildcards):
    """Return the scene of a data set that figures of one scene show: its first."""
    return SCENE.replace("{scene}", SCENES[wildcards.dataset][0])


def first_scene_episodes(wildcards):
    return first_episodes(wildcards.dataset, SCENES[wildcards.dataset][0])


def first_scene_pictures(wildcards):
    return pictures_of(first_scene_episodes(wildcards))


def first_scene(wildcards):
    return SCENES[wildcards.dataset][0]


def of_each_data_set(name):
    """Return the figures of a name of all data sets."""
    return expand(f"{RESULTS}/figures/{name}_{{dataset}}.pdf", dataset=SCENES)


def timed_metas(wildcards):
    """Return what lies beside the records on the scene on which selections are timed: the times of all selections."""
    return [
        path.replace("episode.json", "episode.meta.json")
        for path in timed_episodes(wildcards)
    ]


def teasers(wildcards):
    """Return the figure of selection times and PSNR, unless no method is timed."""
    return (
        [] if settings.runtime is None or not TIMED else f"{RESULTS}/figures/teaser.pdf"
    )


def compared_scenes():
    """Return the first scene of the egocentric data set and of that of phones; nothing where one of them is lacking."""
    kinds = (settings.report.figures.egocentric, settings.report.figures.phone)
    found = [[name for name in names if name in SCENES][:1] for names in kinds]
    names = [name for each in found for name in each]
    return [(name, SCENES[name][0]) for name in names] if all(found) else []


COMPARED_SCENES = [
    SCENE.format(dataset=dataset, scene=scene) for dataset, scene in compared_scenes()
]


def compared_figures(wildcards):
    return f"{RESULTS}/figures/egocentric_and_phone.pdf" if COMPARED_SCENES else []


def scene_options(wildcards, input):
    """Return the folders of the scenes of a figure as options."""
    files = [input.scenes] if isinstance(input.scenes, str) else input.scenes
    return repeated("--scene", [Path(path).parent for path in files])


rule psnr_over_views:
    input:
        episodes=dataset_episodes,
        settings=f"{RESULTS}/settings/psnr_over_views/{{dataset}}.json",
        code=sources("avs.report.figures.psnr_over_views"),
    output:
        multiext(
            f"{RESULTS}/figures/psnr_over_views_{{dataset}}", ".pdf", ".png", ".md"
        ),
    log:
        f"{LOGS}/figures/psnr_over_views_{{dataset}}.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: PSNR over views of {wildcards.dataset}"
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


rule selected_cameras:
    input:
        scene=first_scene_file,
        episodes=first_scene_episodes,
        settings=f"{RESULTS}/settings/selected_cameras/{{dataset}}.json",
        code=sources("avs.report.figures.selected_cameras"),
    output:
        multiext(
            f"{RESULTS}/figures/selected_cameras_{{dataset}}", ".pdf", ".png", ".md"
        ),
    log:
        f"{LOGS}/figures/selected_cameras_{{dataset}}.log",
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: views that methods selected on {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} selected_cameras {params.scene} {input.episodes}"
        " --dataset {wildcards.dataset} --settings {input.settings} --out {params.stem} --log {log}"


rule score_maps:
    input:
        episodes=first_scene_episodes,
        pictures=first_scene_pictures,
        settings=f"{RESULTS}/settings/score_maps/{{dataset}}.json",
        code=sources("avs.report.figures.score_maps"),
    output:
        multiext(f"{RESULTS}/figures/score_maps_{{dataset}}", ".pdf", ".png", ".md"),
    log:
        f"{LOGS}/figures/score_maps_{{dataset}}.log",
    params:
        made_of=made_of,
        scene=first_scene,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: score maps on {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} score_maps {input.episodes} --dataset {wildcards.dataset}"
        " --scene {params.scene} --settings {input.settings} --out {params.stem} --log {log}"


rule teaser:
    input:
        records=timings,
        episodes=timed_episodes,
        settings=f"{RESULTS}/settings/teaser.json",
        code=sources("avs.report.figures.teaser"),
    output:
        multiext(f"{RESULTS}/figures/teaser", ".pdf", ".png", ".md"),
    log:
        f"{LOGS}/figures/teaser.log",
    params:
        made_of=made_of,
        episodes=episode_options,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: selection time against PSNR"
    shell:
        "{AVS} --made-of {params.made_of} teaser"
        " {input.records} {params.episodes} --settings {input.settings} --out {params.stem} --log {log}"


rule time_and_psnr:
    input:
        episodes=timed_episodes,
        metas=timed_metas,
        settings=f"{RESULTS}/settings/time_and_psnr.json",
        code=sources("avs.report.figures.time_and_psnr"),
    output:
        multiext(f"{RESULTS}/figures/time_and_psnr", ".pdf", ".png", ".md"),
    log:
        f"{LOGS}/figures/time_and_psnr.log",
    params:
        made_of=made_of,
        dataset=TIMED_SCENE[0],
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: time and PSNR over views"
    shell:
        "{AVS} --made-of {params.made_of} time_and_psnr"
        " {input.episodes} --dataset {params.dataset} --settings {input.settings} --out {params.stem} --log {log}"


if COMPARED_SCENES:

    rule egocentric_and_phone:
        input:
            scenes=COMPARED_SCENES,
            code=sources("avs.report.figures.egocentric_and_phone"),
        output:
            multiext(f"{RESULTS}/figures/egocentric_and_phone", ".pdf", ".png", ".md"),
        log:
            f"{LOGS}/figures/egocentric_and_phone.log",
        params:
            made_of=made_of,
            folders=[str(Path(path).parent) for path in COMPARED_SCENES],
            stem=subpath(output[0], strip_suffix=".pdf"),
        message:
            "figure: egocentric photographs and those of a phone"
        shell:
            "{AVS} --made-of {params.made_of} egocentric_and_phone {params.folders} --out {params.stem} --log {log}"


rule figures:
    input:
        of_each_data_set("psnr_over_views"),
        f"{RESULTS}/figures/qualitative.pdf",
        of_each_data_set("selected_cameras"),
        of_each_data_set("score_maps"),
        teasers,
        f"{RESULTS}/figures/time_and_psnr.pdf",
        compared_figures,
        coverage_figures,
        CRITICAL_DIFFERENCES,

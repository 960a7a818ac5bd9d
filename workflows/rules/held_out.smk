# How well scorers, metrics and plain numbers predict the SSIM of renderings of held-out scenes: one record a scene.

from avs.config.held_out_jobs import held_out_methods, held_out_scenes, other_scene

HELD_OUT = f"{RESULTS}/held_out/{{dataset}}/{{scene}}.json"
HELD_OUT_SCENES = held_out_scenes(settings)
HELD_OUT_METHODS = held_out_methods(settings)


def held_out_records(wildcards):
    """Return the records of all held-out scenes, in the order of the configuration."""
    return [
        HELD_OUT.format(dataset=dataset, scene=scene)
        for dataset, scenes in HELD_OUT_SCENES.items()
        for scene in scenes
    ]


def scorer_tables(wildcards):
    """Return the table of scorers, unless the configuration leaves it out or the run has none."""
    return [f"{RESULTS}/tables/scorer.csv"] if HELD_OUT_SCENES else []


def other_distortions(wildcards):
    dataset, scene = other_scene(settings, wildcards.dataset, wildcards.scene)
    return DISTORTIONS.format(dataset=dataset, scene=scene)


def held_out_code(wildcards):
    """Return the source files of what scores held-out renderings."""
    modules = [registry.find(method).module for method in HELD_OUT_METHODS]
    return sources("avs.iqa.held_out.held_out_scores", *modules)


def held_out_weights(wildcards):
    return list(weights_by_method(HELD_OUT_METHODS).values())


def held_out_downloads(wildcards):
    return downloads_of(HELD_OUT_METHODS)


def held_out_weights_options(wildcards):
    return weights_options(HELD_OUT_METHODS)


rule held_out_scores:
    input:
        data=DISTORTIONS,
        other=other_distortions,
        weights=held_out_weights,
        downloads=held_out_downloads,
        settings=f"{RESULTS}/settings/held_out_scores.json",
        code=held_out_code,
    output:
        record=HELD_OUT,
        meta=HELD_OUT.replace(".json", ".meta.json"),
    log:
        HELD_OUT.replace(RESULTS, LOGS).replace(".json", ".log"),
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        weights=held_out_weights_options,
    message:
        "scores of the renderings of {wildcards.scene} of {wildcards.dataset}, which is held out"
    shell:
        "{AVS} --made-of {params.made_of} held_out_scores"
        " {input.data} --other {input.other} --settings {input.settings} {params.weights}"
        " --out {output.record} --log {log}"


rule scorer_table:
    input:
        records=held_out_records,
        settings=f"{RESULTS}/settings/scorer_table.json",
        code=sources("avs.report.tables.scorer_agreement"),
    output:
        multiext(
            f"{RESULTS}/tables/scorer",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_per_scene.csv",
        ),
    log:
        f"{LOGS}/tables/scorer.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "table of scorers on held-out scenes"
    shell:
        "{AVS} --made-of {params.made_of} scorer_table"
        " {input.records} --settings {input.settings} --out {params.stem} --log {log}"

# The paper's tables in its layout: of single scenes, of two data sets, and of selection times.

from avs.config.paper_tables import side_by_side, with_memory
from avs.report.published import RUNTIME_NAMES


def summarised(wildcards):
    """Return the methods with a row in one of the paper's two tables of selection times."""
    if wildcards.summary == "detail":
        return TIMED
    return [each for each in with_memory(settings, TIMED_SCENE[0]) if each in TIMED]


def summarised_timings(wildcards):
    dataset, scene = TIMED_SCENE
    return expand(
        f"{RUNTIME}/{{method}}.json",
        dataset=dataset,
        scene=scene,
        method=summarised(wildcards),
    )


def summarised_episodes(wildcards):
    """Return the episodes of these methods on the scene on which selections are timed."""
    dataset, scene = TIMED_SCENE
    told = settings_of(settings, f"runtime_summary/{wildcards.summary}")
    return expand(
        EPISODE,
        dataset=dataset,
        scene=scene,
        method=[each for each in RUNNABLE[dataset] if each in told.methods],
        seed=settings.seeds,
    )


def published_scenes_files(wildcards):
    return list(settings_of(settings, f"scene_table/{wildcards.dataset}").published)


def side_by_side_episodes(wildcards):
    return [path for dataset in side_by_side(settings) for path in episodes(dataset)]


def side_by_side_published(wildcards):
    told = settings_of(settings, "side_by_side_table").data_sets
    return [each.published for each in told if each.published]


def paper_tables(wildcards):
    """Return the tables in the paper's layout that the others do not have."""
    scenes = expand(f"{RESULTS}/tables/scenes_{{dataset}}.csv", dataset=SCENES)
    both = [f"{RESULTS}/tables/re10k_mfr.csv"] if side_by_side(settings) else []
    return [*scenes, *both]


rule scene_table:
    input:
        episodes=dataset_episodes,
        settings=f"{RESULTS}/settings/scene_table/{{dataset}}.json",
        published=published_scenes_files,
        code=sources("avs.report.tables.scene_by_scene"),
    output:
        multiext(f"{RESULTS}/tables/scenes_{{dataset}}", ".csv", ".md", ".tex", ".json"),
    log:
        f"{LOGS}/tables/scenes_{{dataset}}.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "table of the scenes of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} scene_table"
        " {input.episodes} --dataset {wildcards.dataset} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule side_by_side_table:
    input:
        episodes=side_by_side_episodes,
        settings=f"{RESULTS}/settings/side_by_side_table.json",
        published=side_by_side_published,
        code=sources("avs.report.tables.data_sets_side_by_side"),
    output:
        multiext(f"{RESULTS}/tables/re10k_mfr", ".csv", ".md", ".tex", ".json"),
    log:
        f"{LOGS}/tables/re10k_mfr.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "table of two data sets"
    shell:
        "{AVS} --made-of {params.made_of} side_by_side_table"
        " {input.episodes} --settings {input.settings} --out {params.stem} --log {log}"


rule runtime_summary:
    input:
        records=summarised_timings,
        episodes=summarised_episodes,
        published=lambda wildcards: f"results/published/{RUNTIME_NAMES[wildcards.summary]}",
        settings=f"{RESULTS}/settings/runtime_summary/{{summary}}.json",
        code=sources("avs.report.tables.runtime_summary"),
    output:
        multiext(
            f"{RESULTS}/tables/runtime_{{summary}}", ".csv", ".md", ".tex", ".json"
        ),
    log:
        f"{LOGS}/tables/runtime_{{summary}}.log",
    wildcard_constraints:
        summary="memory|detail",
    params:
        made_of=made_of,
        episodes=episode_options,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "selection times in the paper's layout: {wildcards.summary}"
    shell:
        "{AVS} --made-of {params.made_of} runtime_summary"
        " {input.records} {params.episodes} --summary {wildcards.summary} --settings {input.settings}"
        " --out {params.stem} --log {log}"

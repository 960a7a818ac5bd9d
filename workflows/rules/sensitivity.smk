# How far the order of methods depends on the settings: episodes under variants of them, and one table per data set.

from avs.config.studied import studied_methods, studied_scenes

VARIED_EPISODE = EPISODE.replace("/episodes/", "/sensitivity/{variant}/episodes/")

try:
    STUDIED = studied_scenes(settings, SCENES)
except UserError as error:
    sys.exit(f"error: {error}")


def studied_episodes(path, dataset, **names):
    """Return the records at ``path`` that the table of a data set compares; absent methods have none."""
    told = settings.sensitivity
    return expand(
        path,
        dataset=dataset,
        method=[
            each for each in studied_methods(settings, dataset) if each not in ABSENT
        ],
        scene=STUDIED[dataset],
        seed=told.seeds or settings.seeds,
        **names,
    )


def base_episodes(wildcards):
    return studied_episodes(EPISODE, wildcards.dataset)


def varied_episodes(wildcards):
    variants = list(settings.sensitivity.variants)
    return studied_episodes(VARIED_EPISODE, wildcards.dataset, variant=variants)


def varied_options(wildcards, input):
    """Return each record of a variant behind the name of that variant."""
    return [
        f"--varied {variant}={path}"
        for variant in settings.sensitivity.variants
        for path in studied_episodes(VARIED_EPISODE, wildcards.dataset, variant=variant)
    ]


def sensitivity_tables(wildcards):
    """Return the tables of all data sets with scenes that are studied; none without variants of the settings."""
    return expand(f"{RESULTS}/tables/sensitivity_{{dataset}}.csv", dataset=STUDIED)


def tables_of_sensitivity(wildcards):
    """Return those tables where the target ``tables`` is to make them, too."""
    told = settings.sensitivity
    return sensitivity_tables(wildcards) if told and told.with_tables else []


localrules:
    sensitivity,


if settings.sensitivity is not None:

    rule sensitivity:
        input:
            sensitivity_tables,

else:

    rule sensitivity:
        shell:
            "echo 'error: configuration: sensitivity: names no variants of the settings; add some (docs/tables.md)' >&2"
            "; exit 2"


use rule episode as sensitivity_episode with:
    input:
        scene=SCENE,
        weights=method_weights,
        downloads=downloads,
        views=[],
        followed=[],
        kernels=OWN_KERNELS,
        settings=f"{RESULTS}/settings/sensitivity_episode/{{variant}}/{{method}}.json",
        code=method_code,
    output:
        episode=VARIED_EPISODE,
        meta=VARIED_EPISODE.replace(".json", ".meta.json"),
        model=VARIED_EPISODE.replace("episode.json", REPRESENTATION.exports),
        pictures=VARIED_EPISODE.replace("episode.json", PICTURES),
    log:
        VARIED_EPISODE.replace(RESULTS, LOGS).replace("/episode.json", ".log"),
    message:
        "episode: {wildcards.method} on {wildcards.scene} of {wildcards.dataset}, seed {wildcards.seed},"
        " variant {wildcards.variant}"


rule sensitivity_table:
    input:
        base=base_episodes,
        varied=varied_episodes,
        settings=f"{RESULTS}/settings/sensitivity_table/{{dataset}}.json",
        code=sources("avs.report.tables.setting_sensitivity"),
    output:
        multiext(
            f"{RESULTS}/tables/sensitivity_{{dataset}}",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_agreement.csv",
            "_per_episode.csv",
        ),
    log:
        f"{LOGS}/tables/sensitivity_{{dataset}}.log",
    params:
        made_of=made_of,
        varied=varied_options,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "sensitivity of {wildcards.dataset} to the settings"
    shell:
        "{AVS} --made-of {params.made_of} sensitivity_table"
        " {input.base} {params.varied} --dataset {wildcards.dataset}"
        " --settings {input.settings} --out {params.stem} --log {log}"

# Whether methods come in the same order whatever the scene is reconstructed with: episodes on several representations,
# and one table per data set.

from avs.config.agnostic_jobs import agnostic_absent
from avs.config.other_representations import (
    agnostic_datasets,
    agnostic_methods,
    agnostic_seeds,
    on_representation,
)

AGNOSTIC_EPISODE = EPISODE.replace("/episodes/", "/agnostic/{representation}/episodes/")
AGNOSTIC = {dataset: list(LISTED[dataset]) for dataset in agnostic_datasets(settings)}
AGNOSTIC_ABSENT = agnostic_absent(settings)


def agnostic_episodes(dataset, representation):
    """Return the records of a data set on one representation; methods that it does not suit have none."""
    return expand(
        AGNOSTIC_EPISODE,
        representation=representation,
        dataset=dataset,
        method=[
            each
            for each in agnostic_methods(settings)
            if each not in AGNOSTIC_ABSENT[representation]
        ],
        scene=AGNOSTIC[dataset],
        seed=agnostic_seeds(settings),
    )


def agnostic_records(wildcards):
    return [
        path
        for name in settings.agnostic.representations
        for path in agnostic_episodes(wildcards.dataset, name)
    ]


def agnostic_options(wildcards, input):
    """Return each record behind the name of its representation."""
    return [
        f"--episode {name}={path}"
        for name in settings.agnostic.representations
        for path in agnostic_episodes(wildcards.dataset, name)
    ]


def agnostic_kind(wildcards):
    """Return the kind of the representation that an episode runs on."""
    return on_representation(settings, wildcards.representation).representation.kind


def agnostic_kernels(wildcards):
    return KERNELS.format(kind=agnostic_kind(wildcards))


def agnostic_code(wildcards):
    """Return the source files of a method and of the representation that it runs on."""
    representation = kinds.find(agnostic_kind(wildcards)).module
    method = registry.find(wildcards.method).module
    return sources("avs.nvs.experiment", representation, method)


def agnostic_downloads(wildcards):
    """Return what such an episode reads on this machine."""
    return list(read_by(wildcards.method, True, wildcards.representation))


def agnostic_tables(wildcards):
    """Return the tables of all data sets; none where the configuration names no representations."""
    return expand(f"{RESULTS}/tables/agnostic_{{dataset}}.csv", dataset=AGNOSTIC)


def tables_of_representations(wildcards):
    """Return those tables where the target ``tables`` is to make them, too."""
    told = settings.agnostic
    return agnostic_tables(wildcards) if told and told.with_tables else []


localrules:
    agnostic,


if settings.agnostic is not None:

    rule agnostic:
        input:
            agnostic_tables,

else:

    rule agnostic:
        shell:
            "echo 'error: configuration: agnostic: names no representations; add some (docs/tables.md)' >&2"
            "; exit 2"


# The model stays in the episode: its name differs between representations, and nothing reads it.
use rule episode as agnostic_episode with:
    input:
        scene=SCENE,
        weights=method_weights,
        downloads=agnostic_downloads,
        views=[],
        followed=[],
        kernels=agnostic_kernels,
        settings=f"{RESULTS}/settings/agnostic_episode/{{representation}}/{{method}}.json",
        code=agnostic_code,
    output:
        episode=AGNOSTIC_EPISODE,
        meta=AGNOSTIC_EPISODE.replace(".json", ".meta.json"),
        pictures=AGNOSTIC_EPISODE.replace("episode.json", PICTURES),
    log:
        AGNOSTIC_EPISODE.replace(RESULTS, LOGS).replace("/episode.json", ".log"),
    message:
        "episode: {wildcards.method} on {wildcards.scene} of {wildcards.dataset}, seed {wildcards.seed},"
        " representation {wildcards.representation}"


rule agnostic_table:
    input:
        episodes=agnostic_records,
        settings=f"{RESULTS}/settings/agnostic_table/{{dataset}}.json",
        code=sources("avs.report.tables.representation_agreement"),
    output:
        multiext(
            f"{RESULTS}/tables/agnostic_{{dataset}}",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_agreement.csv",
            "_per_episode.csv",
        ),
    log:
        f"{LOGS}/tables/agnostic_{{dataset}}.log",
    params:
        made_of=made_of,
        episodes=agnostic_options,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "agreement of representations on {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} agnostic_table"
        " {params.episodes} --dataset {wildcards.dataset}"
        " --settings {input.settings} --out {params.stem} --log {log}"

# Active novel view synthesis: one episode per data set, scene, method and seed; and one record per data set, scene and
# seed of the states at which all methods score the same candidates.

import functools
import shlex

from avs.config.method_weights import files_read, followed, scoring_methods
from avs.config.other_representations import on_representation
from avs.nvs.picture_settings import PICTURES


module program:
    snakefile:
        f"{workflow.basedir}/workflows/rules/program.smk"
    config:
        config


EPISODE = f"{RESULTS}/episodes/{{dataset}}/{{scene}}/{{method}}/{{seed}}/episode.json"
VIEWS = EPISODE.replace("/episode.json", "/views.json")

# Weights that this run makes, by rule.
MADE = {
    "scorer_train": f"{RESULTS}/scorer/{{name}}/weights.safetensors",
    "niqe_fit": f"{RESULTS}/parameters/{{name}}.safetensors",
    "statistics_fit": f"{RESULTS}/parameters/{{name}}.safetensors",
}


def views_of(method):
    """Return the output of the rule that makes the views of one method which is a program of its own."""
    return VIEWS.replace("{method}", f"{{method,{method}}}")


def inputs_of(*program):
    """Return the input of that rule: the scene, the settings, the files of the program, the one to start first, and those
    that its settings name.

    Of a folder all files in it count.
    """
    settings_file = f"{RESULTS}/settings/episode/{{method}}.json"
    return {
        "scene": SCENE,
        "settings": settings_file,
        "program": with_contents(program),
        "named": method_files,
    }


def episodes(dataset, scenes=None):
    """Return the records of episodes on these scenes of a data set, or on all, in order of method, scene and seed.

    Absent methods have none.
    """
    return expand(
        EPISODE,
        dataset=dataset,
        method=RUNNABLE[dataset],
        scene=scenes or SCENES[dataset],
        seed=settings.seeds,
    )


def dataset_episodes(wildcards):
    return episodes(wildcards.dataset)


def all_episodes(wildcards):
    return [path for dataset in SCENES for path in episodes(dataset)]


def method_code(wildcards):
    """Return the source files of a method, as far as they are known here, and of the episodes that it runs in."""
    if wildcards.method in PROGRAMS:
        return sources("avs.nvs.experiment", REPRESENTATION.module)
    method = registry.find(wildcards.method).module
    return sources("avs.nvs.experiment", REPRESENTATION.module, method)


def weights_of_method(method):
    """Return the file of weights that a method gets, if any: one that is here, or one that a rule makes."""
    weights = weights_of(settings, method)
    if isinstance(weights, Made):
        return MADE[weights.rule].format(name=weights.name)
    return str(weights or "") or []


def method_weights(wildcards):
    return weights_of_method(wildcards.method)


@functools.cache  # for thousands of episodes of a few methods
def read_by(method, evaluated, representation=None):
    """Return the published weights on this machine, and files that settings name, that a method reads.

    With ``evaluated``, those of LPIPS are among them. ``representation``: another than the run's, by its name in the
    section `agnostic`.
    """
    told = on_representation(settings, representation) if representation else settings
    return tuple(map(str, files_read(told, method, evaluated=evaluated)))


def method_files(wildcards):
    """Return what a method reads to choose."""
    return list(read_by(wildcards.method, False))


def downloads(wildcards):
    """Return what an episode reads, too."""
    return list(read_by(wildcards.method, True))


def weights_option(wildcards, input):
    return f"--weights {shlex.quote(str(input.weights))}" if input.weights else ""


def views_option(wildcards, input):
    return f"--views {input.views}" if input.views else ""


def listed_views(wildcards):
    """Return what a method has chosen that is a program of its own; nothing for others, who choose in the episode."""
    if wildcards.method not in PROGRAMS:
        return []
    return VIEWS


def followed_episode(wildcards):
    """Return the episode whose views a method captures; nothing for a method that chooses."""
    other = followed(wildcards.method)
    return [] if other is None else EPISODE.replace("{method}", other)


def follow_option(wildcards, input):
    return f"--follow {input.followed}" if input.followed else ""


rule episode:
    input:
        scene=SCENE,
        weights=method_weights,
        downloads=downloads,
        views=listed_views,
        followed=followed_episode,
        kernels=OWN_KERNELS,
        settings=f"{RESULTS}/settings/episode/{{method}}.json",
        code=method_code,
    output:
        episode=EPISODE,
        meta=EPISODE.replace(".json", ".meta.json"),
        model=EPISODE.replace("episode.json", REPRESENTATION.exports),
        pictures=EPISODE.replace("episode.json", PICTURES),
    log:
        EPISODE.replace(RESULTS, LOGS).replace("/episode.json", ".log"),
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        weights=weights_option,
        views=views_option,
        follow=follow_option,
        folder=subpath(output.episode, parent=True),
    message:
        "episode: {wildcards.method} on {wildcards.scene} of {wildcards.dataset}, seed {wildcards.seed}"
    shell:
        "{AVS} --made-of {params.made_of} episode"
        " {params.scene} {wildcards.seed} --settings {input.settings} {params.weights} {params.views}"
        " {params.follow} --out {params.folder} --log {log}"


COMMON_STATES = f"{RESULTS}/common_states/{{dataset}}/{{scene}}/{{seed}}.json"
SCORING = {dataset: scoring_methods(settings, dataset) for dataset in SCENES}


def common_states(dataset):
    """Return the records of the common states of a data set, in order of scene and seed."""
    return expand(
        COMMON_STATES, dataset=dataset, scene=SCENES[dataset], seed=settings.seeds
    )


def scoring_code(wildcards):
    """Return the source files of all methods that score, and of what they score."""
    modules = [registry.find(method).module for method in SCORING[wildcards.dataset]]
    return sources("avs.nvs.common_states", REPRESENTATION.module, *modules)


def weights_by_method(methods):
    """Return the files of weights of those methods that get some, by identifier."""
    files = {method: weights_of_method(method) for method in methods}
    return {method: file for method, file in files.items() if file}


def downloads_of(methods):
    """Return those that methods read to score."""
    return sorted({path for method in methods for path in read_by(method, False)})


def weights_options(methods):
    """Return the files of weights of methods as options of a command."""
    return [
        f"--weights {shlex.quote(f'{method}={file}')}"
        for method, file in weights_by_method(methods).items()
    ]


def scoring_weights(wildcards):
    return list(weights_by_method(SCORING[wildcards.dataset]).values())


def scoring_downloads(wildcards):
    return downloads_of(SCORING[wildcards.dataset])


def scoring_weights_options(wildcards):
    return weights_options(SCORING[wildcards.dataset])


rule common_states:
    input:
        scene=SCENE,
        weights=scoring_weights,
        downloads=scoring_downloads,
        kernels=OWN_KERNELS,
        settings=f"{RESULTS}/settings/common_states/{{dataset}}.json",
        code=scoring_code,
    output:
        record=COMMON_STATES,
        meta=COMMON_STATES.replace(".json", ".meta.json"),
    log:
        COMMON_STATES.replace(RESULTS, LOGS).replace(".json", ".log"),
    priority: 1  # longer than an episode, so that none is left at the end
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        weights=scoring_weights_options,
    message:
        "common states of {wildcards.scene} of {wildcards.dataset}, seed {wildcards.seed}: scores and truth"
    shell:
        "{AVS} --made-of {params.made_of} common_states"
        " {params.scene} {wildcards.seed} --settings {input.settings} {params.weights}"
        " --out {output.record} --log {log}"

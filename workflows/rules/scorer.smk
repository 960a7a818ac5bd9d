# Renderings of training scenes with their SSIM maps; the training of each cross-reference scorer on them, and the fit of
# regressions on plain statistics.

from avs.config.configuration import scorer_of
from avs.config.other_representations import representation_of
from avs.iqa.cross_reference.backbone_weights import initial_weights

DISTORTIONS = f"{RESULTS}/distortions/{{dataset}}/{{scene}}.safetensors"


def distortions(datasets):
    """Return the distortion data of the scenes of these data sets; all scorers share them."""
    return [
        DISTORTIONS.format(dataset=dataset, scene=scene)
        for dataset in datasets
        for scene in LISTED[dataset]
    ]


def training_distortions(wildcards):
    return distortions(settings.distortions.training)


def held_out_distortions(wildcards):
    return distortions(settings.distortions.held_out)


def render_seed(wildcards):
    return scene_settings(wildcards).render_seed()


def training_backbone(wildcards):
    """Return the file of pretrained weights that training begins with; none for random ones."""
    return str(initial_weights(scorer_of(settings, wildcards.scorer)) or "") or []


def training_processes(wildcards):
    return scorer_of(settings, wildcards.scorer).training.processes


def training_gpus(wildcards):
    return training_processes(wildcards) if settings.device == "cuda" else 0


def training_options(wildcards, input):
    return repeated("--training", input.training)


def held_out_options(wildcards, input):
    return repeated("--held-out", input.held_out)


def distortion_settings(wildcards):
    """Return the settings of renderings: those of all data sets, but for one that has a representation of its own."""
    if wildcards.dataset in settings.distortions.representations:
        return f"{RESULTS}/settings/distortions/{wildcards.dataset}.json"
    return f"{RESULTS}/settings/distortions.json"


def distortion_kernels(wildcards):
    return KERNELS.format(kind=representation_of(settings, wildcards.dataset).kind)


def distortion_code(wildcards):
    """Return the source files of renderings, and of the representation that is rendered."""
    kind = kinds.find(representation_of(settings, wildcards.dataset).kind)
    return sources("avs.iqa.cross_reference.distortion_renders", kind.module)


rule distortions:
    input:
        scene=SCENE,
        settings=distortion_settings,
        kernels=distortion_kernels,
        code=distortion_code,
    output:
        DISTORTIONS,
    log:
        f"{LOGS}/distortions/{{dataset}}/{{scene}}.log",
    priority: 2  # the longest path of the workflow goes through the scorers
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        folder=subpath(input.scene, parent=True),
        seed=render_seed,
    message:
        "renderings of {wildcards.scene} of {wildcards.dataset} while it is reconstructed"
    shell:
        "{AVS} --made-of {params.made_of} distortions"
        " {params.folder} {params.seed} --settings {input.settings}"
        " --out {output} --log {log}"


rule scorer_train:
    input:
        training=training_distortions,
        held_out=held_out_distortions,
        # A reinstalled package has a newer file with the same bytes; `made_of` tells of others.
        backbone=ancient(training_backbone),
        settings=f"{RESULTS}/settings/scorer_train/{{scorer}}.json",
        code=sources("avs.iqa.cross_reference.training"),
    output:
        weights=f"{RESULTS}/scorer/{{scorer}}/weights.safetensors",
        card=f"{RESULTS}/scorer/{{scorer}}/card.json",
    log:
        f"{LOGS}/scorer/{{scorer}}/training.log",
    priority: 2
    threads: training_processes
    resources:
        gpu=training_gpus,
    params:
        made_of=made_of,
        training=training_options,
        held_out=held_out_options,
    message:
        "training of the scorer {wildcards.scorer}"
    shell:
        "{AVS} --made-of {params.made_of} scorer_train"
        " {params.training} {params.held_out} --settings {input.settings}"
        " --weights {output.weights} --card {output.card} --log {log}"


rule statistics_fit:
    input:
        training=training_distortions,
        held_out=held_out_distortions,
        settings=f"{RESULTS}/settings/statistics_fit.json",
        code=sources("avs.iqa.render_statistics.regression_fit"),
    output:
        weights=f"{RESULTS}/parameters/statistics.safetensors",
        card=f"{RESULTS}/parameters/statistics.card.json",
    log:
        f"{LOGS}/parameters/statistics.log",
    priority: 2
    params:
        made_of=made_of,
        training=training_options,
        held_out=held_out_options,
    message:
        "regressions of SSIM on plain statistics of renderings"
    shell:
        "{AVS} --made-of {params.made_of} statistics_fit"
        " {params.training} {params.held_out} --settings {input.settings}"
        " --weights {output.weights} --card {output.card} --log {log}"

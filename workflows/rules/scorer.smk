# Cross-reference scorers: renderings of training scenes with their SSIM maps, then the training of each scorer on them.


def distortions(seeds):
    """Return the distortion data of the scenes with these seeds; all scorers share them."""
    return expand(
        f"{RESULTS}/distortions/{{pattern}}_{{seed}}.safetensors",
        pattern=settings.distortions.pattern,
        seed=seeds,
    )


def training_distortions(wildcards):
    return distortions(settings.distortions.training_seeds)


def held_out_distortions(wildcards):
    return distortions(settings.distortions.held_out_seeds)


def training_options(wildcards, input):
    return repeated("--training", input.training)


def held_out_options(wildcards, input):
    return repeated("--held-out", input.held_out)


rule distortions:
    input:
        scene=f"{RESULTS}/scenes/{{pattern}}_{{seed}}/scene.json",
        settings=f"{RESULTS}/settings/distortions.json",
        kernels=ancient(KERNELS),
        code=sources("avs.iqa.cross_reference.distortion_renders", REPRESENTATION.module),
    output:
        f"{RESULTS}/distortions/{{pattern}}_{{seed}}.safetensors",
    log:
        f"{LOGS}/distortions/{{pattern}}_{{seed}}.log",
    priority: 2  # the longest path of the workflow goes through the scorers
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        folder=subpath(input.scene, parent=True),
    message:
        "renderings of {wildcards.pattern}_{wildcards.seed} while it is reconstructed"
    shell:
        "{AVS} distortions {params.folder} {wildcards.seed} --settings {input.settings}"
        " --out {output} --log {log}"


rule scorer_train:
    input:
        training=training_distortions,
        held_out=held_out_distortions,
        settings=f"{RESULTS}/settings/scorer_train/{{scorer}}.json",
        code=sources("avs.iqa.cross_reference.training"),
    output:
        weights=f"{RESULTS}/scorer/{{scorer}}/weights.safetensors",
        card=f"{RESULTS}/scorer/{{scorer}}/card.json",
    log:
        f"{LOGS}/scorer/{{scorer}}/training.log",
    priority: 2
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        training=training_options,
        held_out=held_out_options,
    message:
        "training of the scorer {wildcards.scorer}"
    shell:
        "{AVS} scorer_train {params.training} {params.held_out} --settings {input.settings}"
        " --weights {output.weights} --card {output.card} --log {log}"

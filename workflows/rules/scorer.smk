# Cross-reference scorers: renderings of training scenes with their SSIM maps, then the training.


def renders(scorer, seeds):
    """Return the renderings of a scorer's scenes with these seeds."""
    pattern = settings.scorers[scorer].pattern
    return [
        f"{RESULTS}/scorer/{scorer}/renders/{pattern}_{seed}.safetensors"
        for seed in seeds
    ]


def training_renders(wildcards):
    return renders(wildcards.scorer, settings.scorers[wildcards.scorer].training_seeds)


def held_out_renders(wildcards):
    return renders(wildcards.scorer, settings.scorers[wildcards.scorer].held_out_seeds)


rule scorer_renders:
    input:
        scene=f"{RESULTS}/scenes/{{pattern}}_{{seed}}/scene.json",
        settings=f"{RESULTS}/settings/renders/{{scorer}}.json",
        kernels=ancient(KERNELS),
        code=sources("avs.scorer.renders"),
    output:
        f"{RESULTS}/scorer/{{scorer}}/renders/{{pattern}}_{{seed}}.safetensors",
    log:
        f"{LOGS}/scorer/{{scorer}}/renders/{{pattern}}_{{seed}}.log",
    priority: 2  # the longest path of the workflow goes through the scorer
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        folder=subpath(input.scene, parent=True),
    message:
        "renderings of {wildcards.pattern}_{wildcards.seed} for the scorer {wildcards.scorer}"
    shell:
        "{AVS} scorer renders {params.folder} {wildcards.seed} --settings {input.settings}"
        " --out {output} --log {log}"


rule scorer_train:
    input:
        training=training_renders,
        held_out=held_out_renders,
        settings=f"{RESULTS}/settings/training/{{scorer}}.json",
        code=sources("avs.scorer.training"),
    output:
        weights=f"{RESULTS}/scorer/{{scorer}}/weights.safetensors",
        card=f"{RESULTS}/scorer/{{scorer}}/card.json",
    log:
        f"{LOGS}/scorer/{{scorer}}/training.log",
    priority: 2
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        training=lambda wildcards, input: [
            f"--training {path}" for path in input.training
        ],
        held_out=lambda wildcards, input: [
            f"--held-out {path}" for path in input.held_out
        ],
    message:
        "training of the scorer {wildcards.scorer}"
    shell:
        "{AVS} scorer train {params.training} {params.held_out} --settings {input.settings}"
        " --weights {output.weights} --card {output.card} --log {log}"

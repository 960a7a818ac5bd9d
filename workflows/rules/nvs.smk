# Active novel view synthesis: one episode per data set, scene, method and seed.

EPISODE = f"{RESULTS}/episodes/{{dataset}}/{{scene}}/{{method}}/{{seed}}/episode.json"


def episodes(dataset):
    """Return the records of every episode of a data set, in order of method, scene and seed."""
    return expand(
        EPISODE,
        dataset=dataset,
        method=settings.methods,
        scene=SCENES[dataset],
        seed=settings.seeds,
    )


def method_code(wildcards):
    """Return the source files of a method and of the episodes that it runs in."""
    return sources("avs.experiment", selectors.find(wildcards.method).module)


def scorer_weights(wildcards):
    """Return the checkpoint that a method needs, if any."""
    scorer = selectors.find(wildcards.method).method.scorer
    return [] if scorer is None else f"{RESULTS}/scorer/{scorer}/weights.safetensors"


rule episode:
    input:
        scene=f"{RESULTS}/scenes/{{scene}}/scene.json",
        weights=scorer_weights,
        kernels=ancient(KERNELS),
        settings=f"{RESULTS}/settings/episode/{{method}}.json",
        code=method_code,
    output:
        episode=EPISODE,
        meta=EPISODE.replace(".json", ".meta.json"),
        splats=EPISODE.replace("episode.json", "splats.ply"),
    log:
        EPISODE.replace(RESULTS, LOGS).replace("/episode.json", ".log"),
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        scene=subpath(input.scene, parent=True),
        weights=lambda wildcards, input: (
            f"--weights {input.weights}" if input.weights else ""
        ),
        folder=subpath(output.episode, parent=True),
    message:
        "episode: {wildcards.method} on {wildcards.scene}, seed {wildcards.seed}"
    shell:
        "{AVS} episode {params.scene} {wildcards.seed} --settings {input.settings} {params.weights}"
        " --out {params.folder} --log {log}"

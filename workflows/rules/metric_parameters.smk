# Parameters of no-reference metrics, fitted on the training scenes where the published ones are absent.


def training_scenes(wildcards):
    """Return the scenes that train, none of which is evaluated."""
    return [
        SCENE.format(dataset=dataset, scene=scene)
        for dataset in settings.distortions.training
        for scene in LISTED[dataset]
    ]


def scene_folders(wildcards, input):
    return [str(Path(path).parent) for path in input.scenes]


rule niqe_fit:
    input:
        scenes=training_scenes,
        settings=f"{RESULTS}/settings/niqe_fit.json",
        code=sources("avs.iqa.no_reference.niqe_fit"),
    output:
        f"{RESULTS}/parameters/niqe.safetensors",
    log:
        f"{LOGS}/parameters/niqe.log",
    priority: 2  # as what trains scorers: the common states wait for it
    params:
        made_of=made_of,
        scenes=scene_folders,
    message:
        "NIQE's parameters from photographs of the training scenes"
    shell:
        "{AVS} --made-of {params.made_of} niqe_fit"
        " {params.scenes} --settings {input.settings} --out {output} --log {log}"

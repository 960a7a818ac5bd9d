# The time of a selection: one job for each method, alone on the machine, on one reconstruction that all methods share.

from avs.config.method_weights import choosing_elsewhere
from avs.config.scenes import timed_scene

RUNTIME = f"{RESULTS}/runtime/{{dataset}}/{{scene}}"

try:
    TIMED_SCENE = timed_scene(settings)
except UserError as error:
    sys.exit(f"error: {error}")

TIMED = [
    method
    for method in RUNNABLE[TIMED_SCENE[0]]
    if method not in choosing_elsewhere(settings)
]


def timings(wildcards):
    """Return the times of each method that is timed."""
    dataset, scene = TIMED_SCENE
    return expand(
        f"{RUNTIME}/{{method}}.json", dataset=dataset, scene=scene, method=TIMED
    )


def timing_code(wildcards):
    """Return the source files of a method and of its timing."""
    method = registry.find(wildcards.method).module
    return sources("avs.nvs.timing", REPRESENTATION.module, method)


def timed_episodes(wildcards):
    """Return the episodes on the scene on which selections are timed, for their PSNR."""
    dataset, scene = TIMED_SCENE
    return episodes(dataset, [scene])


def episode_options(wildcards, input):
    return repeated("--episode", input.episodes)


rule runtime_state:
    input:
        scene=SCENE,
        kernels=OWN_KERNELS,
        settings=f"{RESULTS}/settings/runtime_state.json",
        code=sources("avs.nvs.timing", REPRESENTATION.module),
    output:
        f"{RUNTIME}/state.safetensors",
    log:
        f"{RUNTIME}/state.log".replace(RESULTS, LOGS),
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
    message:
        "reconstruction of {wildcards.scene} to time selections on"
    shell:
        "{AVS} --made-of {params.made_of} runtime_state"
        " {params.scene} --settings {input.settings} --out {output} --log {log}"


rule runtime:
    input:
        scene=SCENE,
        state=f"{RUNTIME}/state.safetensors",
        weights=method_weights,
        downloads=method_files,
        kernels=OWN_KERNELS,
        settings=f"{RESULTS}/settings/runtime/{{method}}.json",
        code=timing_code,
    output:
        f"{RUNTIME}/{{method}}.json",
    log:
        f"{RUNTIME}/{{method}}.log".replace(RESULTS, LOGS),
    threads: workflow.cores or 1  # all of them, so that nothing else runs meanwhile
    resources:
        gpu=int(settings.device == "cuda"),
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        weights=weights_option,
    message:
        "selection time of {wildcards.method} on {wildcards.scene}"
    shell:
        "{AVS} --made-of {params.made_of} runtime"
        " {params.scene} --state {input.state} --settings {input.settings} {params.weights}"
        " --out {output} --log {log}"

# Scenes: each is prepared by the reader of its data set.

from avs.config.scenes import scenes_of

try:
    LISTED = scenes_of(settings)
except UserError as error:
    sys.exit(f"error: {error}")

for dataset, reader in settings.datasets.items():
    for name, reason in reader.left_out().items():
        print(f"left out of {dataset}: {name} {reason}", file=sys.stderr)

# A data set that lists no method is there for another section of the configuration.
for dataset in settings.without_methods if workflow.is_main_process else ():
    if settings.datasets[dataset].methods:
        print(
            f"left out: {dataset}: the run has none of its methods, {', '.join(settings.datasets[dataset].methods)}",
            file=sys.stderr,
        )

# The names of the evaluated scenes of each data set.
SCENES = {dataset: list(LISTED[dataset]) for dataset in settings.evaluated}

SCENE = f"{RESULTS}/scenes/{{dataset}}/{{scene}}/scene.json"


def scene_settings(wildcards):
    """Return the settings of one scene, which know all that it is made from."""
    return LISTED[wildcards.dataset][wildcards.scene]


def scene_files(wildcards):
    """Return the user's files that a scene is made from."""
    return [str(path) for path in scene_settings(wildcards).files()]


def scene_code(wildcards):
    """Return the source files of the reader that prepares a scene."""
    return sources(type(scene_settings(wildcards)).__module__)


rule scene:
    input:
        files=scene_files,
        settings=f"{RESULTS}/settings/scene/{{dataset}}/{{scene}}.json",
        code=scene_code,
    output:
        SCENE,
    log:
        f"{LOGS}/scenes/{{dataset}}/{{scene}}.log",
    priority: 2  # as what trains scorers, which waits for them
    params:
        made_of=made_of,
        folder=subpath(output[0], parent=True),
    message:
        "scene {wildcards.scene} of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} scene"
        " --settings {input.settings} --out {params.folder} --log {log}"

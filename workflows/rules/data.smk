# Scenes: embedded ones made from a seed, and captures in COLMAP layout.

from avs.datasets.captures import list_captures

PATTERNS = "|".join(["orbit", "walkthrough", "handheld", "egocentric"])


def captures():
    """Return the folder of each capture by scene name; empty without scenes_dir."""
    if settings.scenes_dir is None:
        return {}
    try:
        return list_captures(Path(settings.scenes_dir))
    except UserError as error:
        sys.exit(f"error: {error}")


CAPTURES = captures()


def scenes():
    """Return the names of the evaluated scenes of each data set."""
    if settings.scenes_dir is not None:
        return {"captures": sorted(CAPTURES)}
    return {
        pattern: [f"{pattern}_{seed}" for seed in seeds]
        for pattern, seeds in settings.embedded.scenes.items()
    }


SCENES = scenes()


def capture_files(wildcards):
    """Return every file of a capture that its scene is made from."""
    folder = CAPTURES[wildcards.scene]
    return sorted(str(path) for path in folder.rglob("*") if path.is_file())


rule embedded_scene:
    input:
        settings=f"{RESULTS}/settings/embedded_scene.json",
        code=sources("avs.datasets.embedded"),
    output:
        f"{RESULTS}/scenes/{{pattern}}_{{seed}}/scene.json",
    log:
        f"{LOGS}/scenes/{{pattern}}_{{seed}}.log",
    wildcard_constraints:
        pattern=PATTERNS,
    params:
        folder=subpath(output[0], parent=True),
    message:
        "scene {wildcards.pattern}_{wildcards.seed}"
    shell:
        "{AVS} embedded_scene {wildcards.pattern} {wildcards.seed} --settings {input.settings}"
        " --out {params.folder} --log {log}"


rule capture_scene:
    input:
        files=capture_files,
        settings=f"{RESULTS}/settings/capture_scene.json",
        code=sources("avs.datasets.captures"),
    output:
        f"{RESULTS}/scenes/{{scene}}/scene.json",
    log:
        f"{LOGS}/scenes/{{scene}}.log",
    wildcard_constraints:
        scene="|".join(CAPTURES) or "-",
    params:
        folder=subpath(output[0], parent=True),
        source=lookup(
            dpath="{scene}",
            within={name: str(path) for name, path in CAPTURES.items()},
        ),
    message:
        "scene {wildcards.scene}, from {params.source}"
    shell:
        "{AVS} capture_scene {params.source:q} --settings {input.settings} --out {params.folder} --log {log}"

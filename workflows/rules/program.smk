# A method that is a program of its own: it writes the views that it would capture, and the suite runs the episode on
# them. A file of workflows/baselines takes this rule and names its program; docs/add-a-baseline.md shows how.

from avs.system.code_inputs import sources_of_inputs

RESULTS = f"results/{config['scale']}"
VIEWS = "episodes/{dataset}/{scene}/{method}/{seed}/views.json"


def command(wildcards, input):
    """Return what starts a program: its first file, by Python where it is a script of Python's."""
    first = input.program if isinstance(input.program, str) else input.program[0]
    if first.endswith(".py"):
        return f"python {first}"
    return first if "/" in first else f"./{first}"


rule views:
    input:
        scene=f"{RESULTS}/scenes/{{dataset}}/{{scene}}/scene.json",
        settings=f"{RESULTS}/settings/episode/{{method}}.json",
        program="name the files of your program in inputs_of",
    output:
        f"{RESULTS}/{VIEWS}",
    log:
        f"{RESULTS}/logs/{VIEWS}".replace("/views.json", ".views.log"),
    params:
        made_of=sources_of_inputs(RESULTS),
        program=command,
        scene=subpath(input.scene, parent=True),
    message:
        "views: {wildcards.method} on {wildcards.scene} of {wildcards.dataset}, seed {wildcards.seed}"
    shell:
        "sha256sum {input.settings} {input.scene} | sed 's/^/# read /' > {log}.read"
        " && {params.program} {params.scene} {wildcards.seed} --settings {input.settings} --out {output} > {log} 2>&1"
        " && (echo '# made of' {params.made_of[0]} {params.program:q} && cat {log}.read && sha256sum {output}) > {log}.part"
        " && mv {log}.part {log}.sha256 && rm {log}.read"

# A method that is a program of its own: it writes the views that it would capture, and the suite runs the episode on
# them. A file of workflows/baselines takes this rule and names its program; docs/add-a-baseline.md shows how.

RESULTS = f"results/{config['scale']}"
VIEWS = "episodes/{dataset}/{scene}/{method}/{seed}/views.json"


rule views:
    input:
        scene=f"{RESULTS}/scenes/{{scene}}/scene.json",
        settings=f"{RESULTS}/settings/episode/{{method}}.json",
    output:
        f"{RESULTS}/{VIEWS}",
    log:
        f"{RESULTS}/logs/{VIEWS}".replace("/views.json", ".views.log"),
    params:
        program="name your program in params",
        scene=subpath(input.scene, parent=True),
    message:
        "views: {wildcards.method} on {wildcards.scene}, seed {wildcards.seed}"
    shell:
        "{params.program} {params.scene} {wildcards.seed} --settings {input.settings} --out {output} > {log} 2>&1"

# The page: a folder that opens from disk, made of records, tables and figures.

PAGE = f"{RESULTS}/report"
PAGE_FILES = sorted(
    str(path.relative_to(workflow.basedir))
    for folder in ("static", ".")
    for path in Path(workflow.basedir, "avs/report/page", folder).iterdir()
    if path.is_file() and path.suffix != ".py"
)


def scene_episodes(wildcards):
    return episodes(wildcards.dataset, [wildcards.scene])


def beside(name):
    """Return the function that gives the files of this name beside the episodes of a scene."""

    def files(wildcards):
        return [
            path.replace("episode.json", name) for path in scene_episodes(wildcards)
        ]

    return files


def scene_coverages(file):
    """Return the function that gives the files of this name of the coverage of a scene's episodes, if it is measured."""

    def files(wildcards):
        if wildcards.dataset not in COVERED:
            return []
        return coverages(f"{COVERAGE}/{file}", wildcards.dataset, [wildcards.scene])

    return files


def scene_states(wildcards):
    """Return the common states of a scene, unless the configuration leaves them out."""
    if wildcards.dataset not in settings.with_table("ranking"):
        return []
    return expand(
        COMMON_STATES,
        dataset=wildcards.dataset,
        scene=wildcards.scene,
        seed=settings.seeds,
    )


def states_options(wildcards, input):
    return repeated("--states", input.states)


def page_scenes(wildcards):
    return [
        f"{PAGE}/scenes/{dataset}/{scene}/scene.js"
        for dataset, names in SCENES.items()
        for scene in names
    ]


def page_explorations(wildcards):
    """Return the scripts of explorations, where the target ``tables`` makes their table, too."""
    if not BUILDINGS or not settings.slam.with_tables:
        return []
    return explorations(f"{PAGE}/slam/{{building}}/{{method}}-{{seed}}.js")


def page_tables(wildcards):
    """Return the records of all tables of the run."""
    return [
        path.replace(".csv", ".json")
        for path in asked_for(rules.tables.input)
        if path.startswith(f"{RESULTS}/tables/")
    ]


def page_figures(wildcards):
    """Return the pictures of all figures of the run."""
    return [
        path.replace(".pdf", ".png")
        for path in asked_for(rules.figures.input, rules.tables.input)
        if path.startswith(f"{RESULTS}/figures/")
    ]


def page_cards(wildcards):
    """Return the model cards of the scorers whose weights methods of this run read."""
    methods = dict.fromkeys(each for names in RUNNABLE.values() for each in names)
    weights = [str(weights_of_method(method)) for method in methods]
    made = [path for path in weights if path.startswith(f"{RESULTS}/scorer/")]
    return [
        path.replace("weights.safetensors", "card.json") for path in dict.fromkeys(made)
    ]


def table_options(wildcards, input):
    return repeated("--table", input.tables)


def figure_options(wildcards, input):
    return repeated("--figure", input.figures)


def card_options(wildcards, input):
    return repeated("--card", input.cards)


rule page_scene:
    input:
        scene=SCENE,
        episodes=scene_episodes,
        metas=beside("episode.meta.json"),
        pictures=beside(PICTURES),
        models=beside(REPRESENTATION.exports),
        records=scene_coverages("coverage.json"),
        covered=scene_coverages("covered.ply"),
        states=scene_states,
        settings=f"{RESULTS}/settings/page_scene/{{dataset}}.json",
        code=sources("avs.report.page.scene_scripts"),
    output:
        f"{PAGE}/scenes/{{dataset}}/{{scene}}/scene.js",
    log:
        f"{LOGS}/page/{{dataset}}/{{scene}}.log",
    params:
        made_of=made_of,
        scene=subpath(input.scene, parent=True),
        coverage=coverage_options,
        states=states_options,
        folder=subpath(output[0], parent=True),
    message:
        "page: {wildcards.scene} of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} page_scene"
        " {params.scene} {input.episodes} {params.coverage} {params.states} --settings {input.settings}"
        " --out {params.folder} --log {log}"


rule page_exploration:
    input:
        record=EXPLORATION,
        meta=EXPLORATION.replace(".json", ".meta.json"),
        maps=EXPLORATION.replace("exploration.json", "maps.safetensors"),
        settings=f"{RESULTS}/settings/page_exploration.json",
        code=sources("avs.report.page.exploration_script"),
    output:
        f"{PAGE}/slam/{{building}}/{{method}}-{{seed}}.js",
    log:
        f"{LOGS}/page/slam/{{building}}/{{method}}/{{seed}}.log",
    params:
        made_of=made_of,
        page=PAGE,
    message:
        "page: exploration of {wildcards.building} by {wildcards.method}, seed {wildcards.seed}"
    shell:
        "{AVS} --made-of {params.made_of} page_exploration"
        " {input.record} --settings {input.settings} --out {params.page} --log {log}"


rule page:
    input:
        scenes=page_scenes,
        explorations=page_explorations,
        tables=page_tables,
        figures=page_figures,
        cards=page_cards,
        files=PAGE_FILES,
        settings=f"{RESULTS}/settings/page.json",
        code=sources(
            "avs.report.page.site",
            *{found.module for found in registry.methods().values()},
        ),
    output:
        f"{PAGE}/index.html",
    log:
        f"{LOGS}/page/page.log",
    params:
        made_of=made_of,
        tables=table_options,
        figures=figure_options,
        cards=card_options,
        page=PAGE,
    message:
        "page: tables, figures and frame"
    shell:
        "{AVS} --made-of {params.made_of} page"
        " --settings {input.settings} {params.tables} {params.figures} {params.cards}"
        " --out {params.page} --log {log}"


localrules:
    report,


rule report:
    input:
        f"{PAGE}/index.html",

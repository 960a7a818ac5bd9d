# Which methods differ: a table and a diagram of average ranks for each data set.

SIGNIFICANCE = expand(f"{RESULTS}/tables/significance_{{dataset}}.csv", dataset=SCENES)
CRITICAL_DIFFERENCES = expand(
    f"{RESULTS}/figures/critical_difference_{{dataset}}.pdf", dataset=SCENES
)


rule significance_table:
    input:
        episodes=dataset_episodes,
        settings=f"{RESULTS}/settings/significance_table/{{dataset}}.json",
        code=sources("avs.report.tables.method_significance"),
    output:
        multiext(
            f"{RESULTS}/tables/significance_{{dataset}}",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_pairs.csv",
            "_ranks.csv",
        ),
    log:
        f"{LOGS}/tables/significance_{{dataset}}.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "which methods differ on {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} significance_table"
        " {input.episodes} --dataset {wildcards.dataset} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule critical_difference:
    input:
        episodes=dataset_episodes,
        settings=f"{RESULTS}/settings/critical_difference/{{dataset}}.json",
        code=sources("avs.report.figures.critical_difference"),
    output:
        multiext(
            f"{RESULTS}/figures/critical_difference_{{dataset}}", ".pdf", ".png", ".md"
        ),
    log:
        f"{LOGS}/figures/critical_difference_{{dataset}}.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: average ranks on {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} critical_difference"
        " {input.episodes} --dataset {wildcards.dataset} --settings {input.settings}"
        " --out {params.stem} --log {log}"

# Tables, from records and nothing else.

import hashlib

from avs.config.method_weights import with_weights_at_hand
from avs.config.run_plan import PLAN_NAME, RunPlan
from avs.system.records import write_record

# The paper's selection times.
PUBLISHED_TIMES = [
    "results/published/runtime_garden_detail.csv",
    "results/published/runtime_garden.csv",
]

# What a run asks for, from which `python -m avs report` tabulates what is there of it.
PLAN = f"{RESULTS}/{PLAN_NAME}"
INCOMPLETE = f"{RESULTS}/tables_incomplete"


def write_plan():
    """Write what this run asks for, before its first job."""
    logs = {
        "episode": rules.episode.log[0],
        "common_states": rules.common_states.log[0],
        "held_out_scores": rules.held_out_scores.log[0],
        "runtime": rules.runtime.log[0],
        "sensitivity_episode": rules.sensitivity_episode.log[0],
        "agnostic_episode": rules.agnostic_episode.log[0],
        "coverage": rules.coverage.log[0],
        "exploration": rules.exploration.log[0],
    }
    records = {
        "scene": SCENE,
        "episode": EPISODE,
        "common_states": COMMON_STATES,
        "held_out_scores": HELD_OUT,
        "runtime": rules.runtime.output[0],
        "sensitivity_episode": VARIED_EPISODE,
        "agnostic_episode": AGNOSTIC_EPISODE,
        "coverage": rules.coverage.output.record,
        "exploration": rules.exploration.output.record,
    }
    plan = RunPlan(
        results=RESULTS,
        config=settings,
        weights_at_hand=with_weights_at_hand(settings),
        programs=tuple(PROGRAMS),
        scenes={dataset: tuple(scenes) for dataset, scenes in LISTED.items()},
        timed=TIMED_SCENE if settings.runtime is not None and TIMED else None,
        studied={dataset: tuple(scenes) for dataset, scenes in STUDIED.items()},
        published_times=PUBLISHED_TIMES,
        records=records,
        logs={rule: str(log) for rule, log in logs.items()},
        stamps={
            str(job.log[0]): told_of(job)[0]
            for job in workflow.dag.jobs
            if job.log and hasattr(job.params, "made_of")
        },
        waits_for={
            str(job.log[0]): tuple(
                sorted(str(each.log[0]) for each in before if each.log)
            )
            for job, before in workflow.dag.dependencies.items()
            if job.log
        },
        settings={
            str(job.output[0]): hashlib.sha256(
                f"{settings_text(job.wildcards)}\n".encode()
            ).hexdigest()
            for job in workflow.dag.jobs
            if job.rule.name == "settings"
        },
    )
    write_record(Path(PLAN), plan)


def published_file(wildcards):
    """Return the file of published values that stand beside a data set's own, if any."""
    return settings_of(settings, f"nvs_table/{wildcards.dataset}").published or []


def dataset_states(wildcards):
    return common_states(wildcards.dataset)


def ranking_tables(wildcards):
    """Return the table of rank correlations of each data set, unless the configuration leaves it out."""
    return expand(
        f"{RESULTS}/tables/ranking_{{dataset}}.csv",
        dataset=settings.with_table("ranking"),
    )


def published_options(wildcards, input):
    return repeated("--published", input.published)


def runtime_tables(wildcards):
    """Return the tables of selection times, unless the configuration leaves them out."""
    if settings.runtime is None or not TIMED:
        return []
    memory = set(with_memory(settings, TIMED_SCENE[0])) & set(TIMED)
    names = ["runtime", "runtime_detail", *(["runtime_memory"] if memory else [])]
    return expand(f"{RESULTS}/tables/{{name}}.csv", name=names)


rule nvs_table:
    input:
        episodes=dataset_episodes,
        settings=f"{RESULTS}/settings/nvs_table/{{dataset}}.json",
        published=published_file,
        code=sources("avs.report.tables.view_synthesis"),
    output:
        multiext(
            f"{RESULTS}/tables/nvs_{{dataset}}",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_per_scene.csv",
            "_differences.csv",
        ),
    log:
        f"{LOGS}/tables/nvs_{{dataset}}.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "table of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} nvs_table"
        " {input.episodes} --dataset {wildcards.dataset} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule ranking_table:
    input:
        records=dataset_states,
        settings=f"{RESULTS}/settings/ranking_table/{{dataset}}.json",
        code=sources("avs.report.tables.score_ranking"),
    output:
        multiext(
            f"{RESULTS}/tables/ranking_{{dataset}}",
            ".csv",
            ".md",
            ".tex",
            ".json",
            "_per_state.csv",
            "_gain.csv",
        ),
    log:
        f"{LOGS}/tables/ranking_{{dataset}}.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "ranking of {wildcards.dataset}"
    shell:
        "{AVS} --made-of {params.made_of} ranking_table"
        " {input.records} --dataset {wildcards.dataset} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule runtime_table:
    input:
        records=timings,
        episodes=timed_episodes,
        published=PUBLISHED_TIMES,
        settings=f"{RESULTS}/settings/runtime_table.json",
        code=sources("avs.report.tables.selection_times"),
    output:
        multiext(f"{RESULTS}/tables/runtime", ".csv", ".md", ".tex", ".json"),
    log:
        f"{LOGS}/tables/runtime.log",
    params:
        made_of=made_of,
        episodes=episode_options,
        published=published_options,
        stem=subpath(output[0], strip_suffix=".csv"),
    message:
        "table of selection times"
    shell:
        "{AVS} --made-of {params.made_of} runtime_table"
        " {input.records} {params.episodes} {params.published} --settings {input.settings}"
        " --out {params.stem} --log {log}"


rule tables:
    input:
        expand(f"{RESULTS}/tables/nvs_{{dataset}}.csv", dataset=SCENES),
        paper_tables,
        SIGNIFICANCE,
        ranking_tables,
        scorer_tables,
        runtime_tables,
        tables_of_sensitivity,
        tables_of_representations,
        coverage_tables,
        coverage_figures,
        slam_tables,
        expand(f"{RESULTS}/figures/psnr_over_views_{{dataset}}.pdf", dataset=SCENES),

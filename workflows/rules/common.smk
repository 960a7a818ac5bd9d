# What the rules share: the checked configuration, the paths, and which source files a job depends on.

import json
import sys
from pathlib import Path

sys.path.insert(0, str(workflow.basedir))

from avs.selection import registry
from avs.config.configuration import load, protocol_of
from avs.system.errors import UserError
from avs.iqa.cross_reference.published_weights import published_weights
from avs.system.code_inputs import sources

# Methods that are programs of their own, each a file of rules of the method's name.
BASELINES = sorted(Path(workflow.basedir, "workflows", "baselines").glob("*.smk"))
PROGRAMS = [path.stem for path in BASELINES]

try:
    settings = load(config, PROGRAMS)
except UserError as error:
    sys.exit(f"error: {error}")

RESULTS = f"results/{settings.scale}"
LOGS = f"{RESULTS}/logs"

# Why a method cannot run here, and what cures it. Its row in the tables says so; no episode of it is asked for.
ABSENT = {
    method: reason
    for method in settings.methods
    if method not in PROGRAMS
    and (reason := registry.unavailable(method, fits=settings.distortions is not None))
}
RUNNABLE = [method for method in settings.methods if method not in ABSENT]

# Says that the kernels have been compiled here. Jobs take it as ancient(): they wait for it and never rerun for it.
KERNELS = f"{RESULTS}/kernels"

# exec: the job becomes Snakemake's own child, so that it ends with it (see avs/system/jobs.py).
AVS = "exec python -m avs"


wildcard_constraints:
    scene="[a-z0-9_]+",
    dataset="[a-z0-9_]+",
    pattern="[a-z]+",
    method="[a-z0-9-]+",
    scorer="[a-z0-9]+",
    seed="[0-9]+",
    part="[a-z0-9_/-]+",


def section(part):
    """Return the values of the settings file `part`: what one kind of job reads of the configuration."""
    stage, _, name = part.partition("/")
    common = settings.model_dump(mode="json")
    if stage == "episode":
        return {
            "device": common["device"],
            "representation": common["representation"],
            "protocol": protocol_of(settings, name).model_dump(mode="json"),
            "method": name,
            "selector": common["selectors"].get(name, {}),
        }
    if stage == "runtime":
        shared = ("device", "protocol", "representation", "runtime")
        return {key: common[key] for key in shared} | timing(name)
    if stage == "runtime_table":
        return {"methods": common["methods"], "absent": NOT_TIMED}
    if stage == "distortions":
        picked = {key: common[key] for key in ("device", "representation")}
        return picked | {"renders": common["distortions"]["renders"]}
    if stage == "refit":
        checked = registry.create_settings(name, settings.selectors.get(name, {}))
        return checked.model_dump(mode="json", include={"resize", "refit"})
    if stage == "training":
        return {"device": common["device"], "scorer": common["scorers"][name]}
    if stage == "table":
        return {
            "methods": common["methods"],
            "absent": ABSENT,
            "published": published(name),
        }
    if stage == "figure":
        return {"methods": common["methods"]}
    return {"embedded": common["embedded"]["capture"], "captures": common["captures"]}[
        stage
    ]


def timing(name):
    """Return what the timing of a method reads beyond what all methods share; nothing for `state`, which they share."""
    if name == "state":
        return {}
    return {
        "method": name,
        "selector": settings.selectors.get(name, {}),
        "views_per_step": protocol_of(settings, name).views_per_step,
    }


def section_json(wildcards):
    """Return the values of a settings file as JSON with sorted keys, so that equal settings are equal text."""
    return json.dumps(section(wildcards.part), sort_keys=True)


rule kernels:
    input:
        code=sources("avs.representations.gaussians.compilation"),
    output:
        touch(KERNELS),
    log:
        f"{LOGS}/kernels.log",
    priority: 3
    message:
        "compilation of the CPU kernels"
    shell:
        "{AVS} kernels --log {log}"


rule settings:
    output:
        f"{RESULTS}/settings/{{part}}.json",
    log:
        f"{LOGS}/settings/{{part}}.log",
    params:
        values=section_json,
    message:
        "settings of {wildcards.part}"
    shell:
        "{AVS} settings {params.values:q} --out {output} --log {log}"

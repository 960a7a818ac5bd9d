# What the rules share: the checked configuration, the paths, and which source files a job depends on.

import os
import shlex
import sys
from pathlib import Path

sys.path.insert(0, str(workflow.basedir))

from avs.config.configuration import load
from avs.config.configuration_files import check_files, check_options
from avs.config.jobs import settings_of
from avs.config.lost_data_sets import without_lost
from avs.config.method_weights import (
    Made,
    absent_methods,
    check_named_files,
    weights_of,
)
from avs.datasets import reader_registry
from avs.representations import kinds
from avs.selection import registry
from avs.system import job_server, numerics
from avs.sfm import back_end_registry
from avs.system.code_inputs import sources, sources_of_inputs, with_contents
from avs.system.errors import UserError
from avs.system.records import record_text

# Methods that are programs of their own, each a file of rules of the method's name.
BASELINES = sorted(Path(workflow.basedir, "workflows", "baselines").glob("*.smk"))
PROGRAMS = [path.stem for path in BASELINES]

if workflow.is_main_process:
    for module, fault in (
        registry.broken()
        | reader_registry.broken()
        | kinds.broken()
        | back_end_registry.broken()
    ).items():
        print(f"warning: {module} is left out: {fault}", file=sys.stderr)

if workflow.config_settings.config.get("scenes_dir", "any") in (None, ""):
    sys.exit("error: --config scenes_dir=: names no folder; name one, or leave it out")

try:
    if workflow.is_main_process:
        check_options(sys.argv, workflow.config_settings.config)
    check_files(workflow.configfiles)
    settings, LOST = without_lost(load(config, PROGRAMS))
    check_named_files(settings)
except UserError as error:
    sys.exit(f"error: {error}")


def tell_what_is_lost():
    """Tell of data sets that are left out, and of what is made of their scenes alone."""
    for name, reason in LOST.items():
        print(f"left out: {name}: {reason}", file=sys.stderr)


if workflow.is_main_process:
    tell_what_is_lost()

# All jobs inherit it, wherever they run, and what they are made of (see made_of, below) depends on it.
os.environ[numerics.VARIABLE] = settings.numerics

REPRESENTATION = kinds.find(settings.representation.kind)

RESULTS = f"results/{settings.scale}"
LOGS = f"{RESULTS}/logs"

# Tells of a change in the files that a job reads, whatever their times: a parameter of each rule, which the job keeps in
# the list beside its log (see integrity.smk).
made_of = sources_of_inputs(RESULTS)

# No episode is asked for of a method that cannot run here; its row in the tables says why.
ABSENT = absent_methods(settings)
RUNNABLE = {
    dataset: [method for method in settings.methods_on(dataset) if method not in ABSENT]
    for dataset in settings.evaluated
}

# Says that the kernels of a kind of representations have been compiled here: a file for each kind, so that one more kind
# in the configuration makes nothing again. No job takes it as ancient(): Snakemake 9.27 does not look at the reasons of a
# job of its own while one that it depends on is to run, and so would pass over a change of code that both read.
KERNELS = f"{RESULTS}/compiled/{{kind}}"
OWN_KERNELS = KERNELS.format(kind=settings.representation.kind)

# The code that the run was planned with; a job fails that finds another one.
CODE = f"{RESULTS}/code.sha256"

# The interpreter is Snakemake's own, whatever PATH names. exec: the job becomes Snakemake's own child, so that it ends with
# it (see avs/system/job_process.py).
AVS = f"exec {shlex.quote(sys.executable)} -m avs --planned-with {CODE}"


wildcard_constraints:
    scene="[a-z0-9_]+",
    dataset="[a-z0-9_]+",
    method="[a-z0-9-]+",
    scorer="[a-z0-9]+",
    kind="[^/]+",
    seed="[0-9]+",
    job="[a-z0-9_/-]+",


def settings_text(wildcards):
    """Return the text of a settings file: what the jobs that read it are told. Equal settings are equal text."""
    return record_text(settings_of(settings, wildcards.job)).strip()


def repeated(option, paths):
    """Return ``paths`` as arguments of a command's option that can be given again and again."""
    return [f"{option} {path}" for path in paths]


def asked_for(*targets):
    """Return the files that the inputs of targets name, each once, in order."""
    found = [
        each(None) if callable(each) else each for target in targets for each in target
    ]
    paths = [
        path for each in found for path in ([each] if isinstance(each, str) else each)
    ]
    return list(dict.fromkeys(map(str, paths)))


def code_of_methods():
    """Return the files that the methods found here are made of, those that are installed and data beside them, too."""
    modules = {each.module for each in registry.methods().values()}
    return {path for module in modules for path in sources(module)}


def compiling_code(wildcards):
    """Return the source files of what compiles the kernels of a kind; none where it has no kernels."""
    told = kinds.find(wildcards.kind).compile
    return sources(told.partition(":")[0]) if told else []


rule kernels:
    input:
        code=compiling_code,
    output:
        touch(KERNELS),
    log:
        f"{LOGS}/kernels/{{kind}}.log",
    priority: 3
    message:
        "compilation of the CPU kernels of {wildcards.kind}"
    shell:
        "{AVS} kernels {wildcards.kind} --log {log}"


# One file for each kind of job, and no process of Python for each file.
rule settings:
    output:
        f"{RESULTS}/settings/{{job}}.json",
    priority: 3  # no other job starts without one
    localrule: True  # on a cluster, too: a submission takes longer than such a job
    params:
        text=settings_text,
    message:
        "settings of {wildcards.job}"
    shell:
        "printf '%s\\n' {params.text:q} > {output}.part && mv {output}.part {output}"

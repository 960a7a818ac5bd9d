# Active view selection: every method on the same scenes, reconstruction, budget and metrics.
#
#   snakemake -j2 tables                                              the embedded scenes, minutes on two cores
#   snakemake -j2 tables --configfile workflows/config/small.yaml --config scenes_dir=DIR      your own captures

import shutil
import subprocess
import sys
import time
from pathlib import Path

STARTED = time.time()  # a table that is older is not of this run

if Path.cwd() != Path(workflow.basedir).resolve():
    sys.exit(
        f"error: {Path.cwd()}: is not the folder of the workflow, from which its paths start; add --directory {workflow.basedir}"
    )

if "scale" not in config:
    if workflow.config_settings.configfiles:
        given = " ".join(str(path) for path in workflow.config_settings.configfiles)
        sys.exit(
            f"error: {given}: no scale is named; give all files after one --configfile, the base first: "
            "--configfile workflows/config/ci.yaml mine.yaml"
        )

    configfile: "workflows/config/ci.yaml"


include: "workflows/rules/common.smk"
include: "workflows/rules/data.smk"
include: "workflows/rules/scorer.smk"
include: "workflows/rules/metric_parameters.smk"
include: "workflows/rules/nvs.smk"
include: "workflows/rules/held_out.smk"
include: "workflows/rules/runtime.smk"
include: "workflows/rules/sensitivity.smk"
include: "workflows/rules/agnostic.smk"
include: "workflows/rules/sfm.smk"
include: "workflows/rules/slam.smk"
include: "workflows/rules/paper_tables.smk"
include: "workflows/rules/significance.smk"
include: "workflows/rules/report.smk"
include: "workflows/rules/figures.smk"
include: "workflows/rules/page.smk"
include: "workflows/rules/own_report.smk"


for baseline in BASELINES:

    include: str(baseline)


localrules:
    tables,
    figures,
    all,


rule all:
    default_target: True
    input:
        rules.tables.input,
        rules.figures.input,


include: "workflows/rules/integrity.smk"


onstart:
    set_outdated_aside()
    write_plan()
    write_sources(Path(CODE), code_of_methods())
    if workflow.local_exec and settings.device == "cpu":
        job_server.start()


onsuccess:
    shutil.rmtree(INCOMPLETE, ignore_errors=True)
    # The first data set's view synthesis is what most readers look for: it is the last on the screen.
    names = [
        f"{kind}_{dataset}.md"
        for kind in ("coverage", "nvs")
        for dataset in reversed(SCENES)
    ]
    paths = [
        Path(f"{RESULTS}/tables/{name}") for name in ("active_slam.md", *names)
    ]
    made = [
        path for path in paths if path.exists() and path.stat().st_mtime > STARTED
    ]
    for path in made:
        print(f"\n{path.read_text()}")
    if made:
        print(f"All tables: {RESULTS}/tables; figures: {RESULTS}/figures")
    tell_what_is_lost()  # again: its first line is far above
    page = Path(f"{RESULTS}/report/index.html")
    if page.exists() and page.stat().st_mtime > STARTED:
        print(f"The page, to be opened in a browser: {page}")


onerror:
    print("\nTables of what is there:\n", flush=True)
    subprocess.run([sys.executable, "-m", "avs", "report", RESULTS])
    print(
        "Some jobs failed; their logs are named above. Once the cause is corrected, run the same line again."
    )
    print(
        "After a kill:  python -m avs resume -j2 tables   (followed by the options of the first run)"
    )

"""Lays out the project in a temporary folder, with settings that take seconds."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[2]
CODE = ("avs", "metrics")
COPIED = ("Snakefile", "workflows", "profiles", "results/published")
METHODS = ("random", "farthest")
_FOR_SCORERS = ("handheld_training", "handheld_held_out")


def checkout(folder, linked=CODE, copied=CODE):
    """Lay out the project in ``folder``; code that is linked shares its compiled kernels with this checkout."""
    for name in COPIED:
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (ROOT / name).is_dir() else shutil.copy2)(ROOT / name, target)
    for name in CODE:
        if name in linked:
            (folder / name).symlink_to(ROOT / name)
        elif name in copied:
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "tiny.yaml").write_text(yaml.safe_dump(tiny()))
    return folder


def checkout_open_to(folder, room):
    """Lay out the project in ``folder`` so that files can be added to ``avs/<room>``; all the rest is linked."""
    checkout(folder, linked=("metrics",), copied=())
    opened = folder / "avs" / room
    opened.mkdir(parents=True)
    for target, link in ((ROOT / "avs", folder / "avs"), (ROOT / "avs" / room, opened)):
        for path in target.iterdir():
            if path.name not in (room, "__pycache__"):
                (link / path.name).symlink_to(path)
    return folder


def tiny():
    """Return the ci scale cut down to seconds."""
    values = yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text())
    values |= {"scale": "tiny", "methods": list(METHODS), "scorers": {}, "selectors": {}, "method_protocols": {}}
    values |= {"seeds": [0], "runtime": None, "sensitivity": None, "coverage": None, "slam": None, "agnostic": None}
    values["datasets"] = {name: values["datasets"][name] for name in ("orbit", *_FOR_SCORERS)}
    values["distortions"] |= {"training": [_FOR_SCORERS[0]], "held_out": [_FOR_SCORERS[1]], "representations": {}}
    values["datasets"]["orbit"] |= {"seeds": [0]}
    for dataset in values["datasets"].values():
        dataset["capture"] = {"views": 16, "long_side": 48}
    values["protocol"] |= {"budget": 6, "additions": [4, 8], "iterations": 12}
    values["common_states"] = {"views": [5], "gain_candidates": 3, "gain_passes": 1}
    return values


def environment():
    """Return the variables of a process that runs the interpreter of the tests."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    return os.environ | {"PATH": path, "PYTHONPATH": ""}


def run(folder, *arguments, command=("snakemake",)):
    """Run the workflow in ``folder`` with its ``tiny.yaml`` and return the finished process."""
    words = [*command, *arguments, "--configfile", "tiny.yaml"]
    return subprocess.run(words, cwd=folder, env=environment(), capture_output=True, text=True, check=False)

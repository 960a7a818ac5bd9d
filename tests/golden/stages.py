"""The stages whose results golden.json lists: libraries, then jobs of every kind, each on what came before."""

import hashlib
import importlib.metadata
import json
import subprocess
import sys
from pathlib import Path

import yaml

from avs.config.configuration import load
from avs.config.jobs import settings_of
from avs.system import numerics
from avs.system.records import record_text
from tests.workflow.project import ROOT, environment, tiny
from tests.workflow.test_slam_workflow import SLAM

GOLDEN = Path(__file__).with_name("golden.json")
PATTERNS = ("handheld", "orbit", "walkthrough", "egocentric")
METHODS = ("activenerf", "fisherrf", "popgs", "warprf", "ours-lite0")
PACKAGES = ("numpy", "scipy", "torch", "numba", "llvmlite", "opencv-python-headless", "open3d-cpu", "pillow", "timm")
_VARIES = (".meta.json", ".log", ".sha256")
"""Endings of files that tell of the machine and the time."""


def expected():
    """Return the digest of each stage that golden.json lists."""
    return json.loads(GOLDEN.read_text())["digests"]


def kind_of_processor():
    """Return the maker's name and the widest of the instructions by which libraries choose their code."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    maker = next(line.split(":")[1].strip() for line in lines if line.startswith("vendor_id"))
    return f"{maker} {'AVX-512' if numerics.has_avx512() else 'AVX2'}"


def kinds_that_agree():
    """Return the kinds of processor on which all stages are known to end in the listed bits."""
    return json.loads(GOLDEN.read_text())["agreed"]


def versions():
    """Return the versions of all packages whose results the digests depend on."""
    return {name: importlib.metadata.version(name) for name in PACKAGES}


def reason_not_to_compare():
    """Return why results here need not be those of golden.json, or None."""
    if numerics.in_force() != "portable":
        return f"no portable numerics: for Linux on x86-64 with {', '.join(numerics.NEEDED)}"
    known, here = json.loads(GOLDEN.read_text())["packages"], versions()
    other = [f"{name} {here[name]} instead of {known[name]}" for name in known if here[name] != known[name]]
    return f"other packages: {', '.join(other)}" if other else None


def config():
    """Return the configuration of all jobs: the smallest of the tests, with each pattern, a scorer and explorations."""
    values = tiny()
    values["methods"] = [*METHODS, "random"]
    ci = yaml.safe_load((ROOT / "workflows" / "config" / "ci.yaml").read_text())
    lite0 = ci["scorers"]["lite0"]
    values["scorers"] = {"lite0": lite0 | {"training": lite0["training"] | {"steps": 20}}}
    values["distortions"] |= {"renders": {"views": [4, 8], "iterations": [30, 60], "cameras": 8}}
    values["datasets"] |= {
        f"golden_{pattern}": {
            "source": "embedded",
            "pattern": pattern,
            "seeds": [7],
            "capture": {"views": 12, "long_side": 64},
        }
        for pattern in PATTERNS
    }
    values["agnostic"] = ci["agnostic"] | {"datasets": ["golden_orbit"], "protocol": values["protocol"]}
    return load(values | {"coverage": {"views": [4]}, "slam": SLAM})


def jobs(folder):
    """Yield the name of each stage, the command of its job, and what the job writes.

    Args:
        folder: where the jobs write, each to a place of its own.
    """
    told = config()

    def settings(job):
        path = folder / "settings" / f"{job}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(record_text(settings_of(told, job)))
        return ["--settings", path]

    def scene(data_set, name):
        out = folder / data_set
        return [f"scene of {data_set}", ["scene", *settings(f"scene/{data_set}/{name}"), "--out", out], [out]]

    for pattern in PATTERNS:
        yield scene(f"golden_{pattern}", f"{pattern}_7")
    orbit = folder / "golden_orbit"
    renders = {}
    for kind, seed in (("training", 100), ("held_out", 106)):
        data_set = f"handheld_{kind}"
        yield scene(data_set, f"handheld_{seed}")
        renders[kind] = folder / f"{kind}.safetensors"
        words = ["distortions", folder / data_set, 0, *settings("distortions"), "--out", renders[kind]]
        yield f"distortions for {kind}", words, [renders[kind]]
    weights, card = folder / "lite0.safetensors", folder / "lite0.json"
    words = ["scorer_train", *settings("scorer_train/lite0"), "--weights", weights, "--card", card]
    yield "scorer", [*words, "--training", renders["training"], "--held-out", renders["held_out"]], [weights]
    for method in METHODS:
        out = folder / method
        given = ["--weights", weights] if method == "ours-lite0" else []
        yield f"episode of {method}", ["episode", orbit, 0, *settings(f"episode/{method}"), *given, "--out", out], [out]
    for representation in ("tensorf", "nerfacto"):
        out = folder / representation
        words = ["episode", orbit, 0, *settings(f"agnostic_episode/{representation}/random"), "--out", out]
        yield f"episode on {representation}", words, [out]
    reference = folder / "reference"
    words = ["coverage_reference", orbit, *settings("coverage_reference"), "--out", reference]
    yield "cloud of all views", words, [reference]
    flat, out = folder / "flat", folder / "exploration"
    yield "building", ["building", *settings("building/flat"), "--out", flat], [flat]
    words = ["exploration", flat / "mesh.ply", "flat", "fvs", 0, *settings("exploration/flat/fvs"), "--out", out]
    yield "exploration", words, [out]


def digests(folder, emulator=(), libraries_alone=False):
    """Yield each stage with a digest of what it computes.

    Args:
        folder: an empty folder to work in.
        emulator: the words that go before the interpreter, such as ``("qemu-x86_64", "-cpu", "Haswell")``.
        libraries_alone: whether to stop before the jobs.

    Raises:
        AssertionError: a job failed; its output is in the message.
    """
    python = [*emulator, sys.executable]
    for line in _run([*python, ROOT / "tests" / "golden" / "operations.py"]).splitlines():
        yield tuple(line.split("\t"))
    for name, words, written in () if libraries_alone else jobs(folder):
        _run([*python, "-m", "avs", *words])
        yield name, _digest(written)


def _run(words):
    done = subprocess.run(
        [str(word) for word in words], cwd=ROOT, env=environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def _digest(written):
    files = sorted(
        path for each in written for path in ([each] if each.is_file() else each.rglob("*")) if path.is_file()
    )
    found = hashlib.sha256()
    for path in files:
        if not path.name.endswith(_VARIES):
            found.update(path.name.encode() + hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()

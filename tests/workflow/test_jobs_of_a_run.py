"""A run's jobs, which its server forks, make what the same commands make by themselves."""

import shutil
import subprocess
import sys

import pytest

from tests.workflow.project import checkout, environment

RESULTS = "results/tiny"

# Each process of Python tells at its end what it was started as; one that waits for the server ends without.
TELLING = """
import atexit, pathlib, sys
told = pathlib.Path(__file__).with_name("told")
atexit.register(lambda: told.open("a").write(" ".join(sys.orig_argv[1:4]) + "\\n"))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the server is for Linux")
def test_the_jobs_of_a_run_are_forked_from_its_server(finished, tmp_path):
    folder = checkout(tmp_path / "run")
    for name in (RESULTS, ".snakemake"):
        shutil.copytree(finished / name, folder / name)
    for path in (folder / RESULTS / "tables").glob("nvs_orbit*"):
        path.unlink()
    (tmp_path / "sitecustomize.py").write_text(TELLING)
    words = ["snakemake", "-j2", "tables", "--configfile", "tiny.yaml"]
    variables = environment() | {"PYTHONPATH": str(tmp_path)}
    result = subprocess.run(words, cwd=folder, env=variables, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    told = (tmp_path / "told").read_text().splitlines()
    assert any(line.startswith("-m avs.system.job_server") for line in told)
    assert not any(line.startswith("-m avs --planned-with") for line in told)


@pytest.mark.parametrize("method", ["random", "farthest"])
def test_an_episode_of_a_run_has_the_bytes_of_one_that_is_made_by_itself(finished, tmp_path, method):
    settings = f"{RESULTS}/settings/episode/{method}.json"
    words = ["episode", f"{RESULTS}/scenes/orbit/orbit_0", "0", "--settings", settings, "--out", str(tmp_path)]
    command = [sys.executable, "-m", "avs", *words, "--log", str(tmp_path / "log")]
    subprocess.run(command, cwd=finished, env=environment(), check=True)
    made = finished / RESULTS / "episodes" / "orbit" / "orbit_0" / method / "0"
    for name in ("episode.json", "splats.ply"):
        assert (made / name).read_bytes() == (tmp_path / name).read_bytes()

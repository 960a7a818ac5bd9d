"""The page on adding a method, executed: its three methods come out as rows of the table."""

import csv
import re
import shutil
import subprocess
import sys

import pytest
import yaml

from tests.workflow.project import ROOT, checkout, checkout_open_to, environment, tiny
from tests.workflow.test_slam_workflow import SLAM

PAGE = (ROOT / "docs" / "add-a-baseline.md").read_text()
BLOCKS = dict(re.findall(r"^```\w+ (\S+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))
COMMANDS = re.findall(r"^```bash\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture(scope="module")
def followed(finished, tmp_path_factory):
    """A finished run to which the methods of the page have been added."""
    folder = checkout_open_to(tmp_path_factory.mktemp("baselines"), "selectors")
    for name in ("results/tiny", ".snakemake"):
        shutil.copytree(finished / name, folder / name)
    for name, text in BLOCKS.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text)
    # Where the page installs into the environment, the test does into a folder of its own, without the network.
    command = [sys.executable, "-m", "pip", *COMMANDS[1].split()[1:], "--target", "packages"]
    offline = ["--no-build-isolation", "--no-deps", "--no-index", "--quiet", "--disable-pip-version-check"]
    subprocess.run([*command, *offline], cwd=folder, env=environment(), check=True)
    (folder / "workflows/config/ci.yaml").write_text(yaml.safe_dump(tiny()))
    variables = environment() | {"PYTHONPATH": str(folder / "packages")}
    result = subprocess.run(COMMANDS[0].split(), cwd=folder, env=variables, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    return folder


def test_every_method_of_the_page_has_its_row(followed):
    with open(followed / "results" / "tiny" / "tables" / "nvs_orbit.csv", newline="") as stream:
        rows = {row["method"]: row for row in csv.DictReader(stream) if row["metric"] == "psnr"}
    assert set(rows) == set(yaml.safe_load(BLOCKS["mine.yaml"])["methods"])
    assert {method: row["group"] for method, row in rows.items() if method != "random"} == {
        "emptiest": "2D-based",
        "bisection": "Geometric",
        "turn": "Geometric",
    }
    assert all(float(row["mean"]) > 0 for row in rows.values())


def test_a_method_of_the_page_explores_without_a_line_of_its_own(followed):
    values = tiny() | yaml.safe_load((followed / "mine.yaml").read_text())
    (followed / "buildings.yaml").write_text(yaml.safe_dump(values | {"slam": SLAM}))
    words = ["snakemake", "-j1", "explore", "--configfile", "buildings.yaml", "exploring.yaml"]
    variables = environment() | {"PYTHONPATH": str(followed / "packages")}
    result = subprocess.run(words, cwd=followed, env=variables, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "| Emptiest |" in (followed / "results/tiny/tables/active_slam.md").read_text()


def test_a_score_has_less_than_twenty_five_lines_a_file_with_settings_fifty_and_a_rule_three():
    assert BLOCKS["turn/avs_turn.py"].count("\n") < 25
    assert BLOCKS["avs/selectors/emptiest.py"].count("\n") < 50
    assert BLOCKS["workflows/baselines/bisection.smk"].count("\n") == 3


def test_the_views_of_a_program_are_those_of_its_episode(followed):
    from avs.nvs.program import ViewList
    from avs.nvs.record import Episode
    from avs.system.records import read_record

    folder = followed / "results/tiny/episodes/orbit/orbit_0/bisection/0"
    listed = read_record(folder / "views.json", ViewList, edited=True)  # a program writes no digest
    episode = read_record(folder / "episode.json", Episode)
    wanted = [name for name in listed.views if name not in episode.initial]
    assert episode.selected == wanted[: len(episode.selected)]
    assert episode.label == "Bisection"


def test_an_edit_of_a_program_reruns_its_views_and_its_episodes(followed):
    with open(followed / "bisection.py", "a") as stream:
        stream.write("# an edit\n")
    variables = environment() | {"PYTHONPATH": str(followed / "packages")}
    words = [*COMMANDS[0].split(), "-n"]
    result = subprocess.run(words, cwd=followed, env=variables, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    jobs = {rule: int(count) for rule, count in re.findall(r"^(\w+)\s+(\d+)$", result.stdout, re.MULTILINE)}
    assert (jobs["views_bisection"], jobs["episode"]) == (1, 1)
    assert not {"scene", "settings"} & jobs.keys()


def test_a_program_with_the_name_of_a_method_is_one_line(tmp_path):
    folder = checkout(tmp_path)
    (folder / "workflows" / "baselines" / "random.smk").write_text("")
    words = ["snakemake", "-n", "tables", "--configfile", "tiny.yaml"]
    result = subprocess.run(words, cwd=folder, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode != 0
    (line,) = [text for text in (result.stdout + result.stderr).splitlines() if text.startswith("error: ")]
    assert "method random: is a method of avs.selectors.random and a program as well" in line

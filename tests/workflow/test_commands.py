"""Every rule calls the command of its own name, and a stage's commands are where its rules are."""

import ast
import importlib
import inspect
import re
import subprocess
import sys
import textwrap

import pytest
import typer

from avs.commands import weights
from avs.commands.main import STAGES, app
from tests.workflow.project import ROOT, environment

RULES = sorted((ROOT / "workflows" / "rules").glob("*.smk"))


def called(path):
    """Return the command that each rule of a file calls."""
    rules = re.split(r"^rule (?=\w+:$)", path.read_text(), flags=re.MULTILINE)[1:]
    commands = {rule.partition(":")[0]: re.search(r"\{AVS\} (\w+) ", rule) for rule in rules}
    return {rule: command[1] for rule, command in commands.items() if command}


def names(typer_app):
    return {command.name or command.callback.__name__ for command in typer_app.registered_commands}


@pytest.mark.parametrize("path", RULES, ids=lambda path: path.stem)
def test_a_rule_calls_the_command_of_its_name_in_the_file_of_its_stage(path):
    commands = called(path)
    assert all(rule == command for rule, command in commands.items())
    if commands:
        assert commands.keys() <= names(importlib.import_module(f"avs.commands.{path.stem}").commands)


def test_a_damaged_settings_file_is_one_line(tmp_path):
    settings = tmp_path / "settings.json"
    settings.write_text('{"dataset": "orbit", "scene": {"source": "embedded", "pattern": "orbit", "seeds": [0')
    words = [sys.executable, "-m", "avs", "scene", "--settings", str(settings), "--out", str(tmp_path / "scene")]
    result = subprocess.run(words, cwd=ROOT, env=environment(), capture_output=True, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith(f"error: {settings}: is not a JSON object")
    assert not (tmp_path / "scene").exists()


def test_no_two_stages_have_a_command_of_one_name():
    counted = [name for stage in STAGES for name in names(stage.commands)]
    assert len(counted) == len(set(counted))
    assert len(app.registered_groups) == len(STAGES) + 2  # weights and data


@pytest.mark.parametrize("stage", [*STAGES, weights], ids=lambda stage: stage.__name__)
def test_every_argument_and_option_says_what_it_is(stage):
    """Each command runs inside the guard that ends it with one line, too."""
    group = typer.main.get_command(stage.commands)
    commands = getattr(group, "commands", {"": group}).values()
    for command in commands:
        assert command.help, command.name
        assert all(parameter.help for parameter in command.params), command.name
    for registered in stage.commands.registered_commands:
        assert "with job(" in inspect.getsource(registered.callback)


@pytest.mark.parametrize("stage", [*STAGES, weights], ids=lambda stage: stage.__name__)
def test_a_command_imports_inside_of_its_job_so_that_a_failed_import_is_in_its_log(stage):
    for command in stage.commands.registered_commands:
        (function,) = ast.parse(textwrap.dedent(inspect.getsource(command.callback))).body
        assert not any(isinstance(part, ast.Import | ast.ImportFrom) for part in function.body), command.callback

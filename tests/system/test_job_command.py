"""What the workflow and a job take for its command is the same, and tells of order and use of what it reads."""

import shlex

import pytest

from avs.system.job_command import command_digest, digest_of_line

OPTIONS = "--planned-with results/ci/code.sha256 --made-of abc --read a --read b"


@pytest.mark.parametrize(
    "command",
    [
        "scene_table a.json b.json --dataset orbit --out tables/x",
        "scene_table 'a b.json' --out \"it's\" c\\ d",
        "kernels",
    ],
)
def test_a_line_of_the_shell_and_the_words_of_its_process_are_one(command):
    line = f"exec '/a folder/python3' -m avs {OPTIONS} {command}"
    words = shlex.split(line)[4:]
    assert digest_of_line(line) == command_digest(words) == command_digest(shlex.split(command))


def test_order_and_use_count_and_options_of_all_commands_do_not():
    told = "exec python3 -m avs {} scorer_train --training {} --held-out {}"
    digests = {
        digest_of_line(told.format(options, *files))
        for options in (OPTIONS, "--made-of other --read c")
        for files in (("a", "b"), ("b", "a"))
    }
    assert len(digests) == 2

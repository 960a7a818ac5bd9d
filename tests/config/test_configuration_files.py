"""What YAML passes over in silence is one line."""

import pytest
from snakemake.cli import parse_args, parse_config

from avs.config.configuration_files import check_files, check_options
from avs.system.errors import UserError

FAULTS = {
    "seeds: [0]\nmethods: [random]\nseeds: [1]\n": "line 3: seeds is there twice in one section, first in line 1",
    "a: {b: 1, b: 2}\n": "line 1: b is there twice in one section, first in line 1",
    '{"a": 1,\n "a": 2}': "line 2: a is there twice in one section, first in line 1",
    "seeds: [1, 010]\n": "line 1: 010 is the octal number 8",
}


@pytest.mark.parametrize("text", FAULTS)
def test_a_key_that_is_there_twice_and_an_octal_number_are_told(text, tmp_path):
    (tmp_path / "mine.yaml").write_text(text)
    with pytest.raises(UserError) as caught:
        check_files([tmp_path / "mine.yaml"])
    assert str(caught.value).startswith(f"{tmp_path / 'mine.yaml'}: {FAULTS[text]}; ")


@pytest.mark.parametrize(
    "text", ["a: &a {b: 1}\nc: {<<: *a, b: 2}\nd: *a\n", "a: [0, 10, '010', 1.05]\n", "", "a: [\n", "- 1\n- 1\n"]
)
def test_all_else_passes(text, tmp_path):
    (tmp_path / "mine.yaml").write_text(text)
    check_files([tmp_path / "mine.yaml", tmp_path / "absent.yaml"])


def read(words):
    """Return what Snakemake makes of the values of ``--config``."""
    return parse_config(parse_args(words)[1].config)


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (["--config", "scenes_dir=a #b"], "--config scenes_dir: a #b would be read as a: it is taken for YAML"),
        (["--config", "device=cpu", "scenes_dir='a #b'"], "write --config 'scenes_dir= \"a #b\" ', with both blanks"),
        (["--config=scenes_dir=a #b"], "a #b would be read as a"),
        (["-C", "scenes_dir=a ", "-j1"], "a  would be read as a"),
        (["--config", "scenes_dir=a", "--config", "device=cpu"], "--config scenes_dir: is lost: of several options"),
    ],
)
def test_a_value_that_snakemake_cuts_or_loses_is_told(options, fault):
    with pytest.raises(UserError) as caught:
        check_options(["snakemake", "tables", *options], read(["tables", *options]))
    assert fault in str(caught.value)


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--config", "scenes_dir=a#b", "seeds=[0, 1]", "--configfile", "key=a #b"],
        ["--config", 'scenes_dir= "a #b" '],
        ["--config", "scenes_dir=''", "runtime={scene: x}"],
        ["-C", "scenes_dir=a", "-C", "scenes_dir=b c"],
    ],
)
def test_values_that_snakemake_reads_as_they_are_given_pass(options):
    check_options(["snakemake", *options], read(options))

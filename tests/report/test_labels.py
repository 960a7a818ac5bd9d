"""Labels that look alike are told apart by identifiers, whatever they hold that nobody sees."""

import pytest

from avs.report.collect import read_dataset
from avs.report.collect_explorations import printed_name
from avs.report.collect_held_out import read_held_out
from avs.report.formats.plain_text import one_line
from avs.report.labels import group_of, told_apart
from avs.report.methods import presented, presented_in_columns
from avs.report.tables.selection_times_numbers import read_runtimes
from avs.system.records import write_record
from tests.report.test_scorer_agreement import record
from tests.report.timing_records import make_record

LIKE_FVS = {
    "a blank at its end": "FVS ",
    "a blank at its begin": "\tFVS",
    "a wide blank": "FVS\u2003",
    "a blank that does not break": "\u00a0FVS",
    "a space of no width": "FVS\u200b",
    "a space of no width behind a blank": "FVS \u200b",
    "a mark of the order of bytes": "\ufeffFVS",
    "a soft hyphen": "F\u00adVS",
    "a joiner of words": "FV\u2060S",
    "a joiner of graphemes": "F\u034fVS",
    "a selector of a variant": "FVS\ufe0f",
    "a filler of Hangul": "FVS\u3164",
    "Braille without a dot": "FVS\u2800",
    "a turn of the direction": "\u202dFVS\u202c",
    "wide letters": "\uff26\uff36\uff33",
    "accents of its own": "FVS\u0327",
}


@pytest.mark.parametrize("label", LIKE_FVS.values(), ids=LIKE_FVS)
def test_labels_that_look_alike_have_their_identifiers(label, episode, written):
    paths = written([episode("farthest"), episode("mine", label=label)])
    episodes = read_dataset(paths, ["farthest", "mine"], "orbit")
    names = [one_line(presented(method, episodes).label) for method in ("farthest", "mine")]
    assert names[0] == "FVS (farthest)"
    assert names[1].endswith(" (mine)")
    alone = read_dataset(paths[1:], ["mine"], "orbit")
    assert presented("mine", alone).label.endswith(" (mine)")  # the registered one has a row, too, without a value


def test_programs_of_two_data_sets_are_told_apart_in_a_table_of_both(episode, written):
    paths = written([episode("one", label="Own"), episode("two", label="Own ", dataset="room")])
    columns = [read_dataset(paths[:1], ["one"], "orbit"), read_dataset(paths[1:], ["two"], "room")]
    names = [presented_in_columns(method, columns).label for method in ("one", "two")]
    assert names == ["Own (one)", "Own (two)"]


def test_names_told_apart_are_not_those_of_others():
    labels = {"a": "FVS", "b": "FVS ", "c": "FVS (b)", "d": "Random\n walk", "e": "fvs", "f": "\u200b \u3164", "g": ""}
    expected = {"a": "FVS (a)", "b": "FVS (b)", "c": "FVS (b) (c)", "d": "Random walk", "e": "fvs", "f": "f", "g": "g"}
    found = told_apart(labels)
    assert found == expected | {"b": found["b"]}
    assert len(set(found.values())) == len(labels)


def test_what_can_be_seen_stays_as_it_is():
    labels = {"a": "Réseau 2", "b": "Reseau 3", "c": "网络", "d": "Σ-net", "e": "A  B"}
    assert told_apart(labels) == labels | {"e": "A B"}


@pytest.mark.parametrize("text", ["2D-based ", "2D-\u200bbased", "2D-based\u3164"])
def test_a_group_is_the_one_that_it_looks_like(text, episode, written):
    assert group_of(text) == "2D-based"
    episodes = read_dataset(written([episode("mine", group=text.replace("2D-based", "Oracle"))]), ["mine"], "orbit")
    expected = "2D-based" if "\u200b" in text else "Oracle"
    assert presented("mine", episodes).group == expected
    assert presented("mine", episodes).competes == (expected != "Oracle")
    assert group_of(" Learned\n ") == "Learned"


def test_explorations_of_one_look_are_told_apart():
    records = [type("Record", (), {"method": name, "label": label})() for name, label in (("a", "Own"), ("b", "Own "))]
    assert [printed_name(name, records) for name in ("a", "b", "c")] == ["Own (a)", "Own (b)", "c"]


def test_a_control_character_keeps_no_blank():
    assert one_line("FVS \u200b") == "FVS"
    assert one_line("a \u200b b\x00\tc") == "a b c"


def test_scorers_and_timed_methods_of_one_look_are_told_apart(tmp_path):
    scorers = record(
        first=("metric", "highest", lambda ssim, _: ssim), second=("metric", "lowest", lambda ssim, _: ssim)
    )
    alike = [each.model_copy(update={"label": f"Own{' ' * place}"}) for place, each in enumerate(scorers.scored)]
    write_record(tmp_path / "scores.json", scorers.model_copy(update={"scored": alike}))
    (read,) = read_held_out([tmp_path / "scores.json"], {"a_held_out": ["a_1"]})
    assert [each.label for each in read.scored] == ["Own (first)", "Own (second)"]
    paths = [tmp_path / "one.json", tmp_path / "two.json"]
    for path, label in zip(paths, ("Own", "Own\u200b"), strict=True):
        write_record(path, make_record(path.stem, label=label))
    assert [each.label for each in read_runtimes(paths).values()] == ["Own (one)", "Own (two)"]

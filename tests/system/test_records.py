"""Records: what was written is read, and nothing else."""

import json

import pytest
from factories import with_one_bit_flipped

from avs.system.errors import UserError
from avs.system.models import StrictModel
from avs.system.records import read_record, read_settings, record_text, write_record


class Measured(StrictModel):
    name: str
    values: list[float]


def read_or_fault(path):
    """Return the record, or None where its fault is one line that names it."""
    try:
        return read_record(path, Measured)
    except UserError as error:
        return None if str(path) in str(error) else error


RECORD = Measured(name="a", values=[0.1, 1e-300, 4.0])


def test_what_was_written_is_read(tmp_path):
    write_record(tmp_path / "record.json", RECORD)
    assert read_record(tmp_path / "record.json", Measured) == RECORD
    assert (tmp_path / "record.json").read_text() == record_text(RECORD)


def test_no_value_of_a_record_can_change_unseen(tmp_path):
    """A flipped bit gives a fault, or, in white space and in the spelling of an escape, the same record."""
    path = tmp_path / "record.json"
    write_record(path, RECORD)
    for changed in with_one_bit_flipped(path.read_bytes()):
        path.write_bytes(changed)
        assert read_or_fault(path) in (RECORD, None)


def test_one_digit_is_seen_and_the_line_names_the_file(tmp_path):
    path = tmp_path / "record.json"
    write_record(path, RECORD)
    path.write_text(path.read_text().replace("4.0", "4.5"))
    with pytest.raises(UserError, match=r"record.json: was changed after it was written; delete it and run again"):
        read_record(path, Measured)
    assert read_record(path, Measured, edited=True).values[-1] == 4.5


@pytest.mark.parametrize("text", ["", "[1]", "3", "{", '{"name": NaN, "values": []}', "\ufeff{}", "[" * 100_000])
def test_other_json_is_one_line(tmp_path, text):
    path = tmp_path / "record.json"
    path.write_text(text)
    with pytest.raises(UserError, match=r"record\.json"):
        read_record(path, Measured)


def test_a_record_without_a_digest_is_refused_unless_it_may_be_edited(tmp_path):
    path = tmp_path / "record.json"
    path.write_text(json.dumps({"name": "a", "values": [1.0]}))
    with pytest.raises(UserError, match="its digest is missing"):
        read_record(path, Measured)
    assert read_record(path, Measured, edited=True) == Measured(name="a", values=[1.0])


def test_settings_may_be_written_by_hand_and_are_checked_if_the_workflow_wrote_them(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text('{"name": "by hand", "values": []}')
    assert read_settings(path, Measured) == Measured(name="by hand", values=[])
    write_record(path, RECORD)
    assert read_settings(path, Measured) == RECORD
    path.write_text(path.read_text().replace("4.0", "4.5"))
    with pytest.raises(UserError, match=r"was changed after it was written; delete it .* or remove its digest"):
        read_settings(path, Measured)

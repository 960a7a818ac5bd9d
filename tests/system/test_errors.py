"""A fault is one line that any terminal can show."""

from avs.system.errors import UserError


def test_the_line_has_subject_fault_and_remedy():
    assert str(UserError("a.png", "is missing", "restore it")) == "a.png: is missing; restore it"


def test_what_a_damaged_file_brings_along_is_shown_and_not_acted_on():
    error = UserError("caf\u00e9\udce9.png", "holds \x1b[31m\0\u2028\u202e and\nmore", "copy it")
    assert str(error) == "caf\u00e9\\udce9.png: holds \\x1b[31m\\x00\\u2028\\u202e and more; copy it"
    str(error).encode()

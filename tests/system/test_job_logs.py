"""What the log of a job says of its end."""

import pytest

from avs.system.job_logs import fault_of, why_missing
from avs.system.ledger import write_ledger

TRACEBACK = 'Traceback (most recent call last):\n  File "a.py", line 1, in <module>\nValueError: no such thing\n'


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("step 1 of 2\nerror: a.png: damaged; copy it again\n\n", "a.png: damaged; copy it again"),
        (f"step 1 of 2\n{TRACEBACK}", "ValueError: no such thing"),
        (f"{TRACEBACK}    For further information visit https://pydantic.dev\n", "ValueError: no such thing"),
        ("error: a.png: damaged; copy it again\nend: PSNR 20\n", None),
        ("", None),
    ],
)
def test_the_last_line_tells(tmp_path, text, fault):
    (tmp_path / "log").write_text(text)
    assert fault_of(tmp_path / "log") == fault


def test_a_result_is_missing_for_the_first_fault_of_its_job_and_those_before_it(tmp_path):
    own, scene, weights = (tmp_path / name for name in ("own", "scene", "weights"))
    assert why_missing([own, scene]) == "its job has not run"
    own.write_text("step 1 of 2\n")
    assert why_missing([own, scene]) == "its job began and did not end"
    write_ledger(own, [])
    assert why_missing([own, scene]).startswith("what its job wrote is gone: moved or deleted")
    scene.write_text("done\n")
    weights.write_text("error: weights: damaged; fetch them\n")
    assert why_missing([own, scene, weights]) == "weights: damaged; fetch them"
    own.write_bytes(b"\xff\nerror: own: fault; remedy\n")
    assert why_missing([own, scene, weights]) == "own: fault; remedy"


def test_a_result_is_missing_for_a_program_before_it_that_failed_in_its_own_words(tmp_path):
    own, views, scene = (tmp_path / name for name in ("own", "views", "scene"))
    scene.write_text("done\n")
    write_ledger(scene, [])
    assert why_missing([own, views, scene]) == "its job has not run"
    views.write_text("reading\nno licence for this machine\n")
    told = f"a job that it waits for did not end; {views} ends with: no licence for this machine"
    assert why_missing([own, views, scene]) == told
    views.write_text("")
    told = f"printed nothing to {views}: if it did not start, Snakemake has told why above"
    assert why_missing([own, views, scene]).endswith(told)

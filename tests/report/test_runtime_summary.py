"""The paper's two tables of times: their rows and columns, the paper's values beside, methods that were not timed."""

import csv

import pytest

from avs.report.tables.runtime_summary import write_runtime_summary
from avs.system.reasons import Reason
from avs.system.records import write_record
from tests.report.timing_records import make_record

PUBLISHED = """table,dataset,scene,method,metric,value
tab,mipnerf360,garden,fisherrf,selection_seconds,8.34
tab,mipnerf360,garden,fisherrf,psnr,21.33
tab,mipnerf360,garden,fisherrf,gpu_memory_gb,15.8
"""


@pytest.fixture
def table(tmp_path, written):
    def write(summary, episodes, methods, absent=None):
        path = tmp_path / "record.json"
        write_record(path, make_record())
        (tmp_path / "published.csv").write_text(PUBLISHED)
        out = tmp_path / f"runtime_{summary}"
        beside = (methods, absent or {}, tmp_path / "published.csv", out)
        write_runtime_summary(summary, [path], written(episodes), *beside)
        with open(f"{out}.csv", newline="") as stream:
            rows = list(csv.DictReader(stream))
        return rows, out.with_suffix(".md").read_text()

    return write


def test_psnr_time_and_memory(episode, table):
    rows, markdown = table("memory", [episode("fisherrf")], ["fisherrf"])
    assert [(row["metric"], row["value"], row["published"]) for row in rows] == [
        ("psnr", "21.0000", "21.33"),
        ("selection_seconds", "0.30000", "8.34"),
        ("peak_memory_gb", "0.5120", "15.8"),
    ]
    heading = (
        "PSNR ↑ (dB) | published, Garden | Selection ↓ (s) | published, Garden | Memory ↓ (GB) | published, Garden"
    )
    assert f"|  | Method | {heading} |" in markdown
    assert "difference to it is printed" in markdown


def test_time_and_psnr_of_every_method(episode, table):
    absent = {"musiq": Reason(cause="weights musiq absent", remedy="fetch them")}
    rows, markdown = table("detail", [episode("fisherrf")], ["fisherrf", "musiq"], absent)
    assert [(row["method"], row["metric"], row["value"]) for row in rows] == [
        ("fisherrf", "selection_seconds", "0.30000"),
        ("fisherrf", "psnr", "21.0000"),
        ("musiq", "selection_seconds", ""),
        ("musiq", "psnr", ""),
    ]
    assert "| 2D-based | MUSIQ | weights musiq absent | – | – | – |" in markdown  # noqa: RUF001
    assert "Memory:" not in markdown

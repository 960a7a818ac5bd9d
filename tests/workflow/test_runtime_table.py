"""The table of selection times and the row of a method that cannot run, added to a finished run."""

import csv
import shutil

import yaml

from tests.workflow.project import METHODS, checkout, run, tiny


def rows_of(path, column):
    with open(path, newline="") as stream:
        return {(row["method"], row["metric"]): row[column] for row in csv.DictReader(stream)}


def test_tables_are_added_to_without_running_an_episode_again(finished, tmp_path, monkeypatch):
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "none"))
    folder = checkout(tmp_path / "timed")
    for name in ("results/tiny", ".snakemake"):
        shutil.copytree(finished / name, folder / name)
    settings = {"runtime": {"repeats": 2, "views": 5}, "methods": [*METHODS, "maniqa"]}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(tiny() | settings))
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "Job" in result.stderr
    assert "episode:" not in result.stderr

    tables = folder / "results" / "tiny" / "tables"
    nvs = {column: rows_of(tables / "nvs_orbit.csv", column) for column in ("mean", "published", "note")}
    assert nvs["mean"]["maniqa", "psnr"] == ""
    assert nvs["published"]["maniqa", "psnr"] == "19.54"
    assert "avs weights fetch maniqa" in nvs["note"]["maniqa", "psnr"]

    assert {path.suffix for path in tables.glob("runtime.*")} == {".csv", ".md", ".tex", ".json"}
    values, repeats = (rows_of(tables / "runtime.csv", column) for column in ("value", "repeats"))
    for method in METHODS:
        assert float(values[method, "psnr"]) > 0
        assert repeats[method, "selection_seconds"] == "2"
        # 16 views, of which two are test images and five captured
        assert values[method, "candidates"] == "9"
    assert "avs weights fetch maniqa" in rows_of(tables / "runtime.csv", "note")["maniqa", "selection_seconds"]

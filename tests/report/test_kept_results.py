"""A run is kept as the reference, and another is held to it value by value."""

import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from avs.commands.reference import commands
from avs.config.run_episodes import episodes_of_run
from avs.nvs.record import EpisodeMeta
from avs.report.kept_results import ABOUT, ReferenceRun, deviations, is_too_far, keep, not_compared, same_bits
from avs.system.errors import UserError
from avs.system.records import read_record, write_record

ROOT = Path(__file__).parents[2]
PER_SCENE = "method,metric,scene,seed,images,value\nrandom,psnr,a,0,6,20.1234\nrandom,psnr,a,1,6,21.0000\n"
PER_RUN = "building,method,seed,metric,value\nflat,random,0,scr_percent,50.0\nflat,random,0,plan_seconds,3.5\n"


def run(folder, numerics="portable", torch="2.13.0", **tables):
    """Make what is read of the results of a run."""
    episode = folder / "episodes" / "orbit" / "a" / "random" / "0"
    episode.mkdir(parents=True)
    (episode / "episode.json").touch()
    machine = {"processor": "Intel", "cores": "2", "system": "Linux x86_64", "python": "3.11.7", "numerics": numerics}
    meta = EpisodeMeta(
        steps=[],
        total_seconds=1.0,
        peak_memory_bytes=1,
        device="cpu",
        machine=machine,
        packages={"torch": torch},
        revision="abc",
        started="2026-01-01T00:00:00+00:00",
        finished="2026-01-01T00:00:01+00:00",
    )
    write_record(episode / "episode.meta.json", meta)
    (folder / "tables").mkdir(exist_ok=True)
    (folder / "figures").mkdir(exist_ok=True)
    (folder / "figures" / "teaser.png").write_bytes(b"picture")
    made = {"nvs_per_scene": PER_SCENE, "slam_per_run": PER_RUN, "nvs": "method,mean\n"} | tables
    for name, text in made.items():
        (folder / "tables" / f"{name}.csv").write_text(text)
    return folder


@pytest.fixture
def kept(tmp_path):
    run(tmp_path / "ci")
    keep(
        tmp_path / "ci",
        episodes_of_run(tmp_path / "ci"),
        tmp_path / "reference",
        "snakemake -j2 tables",
        ["teaser.png"],
    )
    return tmp_path / "reference"


def lines(results, folder):
    bits = same_bits(results, episodes_of_run(results), folder)
    return [(each.line(), is_too_far(each, bits)) for each in deviations(results, folder)]


def test_a_run_is_its_own_reference_in_which_times_do_not_count(kept):
    told = read_record(kept / ABOUT, ReferenceRun)
    assert (told.command, told.revisions, told.machine["processor"]) == ("snakemake -j2 tables", ("abc",), "Intel")
    assert sorted(path.name for path in kept.rglob("*") if path.is_file()) == [
        "nvs.csv",
        "nvs_per_scene.csv",
        ABOUT,
        "slam_per_run.csv",
        "teaser.png",
    ]
    assert lines(kept.parent / "ci", kept) == [
        ("nvs_per_scene.csv, psnr: 0 of 2 values differ", False),
        ("slam_per_run.csv, scr_percent: 0 of 1 values differ", False),
    ]


def test_a_digit_is_too_much_where_bits_should_be_the_same(kept, tmp_path):
    other = run(tmp_path / "other", nvs_per_scene=PER_SCENE.replace("20.1234", "20.1235"))
    assert lines(other, kept)[0] == (
        "nvs_per_scene.csv, psnr: 1 of 2 values differ, by 7.07e-05 (root mean square), 0.0001 at most",
        True,
    )


@pytest.mark.parametrize("other", [{"numerics": "native"}, {"torch": "2.14.0"}])
def test_other_numerics_and_packages_have_a_tolerance(other, kept, tmp_path):
    near = run(tmp_path / "near", nvs_per_scene=PER_SCENE.replace("20.1234", "20.5"), **other)
    far = run(tmp_path / "far", nvs_per_scene=PER_SCENE.replace("20.1234", "21.5"), **other)
    assert [lines(each, kept)[0][1] for each in (near, far)] == [False, True]


def test_what_the_reference_has_not_is_not_compared_and_what_it_has_must_be_there(kept, tmp_path):
    more = run(tmp_path / "more", nvs_per_scene=PER_SCENE + "farthest,psnr,a,0,6,1.0\n")
    assert [too_far for _, too_far in lines(more, kept)] == [False, False]
    less = run(tmp_path / "less", nvs_per_scene="\n".join(PER_SCENE.splitlines()[:2]))
    (less / "tables" / "slam_per_run.csv").unlink()
    assert lines(less, kept) == [
        ("nvs_per_scene.csv, psnr: 0 of 1 values differ; 1 are not there", True),
        ("slam_per_run.csv, scr_percent: 0 of 0 values differ; 1 are not there", True),
    ]


def test_faults_are_one_line_and_leave_the_reference_as_it_was(kept, tmp_path):
    with pytest.raises(UserError, match=r"none\.png: is not there; name a figure of this run"):
        keep(tmp_path / "ci", [], kept, "", ["none.png"])
    assert lines(tmp_path / "ci", kept)
    with pytest.raises(UserError, match="holds no results that were kept"):
        same_bits(tmp_path / "ci", [], tmp_path / "nowhere")
    with pytest.raises(UserError, match="holds no episodes"):
        keep(tmp_path / "ci", [], kept, "", [])
    shutil.rmtree(tmp_path / "ci" / "tables")
    with pytest.raises(UserError, match=r"tables: holds no tables; make them first"):
        keep(tmp_path / "ci", [], kept, "", [])


def test_the_results_of_this_checkout_are_those_of_the_reference():
    results, folder = ROOT / "results" / "ci", ROOT / "results" / "reference" / "ci"
    if not (results / "tables" / "nvs_orbit_per_scene.csv").is_file() or not folder.is_dir():
        pytest.skip("no finished run of ci here: snakemake -j2 tables makes one")
    assert [told for told, too_far in lines(results, folder) if too_far] == []


def test_a_value_that_is_no_number_is_too_far(kept, tmp_path):
    other = run(tmp_path / "other", nvs_per_scene=PER_SCENE.replace("20.1234", "nan"), torch="2.14.0")
    assert lines(other, kept)[0] == (
        "nvs_per_scene.csv, psnr: 1 of 2 values differ, by inf (root mean square), inf at most",
        True,
    )


def test_tables_without_single_values_are_named(kept):
    for name in ("nvs", "slam", "runtime"):
        (kept / "tables" / f"{name}.md").touch()
    assert not_compared(kept) == ["runtime"]


@pytest.mark.parametrize(("psnr", "status"), [("20.1234", 0), ("29.0", 1)])
def test_the_command_ends_with_a_status_and_without_a_fault_of_its_own(psnr, status, kept, tmp_path, capfd):
    other = run(tmp_path / "other", nvs_per_scene=PER_SCENE.replace("20.1234", psnr))
    ended = CliRunner().invoke(commands, [str(other), "--folder", str(kept)])
    assert ended.exit_code == status
    told = capfd.readouterr()
    assert "ended the program" not in told.err
    assert "Traceback" not in told.err

"""The table of selection times: medians by hand, rows without a time, the paper's values, times that do not compare."""

import csv
import re

import pytest

from avs.report.tables.selection_times import write_runtime_table
from avs.system.errors import UserError
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
    """Write the table; return its rows by (method, metric) and its Markdown and LaTeX."""

    def write(records, episodes, methods, absent=None):
        paths = []
        for number, record in enumerate(records):
            paths.append(tmp_path / "records" / f"{number}.json")
            write_record(paths[-1], record)
        (tmp_path / "published.csv").write_text(PUBLISHED)
        out = tmp_path / "tables" / "runtime"
        write_runtime_table(paths, written(episodes), methods, absent or {}, [tmp_path / "published.csv"], out)
        with open(f"{out}.csv", newline="") as stream:
            rows = {(row["method"], row["metric"]): row for row in csv.DictReader(stream)}
        return rows, *(out.with_suffix(ending).read_text() for ending in (".md", ".tex"))

    return write


def test_values_by_hand(episode, table):
    records = [make_record(), make_record("fisherrf4", total=(2.0, 1.0), chosen=4, render=0.25)]
    episodes = [episode("fisherrf", seed=0), episode("fisherrf", seed=1, psnr=(22.0, 24.0)), episode("fisherrf4")]
    rows, markdown, latex = table(records, episodes, ["fisherrf", "fisherrf4"])
    row = rows["fisherrf", "selection_seconds"]
    assert (row["value"], row["lowest"], row["highest"], row["repeats"]) == ("0.30000", "0.10000", "0.40000", "3")
    assert row["published"] == "8.34"
    assert rows["fisherrf", "psnr"]["value"] == "22.0000"
    assert rows["fisherrf", "peak_memory_gb"]["value"] == "0.5120"
    assert rows["fisherrf", "peak_memory_gb"]["published"] == "15.8"
    assert rows["fisherrf4", "selection_seconds"]["value"] == "1.50000"
    assert rows["fisherrf4", "view_seconds"]["value"] == "0.37500"
    assert rows["fisherrf4", "render_seconds"]["value"] == "0.25000"
    assert rows["fisherrf4", "selection_seconds"]["published"] == ""
    assert "**0.300**" in markdown
    assert "12 captured views, 44 candidates of 192x108 pixels, after 245 iterations; a processor" in latex
    assert "- Score holds the whole selection of fisherrf: no rendering is told apart" in markdown
    assert "NVIDIA 4090" in latex


def test_candidates_of_several_sizes_are_told_from_the_smallest_to_the_largest(episode, table):
    _, markdown, _ = table(
        [make_record(image_sizes=[(90, 160), (160, 95), (200, 100)])], [episode("fisherrf")], ["fisherrf"]
    )
    assert "44 candidates of 90x160 to 200x100 pixels" in markdown


def test_a_psnr_of_fewer_seeds_has_no_mark_and_the_times_beside_it_have(episode, table):
    episodes = [episode("fisherrf", seed=seed, psnr=(20.0,)) for seed in (0, 1)]
    episodes.append(episode("fisherrf4", seed=0, psnr=(30.0,)))
    _, markdown, _ = table([make_record(), make_record("fisherrf4", total=(0.1,))], episodes, ["fisherrf", "fisherrf4"])
    four = next(line for line in markdown.splitlines() if "| fisherrf4 |" in line)
    assert "| 30.00 |" in four
    assert "**0.100**" in four
    assert "- fisherrf4, PSNR: mean of seed 0 only, not to be ranked, no episode of attic with seed 1" in markdown


def test_times_with_other_packages_have_no_marks(episode, table):
    records = [make_record(packages={"torch": "2.13.0"}), make_record("fisherrf4", packages={"torch": "2.14.0"})]
    _, markdown, _ = table(records, [episode("fisherrf"), episode("fisherrf4")], ["fisherrf", "fisherrf4"])
    assert "**0.300**" not in markdown
    told = "times have no marks, because methods were timed with other versions of torch: 2.13.0: fisherrf; 2.14.0: "
    assert f"- {told}fisherrf4" in markdown


def test_a_method_without_a_time_keeps_its_row_with_the_reason(episode, table):
    reason = "weights maniqa absent: python -m avs weights fetch maniqa"
    absent = {
        "maniqa": Reason(cause="weights maniqa absent", remedy="python -m avs weights fetch maniqa"),
        "theirs": Reason(cause="a program of its own is not timed"),
    }
    rows, markdown, latex = table(
        [make_record()], [episode("fisherrf"), episode("theirs")], ["fisherrf", "maniqa", "theirs"], absent
    )
    assert rows["maniqa", "selection_seconds"]["note"] == rows["maniqa", "psnr"]["note"] == reason
    assert rows["theirs", "psnr"]["value"] == "21.0000"
    assert rows["theirs", "selection_seconds"]["note"] == "a program of its own is not timed"
    assert markdown.count(reason) == latex.count(reason) == 1
    assert "| weights maniqa absent | – |" in markdown  # noqa: RUF001
    assert markdown.count("a program of its own is not timed") == 1


def test_a_fit_of_its_own_is_told(episode, table):
    _, markdown, _ = table(
        [make_record("activenerf", label="ActiveNeRF", own_fit=True)], [episode("activenerf")], ["activenerf"]
    )
    assert "- ActiveNeRF: timed on a reconstruction fitted with the method's own loss" in markdown


def test_what_else_the_machine_did_is_told_and_the_disturbed_are_named(episode, table):
    records = [make_record(other_cores=0.016), make_record("random", other_cores=1.7, label="Random")]
    _, markdown, _ = table(records, [episode("fisherrf"), episode("random")], ["fisherrf", "random"])
    assert "after a warm-up; other programs kept 0.02 to 1.70 cores of the machine busy." in markdown
    said = "- times may be too long, because other programs kept cores busy meanwhile: Random (1.70)"
    assert f"{said}\n- times have no marks, because there was more work than cores\n" in markdown
    assert "**0.300**" not in markdown
    records = [make_record(), make_record("random", other_cores=0.9, label="Random")]
    _, markdown, _ = table(records, [episode("fisherrf"), episode("random")], ["fisherrf", "random"])
    assert "meanwhile: Random (0.90)\n" in markdown
    assert "**0.300**" in markdown
    _, markdown, _ = table([make_record()], [episode("fisherrf")], ["fisherrf"])
    assert "other programs kept 0.02 cores of the machine busy." in markdown
    assert "too long" not in markdown
    _, markdown, _ = table([make_record(other_cores=None)], [episode("fisherrf")], ["fisherrf"])
    assert "what else the machine did is not known." in markdown
    records = [make_record(), make_record("random", other_cores=None)]
    _, markdown, _ = table(records, [episode("fisherrf"), episode("random")], ["fisherrf", "random"])
    assert "0.02 cores of the machine busy as far as that is known." in markdown


def test_what_computes_on_the_processor_has_no_time_beside_a_gpu(episode, table):
    """Else the table would compare a CPU with a GPU and call it methods."""
    gpu = {"device": "cuda", "machine": {"processor": "a processor", "cores": "2", "gpu": "a GPU"}}
    records = [make_record(**gpu), make_record("musiq", label="MUSIQ", computed_on="cuda", **gpu)]
    rows, markdown, _ = table(records, [episode("fisherrf"), episode("musiq")], ["fisherrf", "musiq"])
    assert rows["musiq", "selection_seconds"]["value"] == "0.30000"
    assert rows["fisherrf", "selection_seconds"]["value"] == rows["fisherrf", "peak_memory_gb"]["value"] == ""
    assert rows["fisherrf", "psnr"]["value"] == "21.0000"
    assert rows["fisherrf", "selection_seconds"]["note"].startswith("computed on the processor, not on the GPU")
    assert "- FisherRF: computed on the processor, not on the GPU: no time is printed" in markdown
    assert "- whether other programs used the GPU is not measured" in markdown


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"threads": 2}, "threads is not that of fisherrf"),
        ({"machine": {"processor": "another", "cores": "2"}}, "machine is not that of fisherrf"),
        ({"captured": 3}, "captured is not that of fisherrf"),
        ({"method": "fisherrf"}, "a second record of fisherrf"),
    ],
)
def test_times_that_do_not_compare_are_refused_in_one_line(episode, table, changes, fault):
    with pytest.raises(UserError, match=re.escape(fault)) as error:
        table([make_record(), make_record(**({"method": "random"} | changes))], [episode("fisherrf")], ["fisherrf"])
    assert "\n" not in str(error.value)


def test_episodes_of_another_scene_are_refused(episode, table):
    with pytest.raises(UserError, match="is an episode on another scene than attic"):
        table([make_record()], [episode("fisherrf", scene="cellar")], ["fisherrf"])

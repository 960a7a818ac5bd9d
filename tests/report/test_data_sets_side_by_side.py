"""Two data sets in one table: their columns, methods that one of them lacks, notes of one or of both."""

import pytest

from avs.report.collect import read_episodes
from avs.report.formats.delimited import document_csv
from avs.report.formats.latex import document_latex
from avs.report.formats.markdown import document_markdown
from avs.report.tables.data_sets_side_by_side import ShownDataSet, side_by_side
from avs.system.reasons import Reason
from tests.report.test_setting_sensitivity import marks_of

MEANS = """table,dataset,scene,method,metric,value
t,mapfree,mean,fisherrf,psnr,17.21
"""


@pytest.fixture
def document(episode, written, tmp_path):
    (tmp_path / "means.csv").write_text(MEANS)
    rooms = [episode(method, seed=seed, psnr=(value,), dataset="rooms") for method, value in BOTH for seed in (0, 1, 2)]
    yard = [episode("fisherrf", psnr=(25.0,), dataset="handheld")]
    found = {each.dataset: each for each in read_episodes(written(rooms + yard), ["random", "fisherrf"])}
    absent = {"musiq": Reason(cause="weights musiq absent", remedy="fetch them")}
    sets = [
        ShownDataSet(found["rooms"], ["random", "fisherrf", "musiq"], absent, None),
        ShownDataSet(found["handheld"], ["fisherrf", "musiq"], absent, tmp_path / "means.csv"),
    ]
    return side_by_side(sets, "re10k_mfr")


BOTH = (("random", 20.0), ("fisherrf", 22.0))


def test_each_data_set_has_its_columns_and_marks(document):
    lines = document_markdown(document).splitlines()
    assert lines[2].startswith(
        "|  | Method | rooms: PSNR ↑ (dB) | rooms: SSIM ↑ | rooms: LPIPS ↓ | handheld (twin of Map-Free):"
    )
    fisher = next(line for line in lines if "FisherRF" in line)
    assert fisher.startswith("| 3D-based | FisherRF | **22.00 ± 0.00** |")
    assert "| **25.00** | 17.21 |" in fisher
    assert "| Random | 20.00 ± 0.00 (2) | **0.600 ± 0.000** | **0.300 ± 0.000** | – | – | – | – |" in lines[5]  # noqa: RUF001


def test_a_gap_in_one_data_set_takes_no_mark_from_another(episode, written):
    rooms = [episode(method, seed=seed, psnr=(value,), dataset="rooms") for method, value in BOTH for seed in (0, 1)]
    hall = [each.model_copy(update={"dataset": "hall"}) for each in rooms]
    lacking = [each for each in rooms if (each.method, each.seed) != ("fisherrf", 1)]
    found = {each.dataset: each for each in read_episodes(written(lacking + hall), ["random", "fisherrf"])}
    sets = [ShownDataSet(found[name], ["random", "fisherrf"], {}, None) for name in ("rooms", "hall")]
    told = side_by_side(sets, "re10k_mfr")
    marks = marks_of(told)
    assert (marks["fisherrf"][0], marks["fisherrf"][3]) == (None, 1)
    assert (marks["random"][0], marks["random"][3]) == (1, 2)
    assert "rooms: FisherRF: mean of seed 0 only, not to be ranked, no episode of attic with seed 1" in told.notes


def test_a_note_of_both_stands_once_and_one_of_a_single_data_set_names_it(document):
    notes = document.notes
    assert notes.count("MUSIQ: weights musiq absent: fetch them") == 1
    assert "handheld: no spread over seeds is printed of fewer than 3 seeds; here there is 1" in notes
    assert any(note.startswith("published: the paper's means on Map-Free") for note in notes)


def test_the_headings_of_data_sets_span_their_columns(document):
    latex = document_latex(document)
    assert r"\multicolumn{3}{c}{rooms} & \multicolumn{4}{c}{handheld (twin of Map-Free)} \\" in latex
    assert r"\cmidrule(lr){3-5} \cmidrule(lr){6-9}" in latex
    assert r"\label{tab:re10k-mfr}" in latex


def test_the_records_name_their_data_set(document):
    lines = document_csv(document).splitlines()
    assert lines[0].startswith("dataset,method,group,metric")
    assert [line.split(",")[0] for line in lines[1:]] == ["rooms"] * 9 + ["handheld"] * 6

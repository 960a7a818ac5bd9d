"""The view synthesis table: values by hand, missing things kept with their reason, equal records equal bytes."""

import random
import re

import pytest

from avs.nvs.record import ImageMetrics
from avs.report.tables.view_synthesis import write_nvs_table
from avs.system.errors import UserError
from avs.system.reasons import Reason
from metrics.definitions import METRICS
from tests.report.latex_subset import check_latex
from tests.report.view_synthesis_tables import METHODS, PUBLISHED, REFERENCE, TableWriter, two_scenes

COLUMNS = "method,group,metric,mean,spread,scenes,seeds,published,difference,note"


@pytest.fixture
def table(tmp_path, written):
    return TableWriter(tmp_path, written)


def test_values_by_hand(episode, table):
    episodes = two_scenes(episode, "random", [0.0, 1.0, 2.0]) + two_scenes(episode, "ours-repvit", [1.0, 2.0, 3.5])
    rows, markdown, latex = table(episodes, ["random", "ours-repvit"], PUBLISHED)
    row = rows["random", "psnr"]
    # Scene means 21 and 31 with the first seed, 1 dB more with each other: 26, 27 and 28.
    assert (row["mean"], row["spread"], row["scenes"], row["seeds"]) == ("27.0000", "1.0000", "2", "3")
    # Published values of other scenes stand there without a difference.
    assert (row["published"], row["difference"], row["note"]) == ("17.91", "", "")
    assert rows["random", "lpips"]["published"] == ""
    assert "| 2D-based | Random | 27.00 ± 1.00 (2) | 17.91 |" in markdown
    assert r"Random & \cellcolor[HTML]{FCE5CD}27.00 $\pm$ 1.00 & 17.91 &" in latex
    # Differences -1, -1 and -1.5 in both scenes: variance 1/12 in each, 1/36 of its mean, so an error of
    # sqrt(2 / 36) / 2 with four degrees of freedom: 2.776 * 0.1179.
    assert "| Random | −1.17 [−1.49, −0.84] |" in markdown  # noqa: RUF001
    assert "over seeds (other seeds on these 2 scenes; not other scenes):" in markdown
    assert (
        "2 scenes (attic, cellar), 3 seeds (0, 1, 2), 2 test images a scene, 6 views, 4 of them initial, 100 it"
        in latex
    )


def test_what_the_paper_proposes_is_set_off_by_what_the_method_says_of_itself(episode, table):
    """Not by its identifier: another's ``ours-`` gets no rule."""
    _, _, latex = table([episode("random"), episode("ours-repvit")], ["random", "ours-repvit"])
    assert "\\cmidrule(l){2-5}\n & Ours-RepViT" in latex
    _, _, latex = table([episode("random"), episode("ours-mine")], ["random", "ours-mine"])
    assert r"\cmidrule(l)" not in latex


def test_every_metric_is_a_field_of_the_record():
    assert set(METRICS) <= set(ImageMetrics.model_fields)


def test_csv_has_exactly_the_columns_and_one_row_per_method_and_metric(episode, table, tmp_path):
    table([episode(method) for method in METHODS])
    lines = (tmp_path / "tables" / "nvs_orbit.csv").read_text().splitlines()
    assert lines[0] == COLUMNS
    assert [line.split(",")[:3:2] for line in lines[1:]] == [
        [method, metric] for method in METHODS for metric in ("psnr", "ssim", "lpips")
    ]


def test_scenes_are_listed_by_themselves(episode, table, tmp_path):
    table(two_scenes(episode, "random", [0.0]), ["random"])
    lines = (tmp_path / "tables" / "nvs_orbit_per_scene.csv").read_text().splitlines()
    assert lines[:3] == [
        "method,metric,scene,seed,images,value",
        "random,psnr,attic,0,2,21.0000",
        "random,psnr,cellar,0,2,31.0000",
    ]


def test_one_seed_leaves_the_spread_empty_and_says_so(episode, table):
    rows, markdown, latex = table([episode("random"), episode("ours-repvit", psnr=(22.0, 24.0))], METHODS)
    assert rows["random", "psnr"]["spread"] == ""
    assert "±" not in markdown
    for printed in (markdown, latex):
        assert "no spread over seeds is printed of fewer than 3 seeds; here there is 1" in printed


def test_two_seeds_have_no_spread(episode, table):
    rows, markdown, _ = table(two_scenes(episode, "random", [0.0, 1.0]), ["random"])
    assert (rows["random", "psnr"]["spread"], rows["random", "psnr"]["seeds"]) == ("", "2")
    assert "±" not in markdown
    assert "here there are 2" in markdown


def test_best_three_are_marked_by_direction_and_ties_share_a_rank(episode, table):
    values = {"random": 20.0, "farthest": 21.004, "piqe": 21.001, "fisherrf": 22.0, "ours-repvit": 19.0}
    lpips = {"random": 0.5, "farthest": 0.4, "piqe": 0.3, "fisherrf": 0.2, "ours-repvit": 0.1}
    _, markdown, latex = table([episode(method, psnr=(values[method],), lpips=lpips[method]) for method in METHODS])
    lines = {line.split("|")[2].strip(): line for line in markdown.splitlines() if line.startswith("|")}
    assert "**22.00**" in lines["FisherRF"]
    assert "21.00 (2)" in lines["FVS"]
    assert "21.00 (2)" in lines["PIQE"]
    assert "20.00 (3)" in lines["Random"]
    assert "| 19.00 |" in lines["Ours-RepViT"]
    assert "**0.100**" in lines["Ours-RepViT"]
    assert "0.200 (2)" in lines["FisherRF"]
    assert "| 0.500 |" in lines["Random"]
    shaded = re.findall(r"\\cellcolor\[HTML\]\{(\w+)\}(\S+)", latex)
    assert ("F4CCCC", "22.00") in shaded
    assert shaded.count(("FCE5CD", "21.00")) == 2
    assert ("D9EAD3", "20.00") in shaded
    assert ("F4CCCC", "0.100") in shaded


def test_groups_are_in_the_order_of_the_paper(episode, table):
    plugin = episode("mine", group="Learned", label="Mine")
    _, markdown, latex = table([plugin, *(episode(method) for method in METHODS)], ["mine", *METHODS])
    order = ["Geometric", "3D-based", "2D-based", "Learned"]
    assert [line.split("|")[1].strip() for line in markdown.splitlines() if re.match(r"\| [A-Z0-9]", line)][:4] == order
    positions = [latex.index(f"{{{group}}}") for group in order]
    assert positions == sorted(positions)
    assert r"\multirow{3}{*}{2D-based}" in latex


def test_absent_metric_keeps_its_column_with_the_reason_once(episode, table):
    rows, markdown, latex = table([episode(method, lpips=None) for method in METHODS])
    assert rows["piqe", "lpips"]["mean"] == ""
    assert rows["piqe", "lpips"]["note"] == "weights vgg16-397923af.pth absent: put them there"
    assert markdown.count("vgg16") == 1
    assert latex.count("vgg16") == 1
    assert "- LPIPS: weights vgg16-397923af.pth absent: put them there\n" in markdown


def test_method_without_episodes_keeps_its_row(episode, table):
    rows, markdown, latex = table([episode("random"), episode("ours-repvit")], ["random", "farthest", "ours-repvit"])
    row = rows["farthest", "psnr"]
    assert (row["group"], row["mean"], row["scenes"], row["note"]) == ("Geometric", "", "0", "no episode")
    assert "| Geometric | FVS | no episode | – | – |" in markdown  # noqa: RUF001
    assert "- FVS: no episode\n" in markdown
    assert r"{Geometric} & FVS & {\scriptsize no episode} & -- & -- \\" in latex


def test_method_that_cannot_run_says_why_and_keeps_its_published_value(episode, table):
    reason = Reason(cause="weights koniq absent", remedy="python -m avs weights fetch koniq")
    published = PUBLISHED + "tab,mipnerf360,mean,musiq,psnr,19.62\n"
    methods = ["random", "musiq", "farthest"]
    rows, markdown, latex = table([episode("random")], methods, published, absent={"musiq": reason})
    row = rows["musiq", "psnr"]
    assert (row["mean"], row["published"], row["difference"], row["note"]) == ("", "19.62", "", str(reason))
    assert rows["farthest", "psnr"]["note"] == "no episode"
    assert "| MUSIQ | weights koniq absent | 19.62 | – | – |" in markdown  # noqa: RUF001
    assert r"MUSIQ & {\scriptsize weights koniq absent} & 19.62 & -- & --" in latex
    assert markdown.count(str(reason)) == latex.count(str(reason)) == 1


def test_oracles_are_last_and_without_rank(episode, table):
    oracle = episode("oracle-ssim", group="Oracle", psnr=(39.0, 41.0))
    _, markdown, latex = table(
        [oracle, episode("random"), episode("mine", group="Learned")], ["oracle-ssim", "random", "mine"]
    )
    groups = [line.split("|")[1].strip() for line in markdown.splitlines() if re.match(r"\| [A-Z0-9]", line)]
    assert groups == ["2D-based", "Learned", "Oracle"]
    assert "| oracle-ssim | 40.00 |" in markdown
    assert "**21.00**" in markdown
    assert "- Oracle: chosen by looking at photographs" in markdown
    assert "without a rank" in latex


def test_missing_scene_is_never_averaged_over(episode, table):
    episodes = two_scenes(episode, "random", [0.0, 1.0]) + two_scenes(episode, "ours-repvit", [0.0, 1.0])
    without_cellar = [each for each in episodes if not (each.method == "random" and each.scene == "cellar")]
    rows, *_ = table(without_cellar, ["random", "ours-repvit"])
    assert rows["random", "psnr"]["mean"] == ""
    assert rows["random", "psnr"]["note"] == "no episode of cellar"
    one_seed_short = [each for each in episodes if (each.method, each.scene, each.seed) != ("random", "cellar", 1)]
    rows, markdown, _ = table(one_seed_short, ["random", "ours-repvit"])
    assert (rows["random", "psnr"]["mean"], rows["random", "psnr"]["seeds"]) == ("26.0000", "1")
    assert rows["random", "psnr"]["note"] == "mean of seed 0 only, not to be ranked, no episode of cellar with seed 1"
    assert "- Random: compared with Ours-RepViT on the seeds that both have, 0\n" in markdown
    row = next(line for line in markdown.splitlines() if "| Random |" in line)
    assert "26.00" in row
    assert "**" not in row
    assert "- Random: mean of seed 0 only, not to be ranked, no episode of cellar with seed 1\n" in markdown


@pytest.mark.parametrize("changes", [{"selector": {"regularisation": 2.0}}, {"weights_hash": "other"}])
def test_a_row_of_episodes_with_other_settings_of_the_method_is_refused(episode, table, changes):
    episodes = [episode("fisherrf", seed=0), episode("fisherrf", seed=1, **changes), episode("random", seed=0)]
    with pytest.raises(UserError, match=f"not comparable with other episodes of orbit, {next(iter(changes))}"):
        table(episodes, ["fisherrf", "random"])


def test_equal_records_give_equal_bytes_in_any_order(episode, written, tmp_path):
    episodes = [each for method in METHODS for each in two_scenes(episode, method, [0.0, 0.3])]
    contents = []
    for name in ("first", "second"):
        random.Random(name).shuffle(episodes)
        write_nvs_table(written(episodes), METHODS, "orbit", None, tmp_path / name / "nvs_orbit", {}, REFERENCE)
        contents.append({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()})
    assert contents[0] == contents[1]
    endings = (".csv", ".json", ".md", ".tex", "_per_scene.csv", "_differences.csv")
    assert set(contents[0]) == {f"nvs_orbit{ending}" for ending in endings}


def test_latex_is_well_formed(episode, table):
    note = r"50% of {these} & #those: a_b ~ c^d, $1 < 2 > 0, \end"
    episodes = [episode(method, scene="attic_one", lpips=None, notes=[note]) for method in METHODS]
    _, _, latex = table(episodes, published=PUBLISHED)
    check_latex(latex)
    assert re.findall(r"\\begin\{(\w+\*?)\}", latex) == ["table*", "tabular", "tabular"]


@pytest.mark.parametrize(
    ("damage", "fault"),
    [
        (lambda first, second: [], "none given"),
        (lambda first, second: [first, first], "repeats"),
        (lambda first, second: [first, second.model_copy(update={"method": "unknown"})], "not among the rows"),
        (lambda first, second: [first, second.model_copy(update={"curve": []})], "no test metrics"),
        (lambda first, second: [first, second.model_copy(update={"scene_hash": "other"})], "scene_hash"),
        (
            lambda first, second: [first, second.model_copy(update={"representation": {"sh_degree": 1}})],
            "sh_degree: 1 instead of 3",
        ),
        (
            lambda first, second: [first, second.model_copy(update={"protocol": first.protocol | {"iterations": 9}})],
            "protocol.iterations: 9 instead of 100",
        ),
        (lambda first, second: [first, second.model_copy(update={"budget": 5})], "budget: 5 instead of 6"),
        (lambda first, second: [first, second.model_copy(update={"dataset": "handheld"})], "episodes of handheld"),
    ],
)
def test_unfit_episodes_are_refused_in_one_line(episode, table, damage, fault):
    with pytest.raises(UserError, match=re.escape(fault)) as error:
        table(damage(episode("random"), episode("piqe")))
    assert "\n" not in str(error.value)


def test_damaged_files_are_refused_in_one_line(episode, written, tmp_path):
    (path,) = written([episode("random")])
    for text, fault in (("{", "is not a JSON object"), ('{"scene": 1}', "its digest is missing")):
        path.write_text(text)
        with pytest.raises(UserError, match=fault) as error:
            write_nvs_table([path], ["random"], "orbit", None, tmp_path / "nvs_orbit", {}, REFERENCE)
        assert "\n" not in str(error.value)
        assert str(path) in str(error.value)
    with pytest.raises(UserError, match="No such file"):
        write_nvs_table([tmp_path / "absent.json"], ["random"], "orbit", None, tmp_path / "nvs_orbit", {}, REFERENCE)
    (path,) = written([episode("random")])
    for text, fault in (("a,b\n", "columns"), (PUBLISHED.replace("17.91", "high"), "not a number")):
        (tmp_path / "wrong.csv").write_text(text)
        with pytest.raises(UserError, match=fault):
            write_nvs_table([path], ["random"], "orbit", tmp_path / "wrong.csv", tmp_path / "nvs_orbit", {}, REFERENCE)
    assert not list(tmp_path.glob("nvs_orbit*"))


def test_a_method_of_a_group_of_its_own_that_lacks_an_episode_keeps_its_row(episode, table):
    own = episode("piqe", seed=0, group="Learned")
    rows, markdown, _ = table([own, episode("random", seed=0), episode("random", seed=1)], ["random", "piqe"])
    assert rows["piqe", "psnr"]["mean"]
    assert "| Learned |" in markdown

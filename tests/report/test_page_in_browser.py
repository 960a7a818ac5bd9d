"""The page in headless Chromium, opened from disk: every part is shown without an error, by mouse, keys and address.

Needs Debian's package ``chromium`` and the packages of ``environment-optional.txt``; without them the tests skip.
"""

import json
import re
import shutil
import time

import pytest

from avs.report.page.page_settings import PageSettings
from tests.report.page_run import METHODS, SEEDS, SHIFTS, write_run, write_whole_page

playwright = pytest.importorskip("playwright.sync_api", reason="no playwright: install environment-optional.txt")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium: apt-get install chromium")

WIDTHS = (390, 1440)
LOCAL = ("file:", "data:", "blob:")
PATIENCE = 120_000  # milliseconds, for a machine with other work
OPTIONS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
PARTS = {
    "tables": "table.numbers tbody tr",
    "episodes": "table.numbers td a",
    "episode/toys/toy/ours-repvit/0": ".bar.chosen",
    "compare/toys/toy/0?methods=random,fisherrf": ".columns canvas",
    "truth/toys/toy": ".scatter circle.taken",
    "figures": ".drawn img",
    "slam": ".floor .way",
    "scorers": ".facts dd",
    "methods": "article.panel",
    "run": ".tree",
}


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    root = tmp_path_factory.mktemp("run with spaces & signs #1")
    return write_whole_page(root, write_run(root), root / "report", PageSettings())


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as started:
        opened = started.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield opened
        opened.close()


@pytest.fixture
def open_page(browser, page):
    """Open an address of the page; at the end nothing may have gone wrong, and nothing been asked of a network."""
    faults, tabs = [], []

    def opened(address="", width=1440):
        tab = browser.new_page(viewport={"width": width, "height": 900})
        tab.on("console", lambda message: faults.append(message.text) if message.type in ("error", "warning") else None)
        tab.on("pageerror", lambda error: faults.append(str(error)))
        tab.on("request", lambda request: None if request.url.startswith(LOCAL) else faults.append(request.url))
        tab.goto(f"{(page / 'index.html').as_uri()}{address and '#' + address}")
        tab.set_default_timeout(PATIENCE)
        tabs.append(tab)
        return tab

    yield opened
    for tab in tabs:
        tab.close()
    assert faults == []


def rows(tab):
    return [text.strip() for text in tab.locator("table.numbers").first.locator("tbody th.name").all_inner_texts()]


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("part", PARTS)
def test_every_part_is_shown_and_fits_the_width(open_page, part, width):
    tab = open_page(part, width)
    tab.locator(PARTS[part]).first.wait_for(state="attached")
    assert tab.locator("h1").count() >= 1
    assert tab.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    assert tab.evaluate("[...document.images].every((image) => !image.complete || image.naturalWidth > 0)")


def test_a_table_is_there_at_once_and_sorts(open_page):
    tab = open_page()
    heading = tab.get_by_role("button", name=re.compile("^PSNR"))
    heading.wait_for()
    assert len(rows(tab)) == len(METHODS)
    heading.click()
    cells = tab.locator("table.numbers").first.locator("tbody tr td:nth-child(3)")
    values = [float(text) for text in cells.all_inner_texts() if re.match(r"[\d.]+$", text)]
    assert len(values) == len(SHIFTS)
    assert values == sorted(values, reverse=True)
    assert "sort=0" in tab.url
    heading.focus()
    tab.keyboard.press("Enter")
    values = [float(text) for text in cells.all_inner_texts() if re.match(r"[\d.]+$", text)]
    assert values == sorted(values)
    assert tab.locator("th[aria-sort=ascending]").count() == 1
    assert "weights niqe absent" in tab.locator("table.numbers").first.inner_text()
    assert "#tables/nvs_toys?" in tab.url


def test_filters_are_in_the_address_and_come_back_from_it(open_page):
    tab = open_page("tables/nvs_toys")
    tab.get_by_role("searchbox").fill("fisher")
    assert rows(tab) == ["FisherRF"]
    tab.get_by_label("Scene").select_option("toy")
    again = open_page(tab.url.partition("#")[2])
    again.locator("tbody tr").first.wait_for()
    assert rows(again) == ["FisherRF"]
    assert again.get_by_label("Scene").input_value() == "toy"
    assert "scene toy" in again.locator("caption").inner_text()


def test_means_of_the_page_are_those_of_the_table(open_page):
    """Over all scenes and seeds, which the page can compute too, its means and ranks are the table's own."""
    tab = open_page("tables/nvs_toys")
    tab.locator("tbody tr").first.wait_for()
    found = tab.evaluate("""async () => {
      const told = await avs.load("tables/nvs_toys");
      const scenes = [...new Set(avs.singles(told).map((each) => each.scene))];
      const shown = scenes.map((scene) => avs.filtered(told, { scene }));
      const rows = (document) => document.groups.flatMap((group) => group.rows);
      const values = (document) => rows(document).map((row) => row.cells.map((cell) => cell.value));
      return { table: values(told), scenes: shown.map(values) };
    }""")
    for own, *scenes in zip(found["table"], *found["scenes"], strict=True):
        for value, *singles in zip(own, *scenes, strict=True):
            if value is not None:
                assert sum(singles) / len(singles) == pytest.approx(value, abs=2e-4)


def test_a_cell_leads_to_its_episodes_and_on_to_one(open_page):
    tab = open_page("tables/nvs_toys")
    tab.locator("tbody tr", has_text="FisherRF").locator("td a").first.click()
    tab.locator("h1", has_text="Episodes of toys").wait_for()
    links = tab.locator("td a")
    links.first.wait_for()
    assert links.count() == 2 * len(SEEDS)
    links.first.click()
    tab.locator("h1", has_text="FisherRF on toy, seed 0").wait_for()


def test_the_replay_moves_by_slider_keys_and_address(open_page):
    tab = open_page("episode/toys/toy/ours-repvit/0")
    words = tab.locator(".player output")
    words.wait_for()
    assert words.inner_text().startswith("Selection 1 of 3: 4 views")
    tab.locator(".player input").fill("1")
    assert words.inner_text().startswith("Selection 2 of 3: 5 views")
    tab.locator("main").focus()
    tab.keyboard.press("ArrowRight")
    tab.keyboard.press("ArrowRight")
    assert words.inner_text().startswith("End: 7 views")
    assert "step=4" in tab.url
    tab.keyboard.press("ArrowRight")
    assert words.inner_text().startswith("End: 7 views")
    assert tab.locator(".strip li").count() == 7
    again = open_page("episode/toys/toy/ours-repvit/0?step=2")
    assert again.locator(".player output").inner_text().startswith("Selection 2")
    assert again.locator(".maps img").count() == 2


def test_the_divider_of_two_pictures_is_a_slider(open_page):
    tab = open_page("episode/toys/toy/ours-repvit/0")
    slider = tab.locator(".stack input")
    slider.wait_for(state="attached")
    slider.focus()
    tab.keyboard.press("ArrowRight")
    assert slider.input_value() == "51"
    assert tab.locator(".over").evaluate("(image) => image.style.clipPath") == "inset(0px 49% 0px 0px)"
    assert tab.locator(".player output").inner_text().startswith("Selection 1"), "the replay must not move with it"


def test_the_cameras_turn_by_keys(open_page):
    tab = open_page("episode/toys/toy/random/0")
    canvas = tab.locator("canvas.space").first
    canvas.wait_for()
    before = canvas.evaluate("(canvas) => canvas.toDataURL()")
    canvas.focus()
    tab.keyboard.press("ArrowLeft")
    tab.keyboard.press("+")
    assert canvas.evaluate("(canvas) => canvas.toDataURL()") != before
    tab.keyboard.press("0")
    assert canvas.evaluate("(canvas) => canvas.toDataURL()") == before


def test_methods_are_compared_at_the_same_number_of_views(open_page):
    tab = open_page("compare/toys/toy/1?methods=random,fisherrf")
    tab.locator(".columns section").first.wait_for()
    assert tab.locator(".columns section").count() == 2
    tab.locator(".player input").fill("2")
    texts = tab.locator(".columns section p").all_inner_texts()
    assert sum(text.startswith("Selection 3 of 3: 6 views") for text in texts) == 2
    tab.get_by_label("Metric").select_option("ssim")
    rows = tab.locator(".stack tbody tr").all_inner_texts()
    assert rows
    assert tab.locator(".stack thead th").all_inner_texts() == ["SSIM", "Random", "FisherRF"]
    apart = [abs(float(one) - float(other)) for _, one, other in (row.split() for row in rows)]
    assert apart == sorted(apart, reverse=True), "those first in which the methods differ most"
    colours = tab.locator(".columns h2 .dot").evaluate_all("dots => dots.map((dot) => dot.style.background)")
    assert len(set(colours)) == 2
    tab.get_by_text("Methods (2)").click()
    tab.get_by_label("FVS").click()
    tab.locator(".columns section").nth(2).wait_for()


def test_a_model_and_a_cloud_are_shown_when_they_are_asked_for(open_page):
    tab = open_page("episode/toys/toy/random/0")
    tab.get_by_role("button", name="show the model").wait_for()
    assert not tab.evaluate("Boolean(window.avsSplats)")
    tab.get_by_role("button", name="show the cloud").click()
    tab.get_by_text("30 of 30 points of the reference").wait_for()
    tab.get_by_role("button", name="show the model").click()
    tab.locator(".splats[data-ready=true] canvas").first.wait_for()
    tab.get_by_text("40 of 40 Gaussians").wait_for()


def test_what_is_missing_says_why(open_page, page):
    tab = open_page("episode/toys/attic/random/0")
    tab.get_by_text("Coverage was not measured for this episode.").wait_for()
    tab = open_page("truth/toys/attic")
    tab.get_by_text("The run measured no common states of this scene").wait_for()
    tab = open_page("tables/conjured")
    tab.get_by_text("There is no table conjured in this run.").wait_for()
    tab = open_page("methods")
    tab.get_by_text("Not in this run: weights niqe absent").wait_for()


def test_the_views_are_there_as_text(open_page, page):
    tab = open_page("episode/toys/toy/random/1")
    text = tab.get_by_label("views in the order of capture").input_value()
    listed = dict(line.split(": ", 1) for line in text.splitlines() if not line.startswith("#"))
    names = [json.loads(listed[kind]) for kind in ("initial", "selected")]
    assert [len(each) for each in names] == [4, 3]
    assert all(re.fullmatch(r"\d{3}\.png", name) for each in names for name in each)


def test_the_navigation_is_reached_by_the_keyboard(open_page):
    tab = open_page()
    tab.locator("tbody tr").first.wait_for()
    tab.keyboard.press("Tab")
    assert tab.evaluate("document.activeElement.textContent") == "Skip to the content"
    tab.get_by_role("link", name="Compare", exact=True).focus()
    tab.keyboard.press("Enter")
    tab.locator("h1", has_text="Methods on toy").wait_for()
    assert tab.evaluate("document.activeElement.id") == "content"
    tab.go_back()
    tab.locator("h1", has_text="toys").wait_for()


def test_the_first_table_is_there_soon(open_page):
    begun = time.monotonic()
    open_page().locator("tbody tr").first.wait_for()
    assert time.monotonic() - begun < PATIENCE / 1000  # how fast it is alone, docs/report.md says

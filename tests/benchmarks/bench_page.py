"""The page of a large run: how long it takes to make, how large it is, and when the first table is there.

    python -m tests.benchmarks.bench_page FOLDER [SCENES METHODS SEEDS]

makes a generated run of 9 scenes, 21 methods and 3 seeds in FOLDER, with 200 candidates a scene, 54 pictures and 6,000
Gaussians an episode, and its page. Times are processor times but that of the first table, which needs Chromium and the
packages of ``environment-optional.txt``.
"""

import os
import shutil
import sys
import time
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter

from avs.nvs.picture_settings import PictureSettings
from avs.nvs.pictures import _encoded, archive, kept_pictures, write_pictures
from avs.nvs.record import CurvePoint, EpisodeMeta, Step, StepTimes
from avs.report.page.page_settings import PageSettings
from avs.report.page.scene_scripts import SceneInputs, write_scene_scripts
from avs.report.page.site import PageFacts, PageInputs, write_page
from avs.report.tables.view_synthesis import write_nvs_table
from avs.representations.gaussians.ply import write_ply
from avs.scene.points import Points
from avs.scene.scene import read_scene, write_scene
from avs.selection import registry
from avs.system.records import write_record
from tests.factories import ring
from tests.report.conftest import images, make_episode
from tests.representations.test_ply import gaussians

SIZE, VIEWS, STEPS, GAUSSIANS = (320, 214), 200, 16, 6000


def texture(rng):
    """A smooth coloured picture, about as hard to compress as a photograph of this size."""
    noise = sum(gaussian_filter(rng.normal(size=(SIZE[1], SIZE[0], 3)), (s, s, 0)) * s for s in (1, 3, 9, 27))
    return np.clip(128 + 55 * noise / noise.std(), 0, 255).astype(np.uint8)


def generated_scene(folder, name, pictures):
    points = Points(np.eye(9, 3), np.zeros((9, 3), np.uint8), np.zeros((0, 2), np.int64))
    write_scene(
        folder, name=name, dataset="large", names=tuple(f"{i:04d}.png" for i in range(VIEWS)),
        images=[pictures[i % len(pictures)] for i in range(VIEWS)], cameras=ring(VIEWS, size=SIZE),
        test=np.arange(0, VIEWS, 8), source="generated", licence="none",
        points=points,
    )  # fmt: skip
    return read_scene(folder)


def generated_episode(root, scene, method, seed, content, model):
    rng = np.random.default_rng([seed, len(method), sum(map(ord, method + scene.name))])
    pool = [scene.names[row] for row in scene.pool]
    order = rng.permutation(len(pool))[: STEPS + 4]
    initial, selected = [pool[i] for i in order[:4]], [pool[i] for i in order[4:]]
    steps = []
    for step, chosen in enumerate(selected):
        left = [name for name in pool if name not in {*initial, *selected[:step]}]
        scores = rng.normal(size=len(left)).tolist()
        steps.append(Step(step=step, iteration=50 * step, primitives=5000, candidates=left, scores=scores, chosen=[chosen], captured=[50 * step]))  # fmt: skip # noqa: E501
    test = [scene.names[row] for row in scene.test]
    curve = []
    for views in range(4, STEPS + 5):
        found = images(tuple(rng.normal(20 + views / 10, 0.3, len(test))), 0.6, 0.3)
        named = [each.model_copy(update={"name": name}) for each, name in zip(found, test, strict=True)]
        curve.append(CurvePoint(iteration=50 * views, views=views, primitives=5000, images=named))
    registered = registry.methods()[method].method
    record = make_episode(
        method, scene=scene.name, seed=seed, budget=STEPS + 4, dataset="large", scene_hash=scene.content_hash,
        label=registered.label, group=registered.group, initial=initial, selected=selected, steps=steps, curve=curve,
        pictures=kept_pictures(content, test[:6]),
    )  # fmt: skip
    times = StepTimes(render_seconds=0, score_seconds=1, total_seconds=1, fit_seconds=1, peak_memory_bytes=1)
    meta = EpisodeMeta(
        steps=[times] * STEPS, total_seconds=9, peak_memory_bytes=10**9, device="cpu", machine={}, packages={},
        revision=None, started="", finished="",
    )  # fmt: skip
    folder = root / "episodes" / "large" / scene.name / method / str(seed)
    write_record(folder / "episode.json", record)
    write_record(folder / "episode.meta.json", meta)
    write_pictures(folder, content)
    os.link(model, folder / "splats.ply")
    return folder / "episode.json"


def first_table(page):
    """Return the seconds from the start of loading until the first table is drawn, the best of three."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        seconds = []
        for _ in range(3):
            tab = browser.new_page()
            begun = time.monotonic()
            tab.goto((page / "index.html").as_uri())
            tab.locator("table.numbers tbody tr").first.wait_for()
            seconds.append(time.monotonic() - begun)
        browser.close()
    return min(seconds)


def main(root, scenes=9, methods=21, seeds=3):
    shutil.rmtree(root, ignore_errors=True)
    rng = np.random.default_rng(0)
    pictures = [texture(rng) for _ in range(25)]
    names = [name for name, found in sorted(registry.methods().items()) if found.method.follows is None][:methods]
    kept = {f"final_{i:03d}.jpg": pictures[i] for i in range(6)}
    for step in range(STEPS):
        kept |= {f"choice_{step:02d}_0_rendering.jpg": pictures[step], f"choice_{step:02d}_0_true.jpg": pictures[step + 1][..., 0]}  # fmt: skip # noqa: E501
    content = archive({name: _encoded(each / 255.0, PictureSettings()) for name, each in kept.items()})
    model = root / "splats.ply"
    root.mkdir(parents=True)
    write_ply(model, gaussians(count=GAUSSIANS))
    page, paths, used = root / "report", [], 0.0
    for number in range(scenes):
        scene = generated_scene(root / "scenes" / "large" / f"scene_{number}", f"scene_{number}", pictures)
        own = [generated_episode(root, scene, name, seed, content, model) for name in names for seed in range(seeds)]
        begun = time.process_time()
        write_scene_scripts(SceneInputs(scene.folder, own), names, {}, PageSettings(), 1 / scenes, page / "scenes" / "large" / scene.name)  # fmt: skip # noqa: E501
        used += time.process_time() - begun
        paths += own
        print(f"scene {number}: {len(own)} episodes", flush=True)
    write_nvs_table(paths, names, "large", None, root / "tables" / "nvs_large", {}, "farthest")
    begun = time.process_time()
    facts = PageFacts("large", {"large": tuple(f"scene_{number}" for number in range(scenes))}, names, {}, {})
    write_page(PageInputs([root / "tables" / "nvs_large.json"]), facts, page)
    used += time.process_time() - begun
    size = sum(path.stat().st_size for path in page.rglob("*") if path.is_file())
    print(f"{len(paths)} episodes: {used:.1f} s of processor time, {size / 1e6:.1f} MB", flush=True)
    print(f"first table after {first_table(page):.2f} s")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(int, sys.argv[2:]))

"""A kind of representation that is added as a folder: a run uses it, and methods that it does not suit are rows."""

import csv
import json

import pytest
import yaml

from tests.workflow.project import checkout_open_to, run, tiny

DESCRIPTION = '''"""A representation of one colour, which offers nothing but what every loop needs."""

from typing import Literal

from pydantic import Field

from avs.representations.base import Kind, RepresentationSettings


class FlatSettings(RepresentationSettings):
    """Settings of one colour."""

    kind: Literal["flat"] = Field(default="flat", description="one colour")
    rate: float = Field(default=0.5, gt=0, le=1, description="part of the way to the mean colour in one step")


KIND = Kind(
    settings=FlatSettings,
    offers=frozenset(),
    exports="colour.txt",
    build="avs.representations.flat.colour:build",
)
'''

CODE = '''"""One colour, fitted step by step."""

import json

import numpy as np

from avs.representations.base import Rendering


class Flat:
    """Renders one colour."""

    primitives = 1

    def __init__(self, settings):
        self.rate = settings.rate
        self.colour = np.zeros(3)

    def fit(self, views, iterations):
        mean = np.mean([image.mean(axis=(0, 1)) / 255 for image in views.images], axis=0)
        self.colour = mean + (self.colour - mean) * (1 - self.rate) ** iterations

    def render(self, cameras):
        width, height = cameras.sizes[0]
        ones = np.ones((len(cameras), height, width), dtype=np.float32)
        return Rendering(ones[..., None] * self.colour.astype(np.float32), ones, ones)

    def save(self, path):
        path.write_text(repr(self.colour.tolist()))

    def load(self, path):
        self.colour = np.array(json.loads(path.read_text()))

    def export(self, folder):
        self.save(folder / "colour.txt")


def build(scene, captured, settings, seed, device):
    return Flat(settings)
'''

METHODS = ("random", "fisherrf", "gauss-mi")


def layout(folder, **changes):
    """Lay out the project with the kind ``flat`` and settings that take seconds."""
    checkout_open_to(folder, "representations")
    (folder / "avs/representations/flat").mkdir()
    (folder / "avs/representations/flat/__init__.py").write_text(DESCRIPTION)
    (folder / "avs/representations/flat/colour.py").write_text(CODE)
    values = tiny() | {"methods": list(METHODS), "representation": {"kind": "flat", "rate": 0.25}}
    (folder / "tiny.yaml").write_text(yaml.safe_dump(values | changes))
    return folder


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = layout(tmp_path_factory.mktemp("flat"))
    result = run(folder, "-j2", "tables")
    assert result.returncode == 0, result.stdout + result.stderr
    return folder / "results" / "tiny"


def rows(path):
    with open(path, newline="") as stream:
        return {row["method"]: row for row in csv.DictReader(stream) if row["metric"] == "psnr"}


def test_a_method_that_renders_runs_on_it(finished):
    folder = finished / "episodes/orbit/orbit_0/random/0"
    record = json.loads((folder / "episode.json").read_text())
    assert record["representation"] == {"kind": "flat", "rate": 0.25}
    assert len(record["selected"]) == 2
    assert len(json.loads((folder / "colour.txt").read_text())) == 3
    assert not (folder / "splats.ply").exists()
    assert float(rows(finished / "tables" / "nvs_orbit.csv")["random"]["mean"]) > 0


@pytest.mark.parametrize(("method", "need"), [("fisherrf", "fisher_diagonal"), ("gauss-mi", "blending_weights")])
def test_a_method_that_it_does_not_suit_is_a_row_with_its_reason(finished, method, need):
    row = rows(finished / "tables" / "nvs_orbit.csv")[method]
    reason = f"representation flat lacks {need}: choose representation.kind gaussians"
    assert reason in row["note"]
    assert not row["mean"]
    assert not (finished / "episodes/orbit/orbit_0" / method).exists()


def test_a_gain_needs_copies_and_the_table_says_so(finished):
    with open(finished / "tables" / "ranking_orbit.csv", newline="") as stream:
        notes = {(row["method"], row["target"]): row["note"] for row in csv.DictReader(stream)}
    assert notes["random", "gain"] == "not measured: the reconstruction cannot be copied"
    assert "not measured" not in notes["random", "ssim"]


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"representation": {"kind": "flt"}},
            "error: configuration: representation.kind: 'flt' is no kind of representation, did you mean flat?; ",
        ),
        (
            {"representation": {"kind": "flat", "rte": 0.5}},
            "error: configuration: representation.rte: unknown key; did you mean rate?",
        ),
    ],
)
def test_a_fault_is_one_line(tmp_path, changes, line):
    result = run(layout(tmp_path, **changes), "-n", "tables")
    assert result.returncode != 0
    (error,) = [text for text in (result.stdout + result.stderr).splitlines() if text.startswith("error: ")]
    assert error.startswith(line)

"""The configuration: typed, typos named, schemas up to date, read without torch."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from avs.config.configuration import load, variant_of
from avs.config.other_representations import on_representation
from avs.config.schemas import SCHEMAS, write_schemas
from avs.report.report_settings import ENDINGS
from avs.system.errors import UserError
from avs.system.models import laid_over

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = sorted((ROOT / "workflows" / "config").glob("*.yaml"))


def values(name="ci"):
    return yaml.safe_load((ROOT / "workflows" / "config" / f"{name}.yaml").read_text())


@pytest.mark.parametrize("path", CONFIGS, ids=lambda path: path.stem)
def test_every_scale_follows_the_schema(path):
    config = load(yaml.safe_load(path.read_text()))
    assert config.scale == path.stem


@pytest.mark.parametrize(
    "path", sorted((ROOT / "workflows/config/overlays").glob("*.yaml")), ids=lambda path: path.stem
)
def test_every_overlay_fits_over_its_scale(path):
    base = "small" if path.stem == "photographs" else "ci"
    assert load(laid_over(values(base), yaml.safe_load(path.read_text())))


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"mehtods": ["random"]}, "configuration: mehtods: unknown key; did you mean methods?"),
        ({"budget": 9}, "configuration: budget: is no key of this section; write it as protocol.budget"),
        (
            {"protocol": {"max_count": 9}},
            "configuration: protocol.max_count: is no key of this section; write it as representation.points.max_count",
        ),
        (
            {"protocol": {"seeds": [0]}},
            "configuration: protocol.seeds: is no key of this section; write seeds outside of all sections",
        ),
        (
            {"datasets": {"orbit": {"source": "embedded", "pattern": "orbit", "seeds": [0], "test_every": 8}}},
            "configuration: datasets.orbit.test_every: is a key of source aria_dtc or .*, not of embedded; remove it",
        ),
        ({"protocol": {"budgett": 9}}, "configuration: protocol.budgett: unknown key; did you mean budget?"),
        (
            {"datasets": {"orbit": {"source": "embeded", "pattern": "orbit", "seeds": [0]}}},
            "configuration: datasets.orbit: unknown source; did you mean embedded?",
        ),
        (
            {"datasets": {"orbit": {"source": "embedded", "patern": "orbit", "pattern": "orbit", "seeds": [0]}}},
            "configuration: datasets.orbit.patern: unknown key; did you mean pattern?",
        ),
        (
            {"datasets": values()["datasets"] | {"captures": {"source": "captures", "published": "x"}}},
            "configuration: .*datasets.captures.published must be one of mipnerf360",
        ),
        ({"datasets": {"Or bit": {"source": "captures"}}}, "configuration: datasets.Or bit.*; correct the value"),
        (
            {"datasets": values()["datasets"] | {"orbit_per_scene": {"source": "captures", "folder": "x"}}},
            "datasets: .*the name orbit_per_scene ends in _per_scene, as a file beside the table of orbit would;",
        ),
        (
            {"datasets": values()["datasets"] | {"x": {"source": "nerfstudio", "folder": "."}}},
            r"configuration: datasets\.x\.axes: is missing; add it: .*opengl \(.*opencv \(",
        ),
        (
            {"datasets": values()["datasets"] | {"x": {"source": "embedded", "seeds": [0]}}},
            r"datasets\.x\.pattern: is missing; add it: .*walkthrough",
        ),
        ({"datasets": {}}, "configuration: .*names the data set handheld_training, which is none of"),
        (
            {"distortions": {"training": ["orbit"], "held_out": ["orbit"]}},
            "configuration: distortions: .*a data set is named twice",
        ),
        ({"method_protocols": {"fisherrf4": {"budgett": 1}}}, r"method_protocols\.fisherrf4\.budgett: unknown key"),
        (
            {"method_protocols": {"random": {"budget": 19}}},
            r"method_protocols\.random: budget of one method alone makes its episodes incomparable",
        ),
        ({"seeds": []}, "configuration: seeds: .*at least 1"),
        ({"seeds": [-1]}, r"configuration: seeds\.0: must be at least 0"),
        ({"seeds": [2**64]}, r"configuration: seeds\.0: must be less than 4294967296"),
        ({"seeds": [0, 1, 0]}, "configuration: seeds: 0 is there twice"),
        ({"seeds": [0.5]}, r"configuration: seeds\.0: must be a whole number"),
        ({"seeds": 3}, "configuration: seeds: must be a list"),
        ({"methods": ["random", "random"]}, "configuration: methods: random is there twice"),
        ({"scale": "../x"}, "configuration: scale: must be of lower-case letters, digits and underscores alone"),
        ({"protocol": {"initial_views": 30}}, "configuration: protocol: initial_views 30 leave nothing to select"),
        ({"datasets": values()["datasets"] | {"x": {}}}, r"configuration: datasets\.x: names no source; add source: "),
        ({"representation": 3}, "configuration: representation: must be a section of keys and values"),
        ({"device": "gpu"}, "configuration: device: .*; correct the value"),
        ({"methods": ["randm"]}, "method 'randm': unknown; did you mean random"),
        ({"selectors": {"fisherrf": {"chian": 1}}}, r"selectors\.fisherrf\.chian: unknown key; did you mean chain\?"),
        ({"distortions": None}, "configuration: .*scorers need the section distortions"),
        ({"scorers": {"dinov2": {}}}, "configuration: .*backbone must be vit_small_patch14_dinov2"),
        ({"scorers": {}}, "method ours-dinov2: needs the scorer dinov2, which the configuration does not train"),
    ],
)
def test_a_fault_is_one_line(change, line):
    with pytest.raises(UserError, match=line) as caught:
        load(values() | change)
    assert "\n" not in str(caught.value)


def test_a_program_whose_name_is_no_identifier_is_refused():
    with pytest.raises(UserError, match=r"method 'my_program' of workflows/baselines: .*; rename the method"):
        load(values(), ["my_program"])


def test_the_schedules_of_the_scales_are_the_papers_scaled():
    paper = load(values("paper")).protocol
    ci = load(values("ci")).protocol
    assert [20 * iteration for iteration in ci.additions] == list(paper.additions)
    assert 20 * ci.iterations == paper.iterations


def test_the_schemas_are_up_to_date(tmp_path):
    write_schemas(tmp_path)
    for name in SCHEMAS:
        committed = (ROOT / "workflows" / "schemas" / name).read_text()
        assert (tmp_path / name).read_text() == committed, "run: python -m avs schemas"


def test_every_setting_is_described():
    def fields(schema):
        for definition in [schema, *schema.get("$defs", {}).values()]:
            yield from definition.get("properties", {}).items()

    undescribed = [
        name
        for name, field in fields(json.loads((ROOT / "workflows" / "schemas" / "config.json").read_text()))
        if "description" not in field
    ]
    assert undescribed == []


def test_reading_the_configuration_imports_no_heavy_library():
    heavy = ("torch", "open3d", "pyiqa", "pycolmap", "numba")
    code = f"import sys, avs.config.configuration; print([m for m in {heavy} if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_the_reference_of_the_tables_is_a_method_or_none():
    assert load(values("ci")).report.reference == "farthest"
    assert load(values("ci") | {"report": {"reference": "fisherrf"}}).report.reference == "fisherrf"
    assert load(values("ci") | {"report": {"reference": None}}).report.reference is None
    with pytest.raises(UserError, match=r"report\.reference: warp is not among the methods; name one of them") as error:
        load(values("ci") | {"report": {"reference": "warp"}})
    assert "\n" not in str(error.value)


VARIED = {"methods": ["random"], "variants": {"few": {"representation": {"densification": {"max_gaussians": 50}}}}}


@pytest.mark.parametrize("ending", ENDINGS)
def test_no_data_set_takes_the_place_of_another_ones_table(ending):
    own = {f"orbit{ending}": values()["datasets"]["orbit"]}
    with pytest.raises(UserError, match=f"the name orbit{ending} ends in {ending}"):
        load(values() | {"datasets": values()["datasets"] | own})
    load(values() | {"datasets": values()["datasets"] | {f"orbit{ending}s": values()["datasets"]["orbit"]}})


def test_the_endings_of_tables_are_those_that_the_rules_add():
    of_data_sets = [path for path in (ROOT / "workflows" / "rules").glob("*.smk") if path.name != "slam.smk"]
    rules = "".join(path.read_text() for path in of_data_sets)
    assert set(re.findall(r'"(_\w+)\.csv"', rules)) == set(ENDINGS)


def test_a_variant_is_laid_over_the_settings_of_the_run():
    config = load(values() | {"sensitivity": VARIED})
    changed = variant_of(config, "few").representation.densification
    assert changed == config.representation.densification.model_copy(update={"max_gaussians": 50})


@pytest.mark.parametrize(
    ("edit", "line"),
    [
        (
            {"variants": {"few": {"representation": {"densification": {"max_gausians": 50}}}}},
            r"sensitivity.variants.few.representation.densification.max_gausians: unknown key; did you mean max_g",
        ),
        ({"variants": {"late": {"protocol": {"additions": [5, 4]}}}}, r"sensitivity.variants.late.protocol: .*ascend"),
        (
            {"variants": {"white": {"representation": {"background": [1, 1, 1]}}}},
            r"sensitivity.variants.white.representation.background: cannot differ from the run's",
        ),
        ({"variants": {"base": {}}}, "no variant can be called base"),
        ({"variants": {}}, r"sensitivity.variants: .* at least 1"),
        ({"methods": ["activenerf-views"]}, "activenerf-views chooses no views in its episodes"),
        ({"methods": ["randm"]}, "randm"),
    ],
)
def test_a_variant_that_does_not_fit_is_one_line(edit, line):
    with pytest.raises(UserError, match=line) as caught:
        load(values() | {"sensitivity": VARIED | edit})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("scale", ["ci", "small", "paper"])
def test_a_representation_called_as_a_kind_is_of_that_kind(scale):
    values = yaml.safe_load((ROOT / "workflows" / "config" / f"{scale}.yaml").read_text())
    values |= {"representation": {"kind": "tensorf"}, "sensitivity": None}
    config = load(values | {"runtime": None})
    found = {name: on_representation(config, name).representation.kind for name in config.agnostic.representations}
    assert found == {kind: kind for kind in ("gaussians", "tensorf", "nerfacto")}
    values["agnostic"]["representations"] |= {"gaussians": {}}
    with pytest.raises(
        UserError, match=r"representations.gaussians: is of the kind tensorf; give it `kind: gaussians`"
    ):
        load(values | {"runtime": None})


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"seeds": [0, True]}, "seeds.1"),
        ({"protocol": values()["protocol"] | {"pool_share": True}}, "protocol.pool_share"),
        (
            {"datasets": values()["datasets"] | {"mine": {"source": "captures", "long_side": True}}},
            "datasets.mine.long_side",
        ),
    ],
)
def test_true_is_no_number(change, place):
    with pytest.raises(UserError) as caught:
        load({**values(), **change})
    assert str(caught.value).startswith(f"configuration: {place}: must be a")


def test_a_figure_shows_methods_that_there_are():
    values = yaml.safe_load((ROOT / "workflows" / "config" / "trial.yaml").read_text())
    with pytest.raises(UserError, match=r"report.figures.methods: fisherfr is no method; did you mean fisherrf\?"):
        load(values | {"report": {"figures": {"methods": ["fisherfr"]}}})
    assert load(values | {"report": {"figures": {"methods": ["best", "random"]}}}).report.figures.rows == 4

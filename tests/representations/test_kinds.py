"""Kinds are described as data: what they offer is what they do, and their settings are a union."""

import subprocess
import sys

import numpy as np
import pytest
from factories import MeanColor, small_scene
from pydantic import Field, ValidationError

from avs.representations import kinds
from avs.representations.base import unwrapped
from avs.representations.capabilities import CAPABILITIES, HasFisherDiagonal, capability
from avs.representations.gaussians.gaussian_settings import GaussianSettings
from avs.representations.kinds import AnyRepresentationSettings
from avs.system.errors import UserError
from avs.system.models import StrictModel

every_kind = pytest.mark.parametrize("name", kinds.kinds())


class Job(StrictModel):
    """Settings with a representation among them."""

    representation: AnyRepresentationSettings = Field(description="any")


class Timed:
    """Hands on ``render``, as a wrapper does that keeps the clock."""

    def __init__(self, inner):
        self.inner = inner

    def render(self, cameras):
        return self.inner.render(cameras)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return small_scene(tmp_path_factory.mktemp("kinds") / "toy", count=16)


def built(scene, name):
    settings = kinds.create_settings({"kind": name})
    return kinds.build(scene, np.arange(4), settings, 0, "cpu")


@every_kind
def test_settings_have_the_name_of_their_kind(name):
    assert kinds.create_settings({"kind": name}) == kinds.find(name).settings()
    assert kinds.find(name).settings().kind == name


@every_kind
def test_an_instance_has_what_its_kind_offers_and_no_more(scene, name):
    representation = built(scene, name)
    has = {name for name, protocol in CAPABILITIES.items() if isinstance(representation, protocol)}
    assert has == kinds.find(name).offers


@every_kind
def test_the_model_is_the_file_that_the_kind_says(scene, name, tmp_path):
    representation = built(scene, name)
    representation.fit(scene.views(np.arange(2)), 1)
    representation.export(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [kinds.find(name).exports]


@every_kind
def test_its_code_is_listed_for_the_rules_that_run_it(name):
    assert kinds.find(name).module.startswith(f"avs.representations.{name}.")


def test_gaussians_are_the_kind_of_settings_that_name_none():
    job = Job.model_validate({"representation": {"iterations": 7}})
    assert job.representation == GaussianSettings(iterations=7)
    assert Job.model_validate_json(job.model_dump_json()) == job
    assert job.model_dump()["representation"]["kind"] == "gaussians"
    assert Job(representation=job.representation).representation is job.representation


def test_the_schema_lists_every_kind():
    schema = Job.model_json_schema()["properties"]["representation"]
    assert len(schema["oneOf"]) == len(kinds.kinds())
    assert schema["discriminator"]["propertyName"] == "kind"
    assert set(schema["discriminator"]["mapping"]) == set(kinds.kinds())


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ({"kind": "gausians"}, ("representation", "kind")),
        ({"kind": ["gaussians"]}, ("representation", "kind")),
        ({"points": {"random_cnt": 3}}, ("representation", "points", "random_cnt")),
        ({"kind": "gaussians", "iterations": 0}, ("representation", "iterations")),
        ([], ("representation",)),
    ],
)
def test_a_fault_lies_where_the_key_is(values, place):
    with pytest.raises(ValidationError) as caught:
        Job.model_validate({"representation": values})
    assert caught.value.errors()[0]["loc"] == place


def test_an_unknown_kind_lists_near_ones():
    with pytest.raises(UserError, match=r"representation\.kind: 'gausians' is no kind .* did you mean gaussians"):
        kinds.create_settings({"kind": "gausians"})
    with pytest.raises(UserError, match="kind of representation 'gausians': unknown; did you mean gaussians"):
        kinds.find("gausians")


def test_a_wrapper_has_the_capabilities_of_what_it_wraps(scene):
    representation = built(scene, "gaussians")
    wrapped = Timed(Timed(representation))
    assert unwrapped(wrapped) is representation
    assert capability(wrapped, HasFisherDiagonal, "fisherrf") is representation
    with pytest.raises(UserError, match="fisherrf: needs the capability fisher_diagonal, which MeanColor lacks; "):
        capability(Timed(MeanColor()), HasFisherDiagonal, "fisherrf")


def test_kinds_and_capabilities_are_read_without_torch():
    heavy = ("torch", "gsplat", "numba", "scipy")
    code = (
        "import sys; from avs.representations import capabilities, kinds; kinds.kinds();"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_a_kind_that_does_not_work_leaves_the_others(tmp_path, monkeypatch):
    for name, text in {
        ".": "",
        "broken": "1 / 0",
        "gaussians": "from avs.representations.gaussians import KIND",
    }.items():
        (tmp_path / "some_kinds" / name).mkdir(exist_ok=True, parents=True)
        (tmp_path / "some_kinds" / name / "__init__.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(kinds, "PACKAGE", "some_kinds")
    found, broken = kinds._found.__wrapped__()
    assert list(found) == ["gaussians"]
    assert broken.keys() == {"some_kinds.broken"}
    assert "ZeroDivisionError" in broken["some_kinds.broken"]

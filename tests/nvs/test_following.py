"""Episodes that capture the views of another method's episode, on a reconstruction that this method has not changed."""

import json
from pathlib import Path

import pytest
from factories import small_scene

from avs.config.configuration import load
from avs.config.jobs import settings_of
from avs.config.method_weights import absent_methods, followed, scoring_methods
from avs.config.run_plan import RunPlan
from avs.config.unfinished_run import unfinished
from avs.nvs.episode_settings import EpisodeSettings
from avs.nvs.experiment import replay_episode, run_episode
from avs.nvs.protocol import ProtocolSettings
from avs.nvs.record import Episode
from avs.representations.gaussians.gaussian_settings import GaussianSettings, InitialPoints
from avs.selection import registry
from avs.selection.contract import REPLAYED, Resources, following
from avs.selection.registry import Registered
from avs.system.errors import UserError
from avs.system.records import read_record, write_record

PROTOCOL = ProtocolSettings(initial_views=3, budget=5, additions=(6, 12), iterations=24)
RECONSTRUCTION = GaussianSettings(points=InitialPoints(random_count=200, opacity=0.9))
MINIMAL = {
    "scale": "tiny",
    "seeds": [0],
    "methods": ["activenerf-views"],
    "datasets": {"orbit": {"source": "embedded", "pattern": "orbit", "seeds": [0]}},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """An episode of ActiveNeRF, and the one that follows it."""
    made = tmp_path_factory.mktemp("following")
    scene = small_scene(made / "scene", count=16)
    run(scene, "activenerf", made / "first")
    run(scene, "activenerf-views", made / "second", followed=made / "first" / "episode.json")
    return made


def run(scene, method, out, seed=0, **source):
    settings = EpisodeSettings(
        method=method, device="cpu", protocol=PROTOCOL, representation=RECONSTRUCTION, selector={}
    )
    run_episode(getattr(scene, "folder", scene), settings, seed, None, out, lambda line: None, **source)
    return read_record(out / "episode.json", Episode)


def test_the_views_are_those_of_the_other_and_the_reconstruction_is_the_plain_one(folder, tmp_path):
    first, second = (read_record(folder / name / "episode.json", Episode) for name in ("first", "second"))
    assert second.selected == first.selected
    assert [step.captured for step in second.steps] == [step.captured for step in first.steps]
    assert (second.method, second.label, second.group) == ("activenerf-views", "ActiveNeRF's views", REPLAYED)
    assert all(step.scores is None for step in second.steps)
    assert second.curve != first.curve
    # The same views as a list that a program wrote: on the common reconstruction.
    (tmp_path / "views.json").write_text(json.dumps({"label": "Listed", "views": first.selected}))
    listed = run(folder / "scene", "listed", tmp_path / "listed", views=tmp_path / "views.json")
    assert second.curve == listed.curve


def test_a_replay_of_it_has_the_same_curve(folder, tmp_path):
    replay_episode(folder / "scene", folder / "second" / "episode.json", "cpu", tmp_path, lambda line: None)
    replayed, recorded = (read_record(place / "episode.json", Episode) for place in (tmp_path, folder / "second"))
    assert replayed.curve == recorded.curve
    assert replayed.label == "Replay of ActiveNeRF's views"


def test_a_replay_of_another_list_does_not_have_the_name_of_the_first(folder, tmp_path):
    values = json.loads((folder / "second" / "episode.json").read_text())
    values["selected"] = values["selected"][::-1]
    (tmp_path / "edited.json").write_text(json.dumps(values))
    replay_episode(folder / "scene", tmp_path / "edited.json", "cpu", tmp_path / "out", lambda line: None)
    assert read_record(tmp_path / "out" / "episode.json", Episode).label == "Edited replay of ActiveNeRF's views"


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"selected": lambda views: [*views, views[0]]}, "selected views, and its budget of"),
        ({"selected": lambda views: views[:-1]}, "selected views, and its budget of"),
        ({"initial": lambda views: views[::-1]}, "and its protocol begins with"),
    ],
)
def test_a_record_with_views_that_a_replay_would_not_capture_is_refused(folder, tmp_path, changes, fault):
    recorded = read_record(folder / "first" / "episode.json", Episode)
    edited = recorded.model_copy(update={name: change(getattr(recorded, name)) for name, change in changes.items()})
    write_record(tmp_path / "episode.json", edited)
    with pytest.raises(UserError, match=fault):
        replay_episode(folder / "scene", tmp_path / "episode.json", "cpu", tmp_path / "out", lambda line: None)


@pytest.mark.parametrize(
    ("seed", "episode", "fault"),
    [
        (1, "first", "has seed 0 instead of 1; pass the episode of the followed method"),
        (0, "second", "has method activenerf-views instead of activenerf"),
        (0, None, "method activenerf-views: captures the views of activenerf; pass --follow"),
        (0, "nowhere", "nowhere.*; run the job that makes it again"),
    ],
)
def test_another_episode_is_one_line(folder, tmp_path, seed, episode, fault):
    source = None if episode is None else folder / episode / "episode.json"
    with pytest.raises(UserError, match=fault) as caught:
        run(folder / "scene", "activenerf-views", tmp_path, seed, followed=source)
    assert "\n" not in str(caught.value)


def test_an_episode_of_another_scene_is_refused(folder, tmp_path):
    other = small_scene(tmp_path / "other", count=20)
    with pytest.raises(UserError, match="has scene_hash"):
        run(other, "activenerf-views", tmp_path / "out", followed=folder / "first" / "episode.json")


def test_it_chooses_nothing_itself_and_is_neither_scored_nor_timed():
    config = load(MINIMAL | {"methods": ["activenerf", "activenerf-views"]})
    assert followed("activenerf-views") == "activenerf"
    assert followed("activenerf") is None
    assert scoring_methods(config, "orbit") == ("activenerf",)
    for table in ("ranking_table/orbit", "runtime_table"):
        reason = settings_of(config, table).absent["activenerf-views"]
        assert str(reason) == "it captures the views of activenerf and chooses none"
    assert settings_of(config, "nvs_table/orbit").absent == {}
    method = registry.find("activenerf-views").method
    with pytest.raises(TypeError, match="chooses none"):
        method.selector(method.settings(), Resources())


@pytest.fixture
def follower(monkeypatch):
    """Register a method that follows another one."""

    def register(other):
        found = dict(registry.methods()) | {"shadow": Registered(following(other, "Shadow", "A test."), "a.plugin")}
        monkeypatch.setattr(registry, "methods", lambda: found)

    return register


def test_where_the_other_cannot_run_the_row_has_its_reason(follower, tmp_path, monkeypatch):
    monkeypatch.setenv("AVS_WEIGHTS", str(tmp_path / "none"))
    monkeypatch.setenv("TORCH_HOME", str(tmp_path / "none"))
    follower("musiq")
    reason = absent_methods(load(MINIMAL | {"methods": ["shadow"]}))["shadow"]
    assert reason.cause.startswith("musiq: weights musiq")
    assert "avs weights fetch musiq" in reason.remedy


@pytest.mark.parametrize("other", ["nobody", "activenerf-views"])
def test_what_is_no_choosing_method_cannot_be_followed(follower, other):
    follower(other)
    with pytest.raises(UserError, match=f"method shadow of a.plugin: follows {other}, which is no method that chooses"):
        load(MINIMAL | {"methods": ["shadow"]})


def test_a_followed_method_needs_its_scorer(follower):
    follower("ours-repvit")
    with pytest.raises(
        UserError, match="method ours-repvit: needs the scorer repvit, which the configuration does not"
    ):
        load(MINIMAL | {"methods": ["shadow"]})


def test_a_missing_episode_is_explained_by_the_log_of_the_one_that_it_follows(tmp_path):
    place = "{dataset}-{scene}-{method}-{seed}"
    own, followed = (str(tmp_path / f"orbit-orbit_0-{name}-0.log") for name in ("activenerf-views", "activenerf"))
    plan = RunPlan(
        results=str(tmp_path),
        config=load(MINIMAL | {"coverage": None}),
        scenes={"orbit": ("orbit_0",)},
        timed=None,
        published_times=(),
        records={
            "scene": str(tmp_path / "scene.json"),
            "episode": str(tmp_path / f"{place}.json"),
            "common_states": str(tmp_path / "states.json"),
            "runtime": "",
        },
        logs={"common_states": str(tmp_path / "states.log"), "episode": str(tmp_path / f"{place}.log")},
        waits_for={own: (followed,)},
    )
    (table,) = unfinished(plan).tables
    (wanted,) = table.episodes
    assert wanted.logs == (Path(own), Path(followed))

"""Episodes with pictures, run for the tests on small scenes with a reconstruction of one colour."""

from factories import MeanColor, small_scene

from avs.nvs.evaluation import Evaluator
from avs.nvs.loop import Identity, Plan, run
from avs.nvs.picture_settings import PictureSettings
from avs.nvs.pictures import write_pictures
from avs.nvs.protocol import ProtocolSettings
from avs.selection import registry
from avs.selection.contract import Method
from avs.system.records import write_record

PROTOCOL = ProtocolSettings(initial_views=4, budget=7, additions=(10, 25, 45), iterations=100)


class Chooser:
    """Scores candidates by their place, from ``shift`` on, and may predict a map."""

    def __init__(self, shift):
        self._shift = shift

    def score(self, state):
        return [float((row + self._shift) % len(state.candidates)) for row in range(len(state.candidates))]


class Predictor(Chooser):
    """Predicts a map that rises from left to right."""

    def predicted_map(self, state, row):
        return [[column / 11 for column in range(12)]] * 8


def write_episode(root, scene, method, seed=0, shift=0, maps=False, settings=None, protocol=PROTOCOL):
    """Run an episode, write it as a run does, and return the path of its record."""
    selector = (Predictor if maps else Chooser)(shift)
    known = registry.methods().get(method)
    label, group = (method, "2D-based") if known is None else (known.method.label, known.method.group)
    metadata = Method(label, group, "A test.", "lowest", lambda given, resources: selector)
    plan = Plan(
        scene=scene,
        protocol=protocol,
        identity=Identity(method, seed, {}, {}, own=() if protocol == PROTOCOL else ("views_per_choice",)),
        method=metadata,
        selector=selector,
        build=lambda captured: MeanColor(),
        evaluate=Evaluator(scene, protocol.lpips),
        progress=lambda line: None,
        pictures=settings or PictureSettings(),
    )
    found = run(plan)
    folder = root / "episodes" / scene.dataset / scene.name / method / str(seed)
    write_pictures(folder, found.pictures)
    write_record(folder / "episode.meta.json", found.meta)
    write_record(folder / "episode.json", found.record)
    return folder / "episode.json"


def written_scene(root, name="toy", **changes):
    """Write a small scene where a run has it, and return it with its folder."""
    folder = root / "scenes" / "toys" / name
    return small_scene(folder, name=name, **changes), folder

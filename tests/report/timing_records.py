"""A small factory of timing records."""

from avs.nvs.timing_record import Runtime, SelectionTimes


def make_record(method="fisherrf", total=(0.4, 0.1, 0.3), render=0.0, **changes):
    fields = {
        "scene": "attic",
        "scene_hash": "hash of attic",
        "method": method,
        "label": method,
        "group": "3D-based",
        "selector": {},
        "seed": 0,
        "iteration": 245,
        "primitives": 4321,
        "own_fit": False,
        "captured": 12,
        "candidates": 44,
        "chosen": 1,
        "image_sizes": [(192, 108)],
        "selections": [
            SelectionTimes(render_seconds=render, score_seconds=each - render, total_seconds=each) for each in total
        ],
        "peak_memory_bytes": 512_000_000,
        "device": "cpu",
        "computed_on": "cpu",
        "other_cores": 0.02,
        "machine": {"processor": "a processor", "cores": "2"},
        "threads": 1,
        "packages": {},
        "revision": None,
        "started": "",
        "finished": "",
    }
    return Runtime(**(fields | changes))

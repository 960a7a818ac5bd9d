"""A small factory of records of common states."""

from avs.nvs.common_states_record import CommonState, CommonStates, ScoredMethod
from avs.selection import registry

# Against 1, 2, 3, 4: one exchange of neighbours has rho 1 - 6 * 2 / (4 * 15) = 0.8 and tau 4/6; two have 0.6 and 2/6.
ORDERED, ONE, TWO = [1.0, 2.0, 3.0, 4.0], [2.0, 1.0, 3.0, 4.0], [2.0, 1.0, 4.0, 3.0]
DEFAULT = {"order": "random", "views": [6, 12], "gain_candidates": 4, "gain_passes": 8}


def state(ssim=ORDERED, psnr=ORDERED, gains=(ORDERED, ORDERED), views=6):
    names = [f"{index}.png" for index in range(len(ssim))]
    measured = None if gains is None else [list(each) for each in gains]
    return CommonState(
        views=views,
        iteration=5,
        primitives=9,
        reconstruction="hash",
        candidates=names,
        psnr=list(psnr),
        ssim=list(ssim),
        gains=measured,
    )


def scored(method, *scores, chooses="lowest", **changes):
    registered = registry.find(method).method
    fields = {
        "method": method,
        "label": registered.label,
        "group": registered.group,
        "chooses": chooses,
        "selector": {},
        "weights_hash": None,
        "own_fit": False,
        "notes": [],
        "scores": list(scores),
        "failure": None,
    }
    return ScoredMethod(**(fields | changes))


def make_states(states, methods, scene="attic", seed=0, **changes):
    fields = {
        "scene": scene,
        "dataset": "orbit",
        "scene_hash": f"hash of {scene}",
        "seed": seed,
        "protocol": {"iterations": 100},
        "representation": {"sh_degree": 3},
        "settings": DEFAULT,
        "captured": ["a.png"],
        "notes": [],
        "states": states,
        "methods": methods,
    }
    return CommonStates(**(fields | changes))

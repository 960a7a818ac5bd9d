"""A small factory of coverage records."""

from avs.coverage.coverage_record import AtThreshold, Coverage, CoveragePoint, Numbers

SETTINGS = {
    "device": "cpu",
    "sfm": {"back_end": "dense", "poses": "known"},
    "threshold": 0.01,
    "thresholds": [0.001, 0.01, 0.1],
    "voxel": 0.005,
    "views": [5],
}
REFERENCE = {"reference_views": "all"}


def numbers(scr, f_score):
    at = [AtThreshold(threshold=each, precision=f_score, recall=scr, f_score=f_score) for each in (0.001, 0.01, 0.1)]
    return Numbers(scr=scr, f_score=f_score, toolbox_f_score=f_score, at=at)


def make_coverage(episode, scr=0.5, true_scr=0.4, f_score=0.6, **changes):
    """The coverage of an episode; ``true_scr`` None for a scene whose surface is not known."""
    views = [*episode.initial, *episode.selected]
    points = [
        CoveragePoint(
            views=count, registered=count, points=100, scr=share * scr, true_scr=true_scr and share * true_scr
        )
        for count, share in ((len(views) - 1, 0.5), (len(views), 1.0))
    ]
    fields = {
        "scene": episode.scene,
        "dataset": episode.dataset,
        "scene_hash": episode.scene_hash,
        "method": episode.method,
        "seed": episode.seed,
        "settings": SETTINGS,
        "reference": REFERENCE,
        "views": views,
        "registered": sorted(views),
        "left_out": {},
        "points": 1000,
        "extent": 10.0,
        "placement": None,
        "against_reference": numbers(scr, f_score),
        "against_surface": None if true_scr is None else numbers(true_scr, f_score / 2),
        "curve": points,
        "absent": {} if true_scr is not None else {"against_surface": "the true surface is not known"},
        "notes": [],
    }
    return Coverage(**(fields | changes))

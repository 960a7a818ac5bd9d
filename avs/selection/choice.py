"""From scores to the views that are captured: the one place where a direction is applied and a contract checked."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from avs.selection.contract import Direction, HasNotes, JointSelector, Method, Selection, Selector, State
from avs.system.global_state import unchanged
from avs.system.seeds import seed_global_generators_from


def choose(scores: npt.NDArray[np.float64], k: int, chooses: Direction) -> npt.NDArray[np.int64]:
    """Return the indices of the ``k`` lowest or highest of n scores, best first; ties go to the lowest index.

    Raises:
        ValueError: a score is not finite, or ``k`` is not in 1..n.
    """
    scores = np.asarray(scores, dtype=np.float64)
    if not np.isfinite(scores).all():
        raise ValueError(f"{np.count_nonzero(~np.isfinite(scores))} of {len(scores)} scores are not finite")
    if not 1 <= k <= len(scores):
        raise ValueError(f"cannot choose {k} of {len(scores)} candidates")
    return np.argsort(scores if chooses == "lowest" else -scores, kind="stable")[:k]


def select_views(method: Method, selector: Selector, state: State, k: int) -> Selection:
    """Return the ``k`` candidates that a method captures next, with its scores.

    Should it draw from generators that the process shares, in place of ``state.rng``, these are seeded like that.

    Args:
        method: its metadata, which tell the direction.
        selector: what ``method`` built.
        state: what it may look at; n candidates.
        k: how many to choose, 1 <= k <= n.

    Raises:
        TypeError: the indices of a joint choice are no array of whole numbers, or scores no real numbers.
        ValueError: the method breaks the contract: scores that are not n finite numbers, or a joint choice that is not
            ``k`` different candidates, includes one that was not scored, or begins with another one than the best by
            the declared direction.
        UserError: what the method raises.
        Exception: what else the method raises. It carries a note that names the method.
    """
    seed_global_generators_from(state.rng)
    try:
        return _selected(method, selector, state, k)
    except (Exception, SystemExit) as error:
        error.add_note(f"method {method.label}")
        raise


def notes_of(method: Method, selector: object) -> list[str]:
    """Return the notes of a selector, if it has any, each with the name of the method before it where it lacks one.

    Raises:
        TypeError: they are no sequence of text.
        UserError: a setting of torch was changed for the whole process to tell them.
    """
    with unchanged(method.label):
        notes = selector.notes if isinstance(selector, HasNotes) else ()
    if not isinstance(notes, tuple | list) or not all(isinstance(note, str) for note in notes):
        raise TypeError(f"{method.label} has notes that are no tuple of texts: {notes!r}")
    return [note if method.label in note else f"{method.label}: {note}" for note in notes]


def _selected(method: Method, selector: Selector, state: State, k: int) -> Selection:
    if isinstance(selector, JointSelector):
        selection = selector.select(state, k)
        if not isinstance(selection.indices, np.ndarray):
            raise TypeError(f"{method.label} returned indices of type {type(selection.indices).__name__}, not an array")
        _check(selection, len(state.candidates), k, method)
        return selection
    scores = selector.score(state)
    if isinstance(scores, np.ma.MaskedArray):
        raise TypeError(f"{method.label} returned masked scores, where each candidate needs one")
    scores = np.asarray(scores)
    if scores.dtype.kind not in "fiu":
        raise TypeError(f"{method.label} returned scores of type {scores.dtype}, not real numbers")
    scores = scores.astype(np.float64)
    _check_scores(scores, len(state.candidates), method.label)
    return Selection(choose(scores, k, method.chooses), scores)


def _check(selection: Selection, candidates: int, k: int, method: Method) -> None:
    """Refuse a joint choice that breaks the contract; a plug-in's author needs to know at once."""
    indices, scores = selection.indices, selection.scores
    if indices.dtype.kind not in "iu":
        raise TypeError(f"{method.label} returned indices of type {indices.dtype}, not whole numbers")
    if len(indices) != k or len(set(indices.tolist())) != k or not ((indices >= 0) & (indices < candidates)).all():
        raise ValueError(f"{method.label} returned indices {indices}, expected {k} different ones of {candidates}")
    if scores is None:
        return
    scored = np.ones(candidates, dtype=bool) if selection.scored is None else selection.scored
    if scored.shape != (candidates,) or scores.shape != (candidates,):
        raise ValueError(f"{method.label} returned scores that are not {candidates} finite numbers")
    rows = np.flatnonzero(scored)
    _check_scores(scores[rows], len(rows), method.label)
    if not scored[indices].all():
        raise ValueError(f"{method.label} chose a candidate that it did not score")
    best = int(rows[choose(scores[rows], 1, method.chooses)[0]])
    if indices[0] != best:
        fault = f"chose candidate {indices[0]} first, whose score is {scores[indices[0]]:g}"
        raise ValueError(f"{method.label} {fault}: the {method.chooses} is {scores[best]:g}, of candidate {best}")


def _check_scores(scores: npt.NDArray[np.float64], count: int, method: str) -> None:
    if scores.shape != (count,) or not np.isfinite(scores).all():
        raise ValueError(f"{method} returned scores that are not {count} finite numbers")

"""Camera paths, one per capture pattern: as people capture, not as a turntable does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from avs.datasets.embedded.geometry.raycast import Caster
from avs.datasets.embedded.layouts.stage import Stage
from avs.scene.cameras import look_at

Poses = npt.NDArray[np.float64]
Generator = np.random.Generator
UP = np.array([0.0, 0.0, 1.0])

# A camera keeps this far from any surface, in metres: a lens has a size, and a leaf before it would hide everything.
CLEARANCE = 0.22


def place(propose: Callable[[float], Poses], caster: Caster) -> Poses:
    """Return the first proposed pose with room around the camera.

    Args:
        propose: returns a pose; its argument grows from 0 to 1 with every refusal, and should loosen the proposal.
        caster: of the scene.
    """
    trials = 24
    for trial in range(trials):
        pose = propose(trial / trials)
        center = -pose[:3, :3].T @ pose[:3, 3]
        if caster.clearance(center[None].astype(np.float32))[0] > CLEARANCE:
            break
    return pose


def rolled(pose: Poses, angle: float) -> Poses:
    """Return ``pose`` turned by ``angle`` in radians about its optical axis."""
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return turn @ pose


def shake(count: int, rng: Generator, smoothness: int = 5) -> npt.NDArray[np.float64]:
    """Return ``[count, 3]`` smooth noise of unit deviation: the unsteadiness of a hand."""
    raw = rng.normal(size=(count + 2 * smoothness, 3))
    kernel = np.hanning(2 * smoothness + 1)
    kernel /= np.sqrt((kernel**2).sum())
    return np.stack([np.convolve(raw[:, k], kernel, "valid") for k in range(3)], axis=1)


def orbit(stage: Stage, count: int, caster: Caster, rng: Generator) -> Poses:
    """Return ``[count, 4, 4]`` poses on three rings about the target that look inwards.

    One side is sampled more densely than the rest, every eighth or so view steps closer to look at a part.
    """
    target, poses = np.asarray(stage.target), []
    shares = np.array([0.4, 0.36, 0.24])
    ring_of = np.searchsorted(np.cumsum(shares)[:-1], np.arange(count) / count, side="right")
    favourite = rng.uniform(0, 2 * np.pi)
    for ring, elevation in enumerate((0.2, 0.48, 0.85)):
        size = int((ring_of == ring).sum())
        even = (np.arange(size) + rng.uniform(0, 1)) / size * 2 * np.pi
        # d(azimuth)/d(even) is smallest at the favourite side: views crowd there.
        azimuths = even - 0.55 * np.sin(even - favourite)
        for azimuth in azimuths:
            close = rng.random() < 0.12

            def propose(
                loose: float, azimuth: float = azimuth, close: bool = close, elevation: float = elevation
            ) -> Poses:
                a = azimuth + rng.normal() * (0.05 + 0.6 * loose)
                e = np.clip(elevation + rng.normal() * (0.07 + 0.2 * loose), 0.08, 1.2)
                r = stage.radius * (0.55 if close else 1.0) * np.exp(rng.normal() * 0.08) * (1 - 0.25 * loose)
                center = target + r * np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
                aim = target + rng.normal(size=3) * np.array([0.14, 0.14, 0.08]) * (2.2 if close else 1.0)
                return rolled(look_at(center, aim, UP), rng.normal() * 0.02)

            poses.append(place(propose, caster))
    return np.stack(poses)


def handheld(stage: Stage, count: int, caster: Caster, rng: Generator) -> Poses:
    """Return poses of a walk on an arc before the subject, the hand a little unsteady, with a step closer midway."""
    target, poses = np.asarray(stage.target), []
    sweep = rng.uniform(1.5, 2.1)
    hand, gaze = shake(count, rng), shake(count, rng)
    for k in range(count):
        part = k / max(count - 1, 1)
        # The walker lingers in the first half of the arc and hurries through the rest.
        angle = stage.heading + sweep * (part**1.4 - 0.5)
        near = 1 - 0.45 * np.exp(-(((part - 0.6) / 0.1) ** 2))

        def propose(loose: float, k: int = k, angle: float = angle, near: float = near) -> Poses:
            a, r = angle + rng.normal() * 0.3 * loose, stage.radius * near * (1 + 0.1 * rng.normal() * loose)
            center = (
                np.array([target[0] + r * np.cos(a), target[1] + r * np.sin(a), 1.55 + 0.3 * loose]) + 0.05 * hand[k]
            )
            return rolled(
                look_at(center, target + 0.12 * stage.radius * gaze[k] * np.array([0.5, 0.5, 0.6]), UP),
                0.03 * hand[k, 0],
            )

        poses.append(place(propose, caster))
    return np.stack(poses)


def egocentric(stage: Stage, count: int, caster: Caster, rng: Generator) -> Poses:
    """Return poses of somebody who walks once around the table, looks at the object, and now and then elsewhere."""
    target, poses = np.asarray(stage.target), []
    start, turn = rng.uniform(0, 2 * np.pi), rng.choice([-1.0, 1.0])
    head, gaze = shake(count, rng, 3), shake(count, rng, 4)
    stance = float(rng.uniform(1.5, 1.68))
    for k in range(count):
        part = k / count
        # One stops at the front: steps are shorter there.
        angle = start + turn * 2 * np.pi * (part - 0.11 * np.sin(2 * np.pi * part))
        bob = 0.02 * np.sin(2 * np.pi * 9 * part)
        away = np.exp(-(((part * 5) % 1 - 0.5) ** 2) / 0.012)

        def propose(loose: float, k: int = k, angle: float = angle, bob: float = bob, away: float = away) -> Poses:
            a, r = angle + rng.normal() * 0.5 * loose, stage.radius * (1 + 0.12 * head[k, 0]) * (1 - 0.2 * loose)
            center = np.array([target[0] + r * np.cos(a), target[1] + r * np.sin(a), stance + bob + 0.03 * head[k, 1]])
            aim = target + np.array([0.2, 0.2, 0.14]) * gaze[k] + away * np.array([-np.sin(a), np.cos(a), 0.25]) * 0.9
            return rolled(look_at(center, aim, UP), 0.05 * head[k, 2])

        poses.append(place(propose, caster))
    return np.stack(poses)


def walkthrough(stage: Stage, count: int, caster: Caster, rng: Generator) -> Poses:
    """Return poses of a steady walk along the stage's path that looks ahead, as a filmed tour of a flat does."""
    line = _smooth_path(np.asarray(stage.path))
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    ahead = 1.4
    # The pace varies: slow at the start of the tour, quick in the middle.
    pace = np.cumsum(1 + 0.5 * np.sin(np.linspace(0, np.pi, count)) + 0.1 * shake(count, rng)[:, 0])
    travelled = (pace - pace[0]) / (pace[-1] - pace[0]) * (length[-1] - ahead)
    sway, gaze, poses = shake(count, rng, 8), shake(count, rng, 8), []
    height = float(rng.uniform(1.45, 1.6))
    for k, distance in enumerate(travelled):
        here, there = (
            np.array([np.interp(d, length, line[:, i]) for i in range(2)]) for d in (distance, distance + ahead)
        )

        def propose(loose: float, k: int = k, here: Poses = here, there: Poses = there) -> Poses:
            center = np.array([*(here + 0.3 * loose * rng.normal(size=2)), height + 0.025 * sway[k, 0]])
            aim = np.array([*there, height - 0.16 + 0.05 * gaze[k, 2]]) + 0.2 * np.array([*gaze[k, :2], 0.0])
            return rolled(look_at(center, aim, UP), 0.008 * sway[k, 1])

        poses.append(place(propose, caster))
    return np.stack(poses)


def _smooth_path(points: Poses) -> Poses:
    """Return the polyline ``points`` ``[n, 2]`` resampled every 5 cm and averaged over 90 cm: round corners."""
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    places = np.arange(0, length[-1], 0.05)
    dense = np.stack([np.interp(places, length, points[:, i]) for i in range(2)], axis=1)
    window = 19
    padded = np.concatenate([np.repeat(dense[:1], window // 2, 0), dense, np.repeat(dense[-1:], window // 2, 0)])
    return np.stack([np.convolve(padded[:, i], np.full(window, 1 / window), "valid") for i in range(2)], axis=1)

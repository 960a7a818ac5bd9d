"""Camera paths, one per capture pattern: as people capture, not as a turntable does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from avs.cameras import look_at
from avs.datasets.embedded.raycast import Caster
from avs.datasets.embedded.stage import Stage

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
        angle = stage.heading + sweep * (part**1.4 - 0.5) * (1 if rng.random() < 2 else -1)
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

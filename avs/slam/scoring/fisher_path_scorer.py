"""FisherRF's choice of a path as its mapping was released (commit 8b196cd of its repository)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from avs.rasterizer.fisher_diagonal import fisher_diagonal
from avs.representations.gaussians.initialization import SH_DEGREE_0
from avs.scene.cameras import Cameras
from avs.slam.building.robot_camera import camera_at
from avs.slam.exploration.planned_paths import PlannedPath
from avs.slam.mapping.gaussian_map import MapTensors, camera_tensors
from avs.slam.scoring.path_scorer import FloatArray, Moment, Shortlist, spread_keyframes
from avs.slam.scoring.path_settings import FisherPathSettings


@dataclass(frozen=True)
class _Information:
    """Squares ``[m, 4]`` by position and opacity of the Gaussians ``rows`` ``[m]`` that one view shows."""

    rows: npt.NDArray[np.int64]
    values: FloatArray


class FisherPathScorer:
    """FisherRF: information at the end and along the way, against that of the keyframes."""

    label = "FisherRF"
    notes: tuple[str, ...] = ()

    def __init__(self, settings: FisherPathSettings) -> None:
        """Score by ``settings``."""
        self.settings = settings
        self._known: tuple[int, FloatArray] | None = None

    def shortlist(self, moment: Moment, count: int) -> Shortlist:
        """Return the ``count`` candidates of the highest score by themselves, the best first."""
        known = self._of_keyframes(moment)
        cameras = [camera_at(candidate.pose, moment.camera) for candidate in moment.candidates]
        settings = self.settings
        gains = [_gain(one, known, settings.endpoint_regularisation) for one in self._information(moment, cameras)]
        scores = np.array(gains)
        return Shortlist(np.argsort(-scores, kind="stable")[:count].astype(np.int64), scores)

    def score(self, moment: Moment, listed: Shortlist, paths: Sequence[PlannedPath]) -> FloatArray:
        """Return the mean information gained per action of each path, plus that of its candidate, weighted."""
        assert listed.scores is not None
        known, settings = self._of_keyframes(moment), self.settings
        scores = np.empty(len(paths))
        for place, path in enumerate(paths):
            endpoint = listed.scores[path.candidate]
            if settings.endpoint == "logarithm":
                endpoint = _logarithm(endpoint)
            along = self._along(moment, path, known) / len(path.actions)
            scores[place] = along + settings.endpoint_weight * endpoint
        return scores

    def _along(self, moment: Moment, path: PlannedPath, known: FloatArray) -> float:
        """Return the sum over some poses of the logarithm of the gain there, each against those before it, too."""
        settings, total = self.settings, 0.0
        # The released code counts one action more than it has done: of every five, the 4th, 9th and 14th.
        first = (settings.every - 2) % settings.every
        cameras = [camera_at(pose, moment.camera) for pose in path.poses[first :: settings.every]]
        known = known.copy()
        for one in self._information(moment, cameras):
            gain = _gain(one, known, settings.path_regularisation)
            total += _logarithm(gain)
            known[one.rows] += one.values
        return total

    def _of_keyframes(self, moment: Moment) -> FloatArray:
        """Return the sum ``[n, 4]`` over the keyframes, computed once for each decision."""
        if self._known is None or self._known[0] != moment.decision:
            keyframes = spread_keyframes(moment, self.settings.keyframes)
            known = np.zeros((len(moment.tensors["means"]), 4))
            for one in self._information(moment, [keyframe.camera for keyframe in keyframes]):
                known[one.rows] += one.values
            self._known = moment.decision, known
        return self._known[1]

    def _information(self, moment: Moment, cameras: Sequence[Cameras]) -> Iterator[_Information]:
        return (_of_camera(moment.tensors, camera, self.settings) for camera in cameras)


def _gain(one: _Information, known: FloatArray, regularisation: float) -> float:
    return float((one.values / (known[one.rows] + regularisation)).sum())


def _logarithm(gain: float) -> float:
    """Return the logarithm; of nothing at all a finite number below all others, where the released code has none."""
    return float(np.log(max(gain, np.finfo(float).tiny)))


@torch.no_grad()
def _of_camera(tensors: MapTensors, camera: Cameras, settings: FisherPathSettings) -> _Information:
    """Return the information of one view about positions and activated opacities."""
    viewmat, intrinsics = camera_tensors(camera)
    means, count = tensors["means"].detach(), len(tensors["means"])
    if settings.frame == "camera":
        means, viewmat = means @ viewmat[:3, :3].T + viewmat[:3, 3], torch.eye(4)
    width, height = (int(side) for side in camera.sizes[0])
    found = fisher_diagonal(
        means=means,
        quats=torch.tensor([1.0, 0.0, 0.0, 0.0]).repeat(count, 1),
        scales=tensors["scales"].detach().exp().expand(count, 3),
        opacities=tensors["opacities"].detach().sigmoid(),
        sh_coefficients=((tensors["rgb"].detach() - 0.5) / SH_DEGREE_0)[:, None],
        viewmat=viewmat,
        intrinsics=intrinsics,
        width=width,
        height=height,
        sh_degree=0,
        rotations=False,
    )
    values = np.concatenate([found.means.numpy(), found.opacities.numpy()[:, None]], axis=1)
    return _Information(found.rows.numpy(), values.astype(np.float64) * settings.gradient**2)

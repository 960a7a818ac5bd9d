"""An exploration: look, map, decide, go. Knows no method by name."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from avs.scene.cameras import Cameras
from avs.slam.building.robot_camera import Pose, camera_at, pose_of
from avs.slam.evaluation.map_quality import coverage_of
from avs.slam.evaluation.seen_surface import SeenSurface
from avs.slam.exploration.exploration_settings import ExplorationSettings
from avs.slam.exploration.frontiers import Candidate, Frontier, candidates, eroded, frontiers
from avs.slam.exploration.occupancy import Occupancy, empty_occupancy, free_space, vote
from avs.slam.exploration.planned_paths import PlannedPath, planned_paths
from avs.slam.loop.clocks import Clocks
from avs.slam.loop.exploration_record import LETTERS, CoveragePoint, Decision, FrontierEntry, PathEntry, PoseNumbers
from avs.slam.loop.robot_world import World
from avs.slam.loop.slam_settings import SlamSettings
from avs.slam.mapping.mapper import Mapper
from avs.slam.navigation.grid_paths import Grid
from avs.slam.navigation.robot_motion import Action, move
from avs.slam.scoring.path_scorer import Moment, PathScorer, Shortlist
from avs.system import provenance
from avs.system.seeds import seed_of

Progress = Callable[[str], None]

_STUCK = 0.25
_SAME_FRONTIER = 0.3
BUDGET_SPENT = "all actions were done"


@dataclass(frozen=True)
class Options:
    """What a decision is made among.

    Attributes:
        borders: frontiers, the best first.
        candidates: poses to go to.
        listed: those with paths.
        paths: at least one.
    """

    borders: list[Frontier]
    candidates: list[Candidate]
    listed: Shortlist
    paths: list[PlannedPath]


class Exploration:
    """The state of a robot while it explores.

    Attributes:
        pose: where it is, truly.
        step: actions done so far.
        mapper: its map.
        grid: what it knows of the floor.
        trajectory: all poses so far, the first included.
        decisions: so far.
        curve: of coverage.
        targets: centroids of the frontiers that decisions have gone to.
        length: of its way, metres.
        collisions: actions during which something was in the way.
        ended: why it ended; empty while it goes on.
        clocks: time by module.
    """

    def __init__(self, world: World, settings: SlamSettings, seed: int, surface: SeenSurface) -> None:
        """Stand at the start, with nothing seen."""
        self.world, self.settings, self.seed, self.surface = world, settings, seed, surface
        self.pose = world.start
        self.step = 0
        self.mapper = Mapper(settings.mapper, seed_of("slam mapper", world.name, seed))
        self.grid: Occupancy = empty_occupancy(world.start, settings.exploration.occupancy)
        self.trajectory: list[Pose] = []
        self.decisions: list[Decision] = []
        self.curve: list[CoveragePoint] = []
        self.targets: list[npt.NDArray[np.float64]] = []
        self.length = 0.0
        self.collisions = 0
        self.ended = ""
        self.clocks = Clocks()

    @property
    def plan(self) -> ExplorationSettings:
        """The settings of the exploration."""
        return self.settings.exploration

    @property
    def camera(self) -> Cameras:
        """The camera where the robot takes itself to be: the true one where poses are given, else as it was tracked."""
        true = camera_at(self.pose, self.settings.camera)
        return (
            true
            if self.settings.mapper.tracking is None
            else replace(true, world_to_camera=np.array(self.mapper.poses[-1:]))
        )

    @property
    def believed(self) -> Pose:
        """Where the robot takes itself to be, and plans from."""
        if self.settings.mapper.tracking is None:
            return self.pose
        return pose_of(self.mapper.poses[-1], self.settings.camera)

    def begin(self) -> None:
        """Look, and turn on the spot."""
        self.look()
        for _ in range(min(self.plan.turns, self.plan.steps)):
            self.act("left")

    def decide_and_go(self, scorer: PathScorer) -> None:
        """Choose a path and follow it; the exploration ends where there is none, or no action is left."""
        if self.step >= self.plan.steps:
            self.ended = BUDGET_SPENT
            return
        start, before = self.clocks.now(), self.clocks.seconds["score"]
        moment, options = self.options(scorer)
        if options is None:
            self.ended = "no frontier is left that can be reached, and no other place can be"
            return
        with self.clocks.of("score"):
            scores = np.asarray(scorer.score(moment, options.listed, options.paths), np.float64)
        if scores.shape != (len(options.paths),) or not np.isfinite(scores).all():
            raise ValueError(f"{scorer.label} returned scores that are not {len(options.paths)} finite numbers")
        chosen = int(np.argmax(scores))
        self.clocks.decisions.append(self.clocks.now() - start)
        self.clocks.scores.append(self.clocks.seconds["score"] - before)
        began, pose = self.step, self.pose
        path = options.paths[chosen]
        frontier = options.candidates[path.candidate].frontier
        if frontier >= 0:
            self.targets.append(options.borders[frontier].centroid)
        gaussians = len(self.mapper.tensors["means"])
        self.follow(path.actions)
        self.decisions.append(_entry(began, pose, gaussians, options, scores, chosen, self.step - began))

    def options(self, scorer: PathScorer) -> tuple[Moment, Options | None]:
        """Return what can be chosen among; None where no path leads anywhere.

        Free space is eroded as far as settings say; where no path is left it is eroded by half of that. Where the
        frontiers cannot be reached, places by chance take their part.
        """
        plan = self.plan
        with self.clocks.of("plan"):
            means = np.asarray(self.mapper.tensors["means"].detach().numpy())
            free = free_space(self.grid, means, self.believed)
            borders = self._patient(frontiers(self.grid, free, self.believed, plan.frontiers))
        moment, rng = self._moment([]), self._generator("candidates")
        for targets in (borders, []) if borders else ([],):
            for erosion in (plan.frontiers.erosion, max(1, plan.frontiers.erosion // 2)):
                inner = eroded(free, erosion)
                drawn = candidates(self.grid, inner, targets, self.believed, plan.frontiers, rng)
                moment = self._moment(drawn)
                found = self._paths(scorer, moment, free, inner) if drawn else None
                if found is not None:
                    return moment, Options(borders, drawn, *found)
        return moment, None

    def _paths(
        self, scorer: PathScorer, moment: Moment, free: Grid, inner: Grid
    ) -> tuple[Shortlist, list[PlannedPath]] | None:
        """Return paths to the candidates of the shortlist; to all of them where none of those is reached."""
        with self.clocks.of("score"):
            listed = scorer.shortlist(moment, self.plan.paths.shortlist)
        with self.clocks.of("plan"):
            for indices in (listed.indices.tolist(), range(len(moment.candidates))):
                wanted = [(index, moment.candidates[index]) for index in indices]
                plan, motion = self.plan.paths, self.settings.motion
                paths = planned_paths(self.grid, free, inner, self.believed, wanted, plan, motion)
                if paths:
                    return listed, paths[: self.plan.paths.shortlist]
        return None

    def follow(self, actions: tuple[Action, ...]) -> None:
        """Do ``actions`` until one is stopped by something that the robot did not know of, or none is left."""
        for action in actions:
            if self.step >= self.plan.steps:
                return
            before = self.pose
            collided = self.act(action)
            moved = math.hypot(self.pose.x - before.x, self.pose.y - before.y)
            if collided and moved < _STUCK * self.settings.motion.forward:
                reach = self.settings.agent.radius
                own = self.believed
                ahead = own.x + reach * math.cos(own.yaw), own.y + reach * math.sin(own.yaw)
                self.grid.blocked[tuple(self.grid.cell_of(*ahead))] = True
                return

    def act(self, action: Action) -> bool:
        """Do one action and look; return whether something was in the way."""
        before = self.pose
        moved = move(self.world.floor_map, before, action, self.settings.motion)
        self.pose = moved.pose
        self.step += 1
        self.length += math.hypot(self.pose.x - before.x, self.pose.y - before.y)
        self.collisions += moved.collided
        self.look()
        return moved.collided

    def look(self) -> None:
        """Take a picture, and let the map, the grid and the measurements have it."""
        camera = camera_at(self.pose, self.settings.camera)
        with self.clocks.of("simulate"):
            frame = self.world.simulator.observe(camera)
        self.trajectory.append(self.pose)
        self.mapper.add(frame, camera)
        with self.clocks.of("plan"):
            vote(self.grid, frame.depth, self.camera, self.believed, self.settings.agent.radius)
        with self.clocks.of("measure"):
            self.surface.look(camera, frame.depth)
            if self.step % self.settings.evaluation.every == 0:
                self.measure()

    def measure(self) -> None:
        """Append a point to the curve of coverage, once for each number of actions."""
        if self.curve and self.curve[-1].step == self.step:
            return
        means = self.mapper.tensors["means"].detach().numpy()
        self.curve.append(
            CoveragePoint(
                step=self.step,
                scr_means=coverage_of(self.surface.points, means, self.settings.evaluation.threshold),
                seen=self.surface.share,
                gaussians=len(means),
                path_length=self.length,
            )
        )
        self.clocks.memory.append(provenance.peak_memory("cpu"))

    def _moment(self, drawn: list[Candidate]) -> Moment:
        tensors, keyframes, rng = self.mapper.tensors, self.mapper.keyframes, self._generator("decision")
        camera, decision = self.settings.camera, len(self.decisions)
        return Moment(self.believed, drawn, tensors, keyframes, camera, rng, decision, self.clocks.aside)

    def _generator(self, use: str) -> np.random.Generator:
        """Return the generator of one use at this decision: what is drawn for another does not show in its draws."""
        return np.random.default_rng(seed_of(f"slam {use}", self.world.name, self.seed, len(self.decisions)))

    def _patient(self, found: list[Frontier]) -> list[Frontier]:
        """Return the frontiers without those that have been gone to too often."""
        patience = self.plan.frontiers.patience
        if patience is None or not self.targets:
            return found
        gone_to = np.array(self.targets)
        counts = [np.count_nonzero(np.linalg.norm(gone_to - one.centroid, axis=1) < _SAME_FRONTIER) for one in found]
        return [one for one, count in zip(found, counts, strict=True) if count < patience]


def pose_numbers(pose: Pose) -> PoseNumbers:
    """Return a pose as a record has it."""
    return (pose.x, pose.y, pose.floor, pose.yaw)


def _entry(
    step: int,
    pose: Pose,
    gaussians: int,
    options: Options,
    scores: npt.NDArray[np.float64],
    chosen: int,
    executed: int,
) -> Decision:
    borders = [
        FrontierEntry(x=one.centroid[0], y=one.centroid[1], cells=len(one.cells), merit=one.merit)
        for one in options.borders
    ]
    paths = [
        PathEntry(
            candidate=path.candidate,
            actions="".join(LETTERS[action] for action in path.actions),
            length=path.length,
            score=score,
        )
        for path, score in zip(options.paths, scores.tolist(), strict=True)
    ]
    own = options.listed.scores
    return Decision(
        step=step,
        pose=pose_numbers(pose),
        gaussians=gaussians,
        frontiers=borders,
        candidates=[pose_numbers(candidate.pose) for candidate in options.candidates],
        frontier_of=[candidate.frontier for candidate in options.candidates],
        endpoint_scores=None if own is None else own.tolist(),
        paths=paths,
        chosen=chosen,
        executed=executed,
    )

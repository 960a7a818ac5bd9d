"""The explorations of a run: which buildings, what chooses the paths, and everything else that they are made of."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Literal

from pydantic import Field

from avs.selection.registry import create_settings, find, needed
from avs.slam.loop.slam_settings import RobotSettings, SlamSettings, StartPose
from avs.slam.scoring.able_methods import why_not_exploring
from avs.slam.scoring.path_settings import PathScorerSettings, SelectorPathSettings
from avs.system.errors import UserError
from avs.system.models import Different, Seed, StrictModel
from avs.system.reasons import Reason

BuildingName = Annotated[str, Field(pattern=r"^[a-z0-9_]+$")]
MethodName = Annotated[str, Field(pattern=r"^[a-z0-9][a-z0-9-]*$")]


class ApartmentBuilding(StrictModel):
    """An embedded flat of four to six furnished rooms."""

    source: Literal["apartment"] = Field(default="apartment", description="a flat that is drawn from a seed")
    seed: Seed = Field(default=3, description="of the flat; not all have doors that furniture leaves open")
    start: StartPose | None = Field(default=None, description="of the robot; null: by chance, by the seed")


class MeshBuilding(StrictModel):
    """A building of one's own."""

    source: Literal["mesh"] = Field(default="mesh", description="a mesh from a file")
    file: str = Field(description="a .glb, .gltf, .obj or .ply file, such as those of Gibson, HM3D or Replica")
    start: StartPose | None = Field(default=None, description="of the robot; null: by chance, by the seed")


AnyBuilding = Annotated[ApartmentBuilding | MeshBuilding, Field(discriminator="source")]


class SlamConfig(StrictModel):
    """Active SLAM: a robot explores buildings, and what chooses its paths is compared."""

    buildings: dict[BuildingName, AnyBuilding] = Field(
        default={}, description="by name, in the order of rows; without any, nothing is explored"
    )
    methods: dict[MethodName, PathScorerSettings] = Field(
        min_length=1, description="what chooses the paths, by identifier, in the order of rows"
    )
    seeds: Annotated[tuple[Seed, ...], Different] = Field(
        default=(0,), min_length=1, description="each exploration runs once with each; it draws the start, too"
    )
    robot: RobotSettings = Field(default=RobotSettings(), description="everything else")
    with_tables: bool = Field(
        default=True,
        description="whether the target tables makes its table too; otherwise the target explore alone does",
    )


class BuildingJob(StrictModel):
    """What the making of a building reads."""

    building: AnyBuilding = Field(description="which")


class SlamFigureJob(StrictModel):
    """What a figure or table of explorations reads."""

    absent: dict[str, Reason] = Field(default={}, description="why a method does not explore, by identifier")
    absent_buildings: dict[str, Reason] = Field(default={}, description="why a building is not explored, by name")
    buildings: tuple[str, ...] = Field(description="names, in order, of those that are not explored, too")
    methods: tuple[str, ...] = Field(description="identifiers, in order")
    choosers: dict[str, PathScorerSettings] = Field(description="what chooses the paths, by these identifiers")
    seeds: tuple[int, ...] = Field(description="of the records")

    @property
    def explored(self) -> tuple[str, ...]:
        """The names of the buildings that are explored, in order."""
        return tuple(name for name in self.buildings if name not in self.absent_buildings)

    @property
    def in_order(self) -> dict[str, PathScorerSettings]:
        """What chooses the paths, by identifier, in order: a record keeps none of its entries by name."""
        return {name: self.choosers[name] for name in self.methods}


def exploration_settings(slam: SlamConfig, building: str, method: str) -> SlamSettings:
    """Return what an exploration of ``building`` by ``method`` reads."""
    start, scorer = slam.buildings[building].start, slam.methods[method]
    return SlamSettings.model_validate({**dict(slam.robot), "scorer": scorer, "start": start})


def slam_figure(slam: SlamConfig, absent: dict[str, Reason], absent_buildings: dict[str, Reason]) -> SlamFigureJob:
    """Return which records a figure or table holds."""
    return SlamFigureJob(
        buildings=tuple(slam.buildings),
        methods=tuple(slam.methods),
        choosers=slam.methods,
        seeds=slam.seeds,
        absent=absent,
        absent_buildings=absent_buildings,
    )


def explorers(slam: SlamConfig | None) -> dict[str, SelectorPathSettings]:
    """Return the methods of Task A among those that choose paths, by the identifier that they have there."""
    methods = {} if slam is None else slam.methods
    return {name: scorer for name, scorer in methods.items() if isinstance(scorer, SelectorPathSettings)}


def untrained(slam: SlamConfig | None, scorers: Collection[str]) -> dict[str, Reason]:
    """Return the methods of Task A that need a scorer which the run does not train, with the reason."""
    needed = {name: find(told.method).method.scorer for name, told in explorers(slam).items()}
    return {
        name: Reason(
            cause=f"needs the scorer {scorer}, which the configuration does not train", remedy=f"add scorers.{scorer}"
        )
        for name, scorer in needed.items()
        if scorer is not None and scorer not in scorers
    }


def check_slam(slam: SlamConfig | None) -> None:
    """Refuse methods of Task A that are unknown, have wrong settings, or cannot choose paths.

    Raises:
        UserError: names the first.
    """
    for name, told in explorers(slam).items():
        method = find(told.method).method
        settings = create_settings(told.method, told.settings)
        subject = f"configuration: slam.methods.{name}"
        fault = why_not_exploring(method, needed(told.method, settings))
        if fault is not None:
            raise UserError(subject, f"{told.method} {fault}", "choose another method")

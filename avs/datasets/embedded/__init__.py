"""Embedded scenes: synthetic captures made on the spot from a seed, so that nothing has to be downloaded.

A scene is drawn from its pattern and seed: layout, materials, things, weather and light. Textured meshes are ray-cast
with sun, sky, lamps, shadows, light passed on between surfaces, and reflections; the textures are the photographs that
scikit-image carries and procedural noise. Each pattern stands for one data set of the literature:

- ``orbit`` (Mip-NeRF360): inward-facing rings around a centre piece; even seeds outdoors, odd seeds indoors.
- ``walkthrough`` (RealEstate10K): smooth forward motion through furnished rooms, 16:9.
- ``handheld`` (Map-Free): an arc around a statue or a facade outdoors, portrait 9:16, exposure jitter.
- ``egocentric`` (ARIA): a walk around a table at the height of the head, wide angle, square, vignette, dark.

``make_apartment`` saves rooms as one textured mesh.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field

from avs.datasets.embedded.embedded_settings import EmbeddedSettings
from avs.datasets.reader import Reader
from avs.system.models import Different, Seed

PatternName = Literal["orbit", "walkthrough", "handheld", "egocentric"]


class EmbeddedScenes(Reader):
    """Scenes of one pattern, one for each seed."""

    source: Literal["embedded"] = Field(default="embedded", description="scenes made on the spot from seeds")
    pattern: PatternName = Field(description="what the scenes show and how the camera moves")
    seeds: Annotated[tuple[Seed, ...], Different] = Field(
        min_length=1, description="a scene for each; what it shows depends on it alone"
    )
    capture: EmbeddedSettings = Field(default_factory=EmbeddedSettings, description="how they are captured")

    def scenes(self) -> dict[str, Self]:
        """Return the settings of each scene, called by its pattern and seed, such as ``orbit_0``."""
        return {f"{self.pattern}_{seed}": self.model_copy(update={"seeds": (seed,)}) for seed in self.seeds}

    def files(self) -> list[Path]:
        """Return nothing: there is no file of the user's."""
        return []

    def identities(self) -> tuple[tuple[object, ...], ...]:
        """Return the pattern and the seed."""
        return ((self.source, self.pattern, *self.seeds),)

    def prepare(self, dataset: str, folder: Path) -> None:
        """Make the scene."""
        make_scene(self.pattern, self.seeds[0], self.capture, folder, dataset)

    def render_seed(self) -> int:
        """Return the scene's own seed."""
        return self.seeds[0]


READER = EmbeddedScenes


def make_scene(pattern: str, seed: int, settings: EmbeddedSettings, folder: Path, dataset: str | None = None) -> None:
    """Write the scene of ``pattern`` that ``seed`` draws to ``folder``; equal arguments give equal bytes.

    It belongs to ``dataset``, by default called as ``pattern``.

    Raises:
        UserError: there is no such pattern.
    """
    from avs.datasets.embedded.capture import build_capture, write_capture

    write_capture(build_capture(pattern, seed, settings), pattern, seed, folder, dataset)


def make_apartment(seed: int, folder: Path, settings: EmbeddedSettings | None = None) -> None:
    """Write the flat that ``seed`` draws to ``folder``: ``mesh.ply`` with coloured vertices, and ``apartment.json``."""
    from avs.datasets.embedded.apartment import write_apartment

    write_apartment(seed, folder, settings or EmbeddedSettings())

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

from avs.datasets.embedded.embedded_settings import EmbeddedSettings


def make_scene(pattern: str, seed: int, settings: EmbeddedSettings, folder: Path) -> None:
    """Write the scene of ``pattern`` that ``seed`` draws to ``folder``; equal arguments give equal bytes.

    Raises:
        UserError: there is no such pattern.
    """
    from avs.datasets.embedded.capture import build_capture, write_capture

    write_capture(build_capture(pattern, seed, settings), pattern, seed, folder)


def make_apartment(seed: int, folder: Path, settings: EmbeddedSettings | None = None) -> None:
    """Write the flat that ``seed`` draws to ``folder``: ``mesh.ply`` with coloured vertices, and ``apartment.json``."""
    from avs.datasets.embedded.apartment import write_apartment

    write_apartment(seed, folder, settings or EmbeddedSettings())

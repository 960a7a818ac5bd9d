"""Compiles TensoRF's CPU kernels ahead of their first use, so that no episode's times include it."""

from __future__ import annotations

from avs.representations.ray_fields.first_steps import fit_and_render
from avs.representations.tensorf.tensorf_settings import Grid, TensorfSettings
from avs.representations.tensorf.vector_matrix_field import field_in


def compile_tensorf() -> None:
    """Fit and render a small field once; numba keeps what it compiles on disk."""
    settings = TensorfSettings(
        rays=16, samples=8, density_components=2, appearance_components=2, hidden=4, grid=Grid(initial=4, final=4)
    )
    fit_and_render(field_in, settings)

"""Compiles Nerfacto's CPU kernels ahead of their first use, so that no episode's times include it."""

from __future__ import annotations

from avs.representations.nerfacto.nerfacto_field import field_in
from avs.representations.nerfacto.nerfacto_settings import HashGrid, NerfactoSettings, Proposal
from avs.representations.ray_fields.first_steps import fit_and_render


def compile_nerfacto() -> None:
    """Fit and render a small field once; numba keeps what it compiles on disk."""
    grid = HashGrid(levels=2, coarsest=2, finest=4, log2_entries=6)
    settings = NerfactoSettings(rays=16, samples=4, grid=grid, proposals=(Proposal(samples=4, grid=grid),), hidden=4)
    fit_and_render(field_in, settings)

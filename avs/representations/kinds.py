"""Kinds of representations, found by name: the sub-packages of ``avs.representations`` that have a ``KIND``."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated, Any, cast

from pydantic import ValidationError

from avs.representations.base import Kind, Representation, RepresentationSettings
from avs.scene.cameras import IndexArray
from avs.scene.scene import Scene
from avs.system.errors import UserError
from avs.system.models import first_fault
from avs.system.named_settings import NamedSettings
from avs.system.opened_files import expect_code_of_others
from avs.system.plugin_modules import import_each

PACKAGE = "avs.representations"
"""The package whose sub-packages are searched."""

Builder = Callable[[Scene, IndexArray, RepresentationSettings, int, str], Representation]


def kinds() -> Mapping[str, Kind]:
    """Return every kind by name, in the order of names; a package that cannot be imported is left out."""
    return _found()[0]


def broken() -> dict[str, str]:
    """Return why each package that should define a kind cannot be imported."""
    return _found()[1]


@functools.cache
def _found() -> tuple[Mapping[str, Kind], dict[str, str]]:
    expect_code_of_others()
    package = importlib.import_module(PACKAGE)
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__) if module.ispkg)
    modules, faults = import_each(f"{PACKAGE}.{name}" for name in names)
    defined = {name.rpartition(".")[2]: getattr(module, "KIND", None) for name, module in modules.items()}
    return MappingProxyType({name: kind for name, kind in defined.items() if isinstance(kind, Kind)}), faults


def find(name: str) -> Kind:
    """Return the kind called ``name``.

    Raises:
        UserError: there is none; the line lists near names.
    """
    if name not in kinds():
        raise UserError(f"kind of representation {name!r}", "unknown", f"did you mean {_SETTINGS.near(name)}?")
    return kinds()[name]


def build(
    scene: Scene, captured: IndexArray, settings: RepresentationSettings, seed: int, device: str
) -> Representation:
    """Return an untrained representation of ``scene``, of the kind of ``settings``.

    Args:
        scene: what is to be reconstructed.
        captured: indices of the images captured so far, ``[n]``.
        settings: of the reconstruction.
        seed: of every random choice of the reconstruction.
        device: ``cpu`` or ``cuda``.

    Raises:
        UserError: the device is not there, or the scene does not fit the settings.
    """
    module, _, function = find(settings.kind).build.partition(":")
    make = cast(Builder, getattr(importlib.import_module(module), function))
    return make(scene, captured, settings, seed, device)


def compile_kernels(name: str) -> None:
    """Compile the CPU kernels of a kind, so that no episode's times include it.

    Raises:
        UserError: there is no such kind.
    """
    module, _, function = (find(name).compile or "").partition(":")
    if module:
        getattr(importlib.import_module(module), function)()


def create_settings(values: Mapping[str, Any]) -> RepresentationSettings:
    """Return settings, checked and completed by the defaults of their ``kind``.

    Raises:
        UserError: the kind or a setting is unknown, or a value does not fit.
    """
    try:
        return _SETTINGS.checked(values)
    except ValidationError as error:
        place, fault = first_fault(error, "representation")
        raise UserError(place, fault, "correct the value") from None


_SETTINGS = NamedSettings(
    base=RepresentationSettings,
    key="kind",
    default="gaussians",
    section="representation",
    what="kind of representation",
    kinds=lambda: {name: kind.settings for name, kind in kinds().items()},
)

AnyRepresentationSettings = Annotated[RepresentationSettings, _SETTINGS]
"""Settings of the kind that their field ``kind`` names; Gaussians where there is no such field."""

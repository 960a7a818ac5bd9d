"""Back ends, found by name: the modules of ``avs.sfm.back_ends`` that have a ``BACK_END``."""

from __future__ import annotations

import functools
import importlib
import importlib.metadata
import importlib.util
import pkgutil
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Annotated, Any, cast

from pydantic import ValidationError

from avs.scene.views import Views
from avs.sfm.point_maps import NetworkSettings
from avs.sfm.reconstruction import BackEnd, BackEndSettings, Reconstruct, Reconstruction, check_views
from avs.system.errors import UserError
from avs.system.models import first_fault
from avs.system.named_settings import NamedSettings
from avs.system.opened_files import expect_code_of_others
from avs.system.plugin_modules import import_each
from avs.system.reasons import Reason

PACKAGE = "avs.sfm.back_ends"
"""The package whose modules are searched."""


def back_ends() -> Mapping[str, BackEnd]:
    """Return every back end by name, in the order of names; none of their packages is imported.

    A module that does not work is left out, see ``broken``.
    """
    return _found()[0]


def broken() -> dict[str, str]:
    """Return why each module that should define a back end is left out: its fault must not stop the others."""
    return _found()[1]


@functools.cache
def _found() -> tuple[Mapping[str, BackEnd], dict[str, str]]:
    expect_code_of_others()
    package = importlib.import_module(PACKAGE)
    modules, faults = import_each(f"{PACKAGE}.{name}" for name in _names_in(package.__path__))
    defined = {name.rpartition(".")[2]: getattr(module, "BACK_END", None) for name, module in modules.items()}
    return MappingProxyType({name: value for name, value in defined.items() if isinstance(value, BackEnd)}), faults


def _names_in(path: Iterable[str]) -> list[str]:
    return sorted(module.name for module in pkgutil.iter_modules(path))


def find(name: str) -> BackEnd:
    """Return the back end called ``name``.

    Raises:
        UserError: there is none; the line lists near names.
    """
    if name not in back_ends():
        subject, fault = f"back end {name!r} of structure from motion", broken().get(f"{PACKAGE}.{name}")
        if fault is not None:
            raise UserError(subject, f"is left out: {fault}", f"mend {PACKAGE}.{name}")
        raise UserError(subject, "unknown", f"did you mean {_SETTINGS.near(name)}?")
    return back_ends()[name]


def why_not(settings: BackEndSettings) -> Reason | None:
    """Return what a back end lacks here and what helps, or None if it can run; nothing of its packages is imported.

    It lacks a package or has another version of it, or lacks the weights of its network.

    Args:
        settings: of the back end.
    """
    back_end = find(settings.back_end)
    for module, remedy in back_end.packages.items():
        if not _is_installed(module):
            return Reason(cause=f"{module} is not installed", remedy=remedy)
    for project, wanted in back_end.versions.items():
        version = _version(project)
        if version is not None and not version.startswith(wanted):
            cause = f"{project} is installed in version {version}, not {wanted.rstrip('.')}"
            return Reason(cause=cause, remedy=next(iter(back_end.packages.values())))
    return settings.lacks()


def reconstruct(views: Views, settings: BackEndSettings, subject: object, device: str = "cpu") -> Reconstruction:
    """Return the cloud of ``views`` by the back end of ``settings``; equal arguments give equal bytes.

    A subset of views that does not register is a result: its cloud is empty and ``left_out`` says why.

    Args:
        views: at least two, each name once.
        settings: of the back end.
        subject: what errors name, such as the episode that chose the views.
        device: ``cpu`` or ``cuda``, for networks.

    Raises:
        UserError: the views cannot be reconstructed by anything, or the back end is not installed here, or in a version
            that has other functions.
    """
    check_views(views, subject)
    lacking = why_not(settings)
    if lacking is not None:
        raise UserError(f"back end {settings.back_end}", lacking.cause, lacking.remedy or "install it")
    module, _, function = find(settings.back_end).reconstruct.partition(":")
    run = cast(Reconstruct, getattr(importlib.import_module(module), function))
    try:
        return run(views, settings, device)
    except (ImportError, AttributeError, TypeError) as error:
        if not isinstance(settings, NetworkSettings):
            raise
        # of their versions nothing tells but that functions are missing, or have other arguments
        fault = f"does not work with the version that is installed: {type(error).__name__}: {error}"
        remedy = "; ".join(find(settings.back_end).packages.values())
        raise UserError(f"back end {settings.back_end}", fault, f"{remedy} anew, or see the log") from error


def create_settings(values: Mapping[str, Any]) -> BackEndSettings:
    """Return settings, checked and completed by the defaults of their ``back_end``.

    Raises:
        UserError: the back end or a setting is unknown, or a value does not fit.
    """
    try:
        return _SETTINGS.checked(values)
    except ValidationError as error:
        place, fault = first_fault(error, "sfm")
        raise UserError(f"configuration: {place}", fault, "correct the value") from None


def _version(project: str) -> str | None:
    try:
        return importlib.metadata.version(project)
    except importlib.metadata.PackageNotFoundError:  # imported from a folder
        return None


def _is_installed(module: str) -> bool:
    try:
        return importlib.util.find_spec(module) is not None
    except (ImportError, ValueError):  # a parent package is missing or broken
        return False


_SETTINGS = NamedSettings(
    base=BackEndSettings,
    key="back_end",
    default="dense",
    section="sfm",
    what="back end",
    kinds=lambda: {name: back_end.settings for name, back_end in back_ends().items()},
)

AnyBackEndSettings = Annotated[BackEndSettings, _SETTINGS]
"""Settings of the back end that their field ``back_end`` names; dense stereo where there is no such field."""

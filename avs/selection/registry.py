"""Selection methods, found by name: modules of ``avs.selectors`` with a ``METHODS`` dictionary, and plug-ins."""

from __future__ import annotations

import difflib
import functools
import importlib
import importlib.metadata
import pkgutil
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_args

from pydantic import ValidationError

from avs.representations import kinds
from avs.representations.capabilities import CAPABILITIES
from avs.selection.contract import Direction, Method, Settings
from avs.system.errors import UserError
from avs.system.models import first_fault
from avs.system.opened_files import expect_code_of_others
from avs.system.plugin_modules import import_each
from avs.system.reasons import Reason

PACKAGE = "avs.selectors"
"""The package whose modules are searched, and the group of entry points that plug-ins use."""


@dataclass(frozen=True)
class Registered:
    """A method with the module that defines it."""

    method: Method
    module: str


def methods() -> dict[str, Registered]:
    """Return every method by identifier: those of ``avs.selectors``, then installed plug-ins, by module.

    A plug-in is an entry point of the group ``avs.selectors`` that names a module with a ``METHODS`` dictionary. A
    module that does not work is left out, see ``broken``.
    """
    return _found()[0]


def broken() -> dict[str, str]:
    """Return why each module that should define methods is left out: a fault of its own must not stop the others.

    It cannot be imported, its ``METHODS`` is no dictionary of methods, an identifier is another module's or cannot name
    a folder of results, or the metadata of a method name a direction or a capability that does not exist.
    """
    return _found()[1]


@functools.cache
def _found() -> tuple[dict[str, Registered], dict[str, str]]:
    expect_code_of_others()
    package = importlib.import_module(PACKAGE)
    own = sorted(f"{PACKAGE}.{module.name}" for module in pkgutil.iter_modules(package.__path__))
    plugins = sorted(point.value for point in importlib.metadata.entry_points(group=PACKAGE))
    modules, faults = import_each(dict.fromkeys(own + plugins))
    found: dict[str, Registered] = {}
    for name, module in modules.items():
        try:
            found |= _methods_of(name, getattr(module, "METHODS", {}), found)
        except UserError as error:
            faults[name] = str(error)
    return found, faults


def _methods_of(module: str, defined: object, found: Mapping[str, Registered]) -> dict[str, Registered]:
    """Return the methods that a module defines, once each is found to be one that a run could use."""
    if not isinstance(defined, Mapping):
        raise UserError(module, f"METHODS is {type(defined).__name__}", "make it a dictionary of methods by identifier")
    for identifier, method in defined.items():
        if not isinstance(method, Method):
            fault = f"METHODS[{identifier!r}] is {type(method).__name__}"
            raise UserError(module, fault, "make it a Method, see docs/add-a-baseline.md")
        if identifier in found:
            fault = f"defined by {found[identifier].module} and by {module}"
            raise UserError(f"method {identifier!r}", fault, "rename one of the two methods")
        check_identifier(identifier, module)
        _check_metadata(identifier, method, module)
    return {identifier: Registered(method, module) for identifier, method in defined.items()}


def check_identifier(identifier: str, source: str) -> None:
    """Refuse an identifier that the workflow could not match with a folder of results, and would pass over in silence.

    Args:
        identifier: of the method.
        source: the module or file that defines it.

    Raises:
        UserError: it holds other characters than lower-case letters, digits and hyphens.
    """
    if not isinstance(identifier, str) or not re.fullmatch("[a-z0-9-]+", identifier):
        raise UserError(
            f"method {identifier!r} of {source}",
            "an identifier has only lower-case letters, digits and hyphens",
            "rename the method",
        )


def _check_metadata(identifier: str, method: Method, module: str) -> None:
    """Refuse a direction or a capability that does not exist."""
    named = f"method {identifier!r} of {module}"
    if method.chooses not in get_args(Direction):
        raise UserError(named, f"chooses {method.chooses!r}", f"choose {' or '.join(get_args(Direction))}")
    for name in method.needs:
        if name not in CAPABILITIES:
            near = difflib.get_close_matches(name, CAPABILITIES, n=1) or sorted(CAPABILITIES)
            raise UserError(named, f"needs {name!r}, which is no capability", f"did you mean {', '.join(near)}?")


def find(identifier: str) -> Registered:
    """Return the method called ``identifier``.

    Raises:
        UserError: there is none; the line lists near names.
    """
    known = methods()
    if identifier not in known:
        near = difflib.get_close_matches(identifier, known, n=3) or difflib.get_close_matches(
            identifier, known, n=1, cutoff=0
        )
        faults = "".join(f", or mend {module}, which is left out ({fault})" for module, fault in broken().items())
        raise UserError(f"method {identifier!r}", "unknown", f"did you mean {', '.join(near)}?{faults}")
    return known[identifier]


def create_settings(identifier: str, values: dict[str, Any]) -> Settings:
    """Return the settings of a method, checked and completed by its defaults.

    Raises:
        UserError: the method or a setting is unknown, or a value does not fit.
    """
    kind = find(identifier).method.settings
    try:
        return kind.model_validate(values)
    except ValidationError as error:
        place, fault = first_fault(error, "selectors", identifier)
        near = difflib.get_close_matches(place.rpartition(".")[2], kind.model_fields, n=1)
        guess = f"did you mean {near[0]}? " if near and error.errors()[0]["type"] == "extra_forbidden" else ""
        known = ", ".join(kind.model_fields) or "none"
        raise UserError(f"configuration: {place}", fault, f"{guess}settings of this method: {known}") from None


def needed(identifier: str, settings: Settings) -> tuple[str, ...]:
    """Return the capabilities that a method needs with these settings."""
    return find(identifier).method.needs if settings.needs is None else settings.needs


def why_not(identifier: str, settings: Settings, kind: str) -> Reason | None:
    """Return why a method cannot run on representations of a kind, and on which it can, or None.

    Args:
        identifier: of the method.
        settings: of the method.
        kind: name of the kind of representation.

    Raises:
        UserError: the method or the kind is unknown.
    """
    needs = needed(identifier, settings)
    lacking = [name for name in needs if name not in kinds.find(kind).offers]
    if not lacking:
        return None
    others = [name for name, other in kinds.kinds().items() if other.offers.issuperset(needs)]
    remedy = f"choose representation.kind {' or '.join(others)}" if others else None
    return Reason(cause=f"representation {kind} lacks {', '.join(lacking)}", remedy=remedy)

"""Readers of data sets, found by name: the modules of ``avs.datasets`` with a ``READER``."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from typing import get_args

from avs.datasets.reader import Reader
from avs.system.plugin_modules import import_each

PACKAGE = "avs.datasets"
"""The package whose modules are searched."""


def readers() -> dict[str, type[Reader]]:
    """Return every reader by the name that its field ``source`` takes, in ascending order of the modules.

    A module that does not work is left out, see ``broken``.
    """
    return _found()[0]


def broken() -> dict[str, str]:
    """Return why each module that should define a reader is left out: it cannot be imported, or its name is taken."""
    return _found()[1]


@functools.cache
def _found() -> tuple[dict[str, type[Reader]], dict[str, str]]:
    package = importlib.import_module(PACKAGE)
    modules, faults = import_each(sorted(f"{PACKAGE}.{entry.name}" for entry in pkgutil.iter_modules(package.__path__)))
    found: dict[str, type[Reader]] = {}
    for module, content in modules.items():
        reader = getattr(content, "READER", None)
        if reader is None:
            continue
        (name,) = get_args(reader.model_fields["source"].annotation)
        if name in found:
            faults[module] = f"reads data sets of source {name}, as {found[name].__module__} does"
        else:
            found[name] = reader
    return found, faults

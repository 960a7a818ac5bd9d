"""Readers of data sets, found by name: the modules of ``avs.datasets`` with a ``READER``."""

from __future__ import annotations

import functools
import importlib
import pkgutil
from typing import get_args

from avs.datasets.reader import Reader

PACKAGE = "avs.datasets"
"""The package whose modules are searched."""


@functools.cache
def readers() -> dict[str, type[Reader]]:
    """Return every reader by the name that its field ``source`` takes, in ascending order of the modules.

    Raises:
        ValueError: two modules define readers of one name.
    """
    package = importlib.import_module(PACKAGE)
    found: dict[str, type[Reader]] = {}
    for module in sorted(f"{PACKAGE}.{entry.name}" for entry in pkgutil.iter_modules(package.__path__)):
        reader = getattr(importlib.import_module(module), "READER", None)
        if reader is None:
            continue
        (name,) = get_args(reader.model_fields["source"].annotation)
        if name in found:
            raise ValueError(f"{found[name].__module__} and {module} both read data sets of source {name}")
        found[name] = reader
    return found

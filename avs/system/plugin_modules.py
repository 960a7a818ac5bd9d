"""Imports modules that are found by name, of which one that does not work must not take the others with it."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable
from types import ModuleType

from avs.system.faults import Terminated, ending
from avs.system.global_state import kept


def import_each(names: Iterable[str]) -> tuple[dict[str, ModuleType], dict[str, str]]:
    """Import modules, and return those that work, by name, and why each of the others does not.

    A module that raises, ends the program, is misspelt or has a fault of syntax is one that does not work. So is one
    that changes settings of torch, because all modules are imported in every job.
    """
    working, broken = {}, {}
    for name in names:
        try:
            with kept() as changed:
                module = importlib.import_module(name)
        except (KeyboardInterrupt, MemoryError, Terminated):
            raise  # of the process, not of the module
        except BaseException as error:
            broken[name] = ending(error).line.partition(";")[0]
        else:
            if changed:
                sys.modules.pop(name, None)  # whoever else imports it is told the same
                broken[name] = f"{name}: changes settings of torch when it is imported: {', '.join(changed)}"
            else:
                working[name] = module
    return working, broken

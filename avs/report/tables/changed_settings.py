"""Which settings of a method are not its defaults: a row has a method's name, whatever its settings."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pydantic import TypeAdapter

from avs.selection import registry
from avs.slam.scoring.path_settings import PathScorerSettings
from avs.system.errors import UserError

_CHOOSER: TypeAdapter[PathScorerSettings] = TypeAdapter(PathScorerSettings)
_NAMES = ("kind", "method", "settings")
"""What says which method chooses paths, and the settings of that method itself."""


def changed_settings(method: str, settings: Mapping[str, object]) -> str:
    """Return the settings of a method that are not its defaults, such as ``resize.pixels 176 instead of 518``, or "".

    Those of a program, and of a method some of whose settings have no default, are not known.

    Args:
        method: identifier.
        settings: of an episode or of scores, as their record has them.
    """
    if method not in registry.methods() or not settings:
        return ""
    try:
        return _told(settings, registry.create_settings(method, {}).model_dump(mode="json"))
    except UserError:
        return ""


def changed_chooser(settings: Mapping[str, object]) -> str:
    """Return the settings of what chooses the paths of an exploration that are not its defaults, or "".

    Args:
        settings: ``settings.scorer`` of an exploration's record.
    """
    method, own = settings.get("method"), settings.get("settings")
    named = {key: settings[key] for key in ("kind", "method") if key in settings}
    usual = _CHOOSER.validate_python(named).model_dump(mode="json")
    parts = [_told(settings, usual, _NAMES)]
    if isinstance(method, str) and isinstance(own, Mapping):
        parts.append(changed_settings(method, own))
    return ", ".join(filter(None, parts))


def _told(own: Mapping[str, object], usual: Mapping[str, object], left_out: Collection[str] = ()) -> str:
    defaults, found = _flat(usual), _flat(own)
    changed = {key: value for key, value in found.items() if value != defaults.get(key, value) and key not in left_out}
    return ", ".join(f"{key} {value} instead of {defaults[key]}" for key, value in changed.items())


def _flat(settings: Mapping[str, object], beginning: str = "") -> dict[str, object]:
    found: dict[str, object] = {}
    for key, value in settings.items():
        if isinstance(value, Mapping):
            found |= _flat(value, f"{beginning}{key}.")
        else:
            found[f"{beginning}{key}"] = value
    return found

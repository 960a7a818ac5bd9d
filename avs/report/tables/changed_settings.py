"""Which settings of a method are not its defaults: a row has a method's name, whatever its settings."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pydantic import TypeAdapter

from avs.selection import registry
from avs.slam.scoring.path_settings import PathScorerSettings
from avs.system.errors import UserError
from avs.system.models import flat

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
        return differences(settings, registry.create_settings(method, {}).model_dump(mode="json"))
    except UserError:
        return ""


def differences(own: Mapping[str, object], usual: Mapping[str, object], left_out: Collection[str] = ()) -> str:
    """Return where settings differ from others, such as ``budget 6 instead of 8, iterations 100 instead of 150``.

    Args:
        own: settings, with sections in them.
        usual: the others.
        left_out: keys that do not count.
    """
    defaults, found = flat(usual), flat(own)
    known = ((key, value, _default(defaults, key, value)) for key, value in found.items() if key not in left_out)
    return ", ".join(f"{key} {value} instead of {default}" for key, value, default in known if value != default)


def changed_chooser(settings: Mapping[str, object]) -> str:
    """Return the settings of what chooses the paths of an exploration that are not its defaults, or "".

    Args:
        settings: ``settings.scorer`` of an exploration's record.
    """
    method, own = settings.get("method"), settings.get("settings")
    named = {key: settings[key] for key in ("kind", "method") if key in settings}
    usual = _CHOOSER.validate_python(named).model_dump(mode="json")
    parts = [differences(settings, usual, _NAMES)]
    if isinstance(method, str) and isinstance(own, Mapping):
        parts.append(changed_settings(method, own))
    return ", ".join(filter(None, parts))


def _default(defaults: Mapping[str, object], key: str, value: object) -> object:
    """Return the default of a setting: of one in a section that is left out by default, that; ``value`` if unknown."""
    if key in defaults:
        return defaults[key]
    within = [f"{name.removeprefix(f'{key}.')} {each}" for name, each in defaults.items() if name.startswith(f"{key}.")]
    if within:  # a section by default, and left out here
        return ", ".join(within)
    parts = key.split(".")
    sections = (".".join(parts[:count]) for count in range(1, len(parts)))
    return next((defaults[section] for section in sections if section in defaults), value)

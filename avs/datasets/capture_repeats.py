"""One photograph under several names: a test photograph that is also a candidate would be learned by heart."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from avs.scene.colmap import Model


def repeated(hashes: Mapping[str, str]) -> dict[str, str]:
    """Return the images whose pixels are those of an earlier one, by name, with the name of that one.

    Args:
        hashes: of the pixels of each image, by name.
    """
    first: dict[str, str] = {}
    originals = {name: first.setdefault(hashes[name], name) for name in sorted(hashes)}
    return {name: original for name, original in originals.items() if name != original}


def without(model: Model, names: Collection[str]) -> Model:
    """Return the model without the images of these names."""
    kept = {number: image for number, image in model.images.items() if image.name not in names}
    return replace(model, images=kept)


def repeat_notes(repeats: Mapping[str, str]) -> list[str]:
    """Return the note on images that ``repeated`` named, if there are any."""
    told = ", ".join(f"{name} ({original})" for name, original in repeats.items())
    return [f"left out, since they are other images once more: {told}"] if repeats else []

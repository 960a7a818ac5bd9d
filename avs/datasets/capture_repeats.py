"""One photograph under several names: a test photograph that is also a candidate would be learned by heart."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

from avs.scene.colmap import Model
from avs.scene.colmap.conversion import sorted_images
from avs.system.files import file_hash


def without_repeats(source: Path, model: Model) -> tuple[Model, list[str]]:
    """Return the model without images whose file holds the bytes of an earlier one's, by name, and a note on them.

    Args:
        source: the capture's folder.
        model: its model; images whose file is not there stay.
    """
    paths = {image.name: source / "images" / image.name for image in sorted_images(model) if "\0" not in image.name}
    sizes = {name: path.stat().st_size for name, path in paths.items() if path.is_file()}
    counts = Counter(sizes.values())
    first: dict[str, str] = {}
    repeated: dict[str, str] = {}
    for name in (name for name, size in sizes.items() if counts[size] > 1):
        original = first.setdefault(file_hash(paths[name]), name)
        if original != name and paths[original].resolve() != paths[name].resolve():
            repeated[name] = original
    if not repeated:
        return model, []
    kept = {number: image for number, image in model.images.items() if image.name not in repeated}
    told = ", ".join(f"{name} ({original})" for name, original in repeated.items())
    return replace(model, images=kept), [f"left out, since they are other images once more: {told}"]

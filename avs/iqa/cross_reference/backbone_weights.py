"""Where the pretrained weights of the cross-reference network's image encoder are found. Nothing here imports torch."""

from __future__ import annotations

from pathlib import Path

from avs.iqa.cross_reference.scorer_settings import ScorerSettings
from avs.system.reasons import Reason
from avs.system.weights import locate, missing, verified
from avs.system.weights.cache import folder
from avs.system.weights.manifest import MANIFEST

_TAGS = {"repvit_m0_9": "dist_450e_in1k", "vit_small_patch14_dinov2": "lvd142m"}

_BY_PIP = {"tf_efficientnet_lite0": "efficientnet-lite0"}
"""Backbones whose weights come in a package, by their names in the manifest."""


def locate_weights(backbone: str, tag: str | None = None) -> Path | None:
    """Return the local file of a backbone's pretrained weights, unread, or None; never uses the network.

    It looks in the cache folder of ``avs.system.weights``, then in that of huggingface_hub, where timm keeps them.

    Args:
        backbone: timm's name of the model.
        tag: which of timm's weights; None for the usual ones: ImageNet's for RepViT, DINOv2's own for DINOv2.
    """
    if backbone in _BY_PIP:
        return locate(_BY_PIP[backbone])
    name = _entry(backbone, tag)
    path = _path(backbone, tag)
    found = None if name is None else locate(name)
    if found is not None or path.is_file():
        return found or path
    from huggingface_hub import try_to_load_from_cache

    cached = try_to_load_from_cache(f"timm/{path.stem}", "model.safetensors")
    return Path(cached) if isinstance(cached, str) else None


def initial_weights(settings: ScorerSettings) -> Path | None:
    """Return the local file that the training of a scorer begins with, unread, or None for random weights."""
    training = settings.training
    if training.backbone_weights == "scratch":
        return None
    return locate_weights(settings.network.backbone, training.backbone_tag)


def find_weights(backbone: str, tag: str | None = None) -> Path | None:
    """Return the same file after comparing it with the manifest, if that describes it.

    Raises:
        UserError: the file is not the one that the manifest describes.
    """
    name = _entry(backbone, tag)
    return locate_weights(backbone, tag) if name is None or locate(name) is None else verified(name)


def absent_weights(settings: ScorerSettings) -> Reason | None:
    """Return which weights of its backbone a scorer asks for that are not on this machine, or None."""
    training = settings.training
    if training.backbone_weights != "pretrained" or initial_weights(settings) is not None:
        return None
    name = _entry(settings.network.backbone, training.backbone_tag)
    if name is not None:
        return missing([name])
    path = _path(settings.network.backbone, training.backbone_tag)
    return Reason(cause=f"weights {path.name} absent", remedy=f"put timm's file at {path}")


def _path(backbone: str, tag: str | None) -> Path:
    return folder() / "timm" / f"{backbone}.{tag or _TAGS[backbone]}.safetensors"


def _entry(backbone: str, tag: str | None) -> str | None:
    """Return the name of these weights in the manifest, or None."""
    if backbone in _BY_PIP:
        return _BY_PIP[backbone]
    path = _path(backbone, tag)
    return next((name for name, entry in MANIFEST.items() if folder() / entry.path == path), None)

"""Reading of CrossScore's published checkpoint (github.com/ActiveVisionLab/CrossScore), saved by Lightning.

It is a zip file around a pickle. Nothing in it is executed: torch's reader of weights runs on it, which builds tensors
and plain containers alone.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from avs.iqa.cross_reference.network import CrossReferenceNetwork, build_network
from avs.iqa.cross_reference.scorer_settings import DINOv2Settings
from avs.system.errors import UserError

_REMEDY = "fetch the published checkpoint again"

# Where Lightning keeps hyper-parameters as they were given; they are passed over, whatever their type.
_PASSED_OVER = ("omegaconf.", "lightning.", "pytorch_lightning.", "lightning_fabric.", "typing.", "pathlib.")
_PLAIN: dict[str, Callable[..., Any]] = {
    **{f"builtins.{kind.__name__}": kind for kind in (dict, list, int, float, str, bool)},
    "collections.defaultdict": lambda *_: {},  # torch fills plain dictionaries only
}

_NAMES = (
    ("backbone.embeddings.patch_embeddings.projection.", "backbone.patches."),
    ("backbone.embeddings.cls_token", "backbone.class_token"),
    ("backbone.embeddings.position_embeddings", "backbone.positions"),
    ("backbone.encoder.layer.", "backbone.blocks."),
    ("backbone.layernorm.", "backbone.norm."),
    (".attention.output.dense.", ".attn.proj."),
    (".layer_scale1.lambda1", ".ls1.gamma"),
    (".layer_scale2.lambda1", ".ls2.gamma"),
    ("ref_cross.attn.layers.", "decoder."),
    (".self_attn.", ".self_attention."),
    (".multihead_attn.", ".cross_attention."),
    (".linear1.", ".feed_forward.0."),
    (".linear2.", ".feed_forward.2."),
    ("ref_cross.head.", "head."),
)
_DECODER_NORMS = tuple((f".norm{i + 1}.", f".norms.{i}.") for i in range(3))
_UNUSED = ("img_mean_std", "backbone.embeddings.mask_token")


def is_archive(path: Path) -> bool:
    """Whether a file begins as a zip archive does, which is how torch and Lightning save."""
    with path.open("rb") as stream:
        return stream.read(4) == b"PK\x03\x04"


def read_crossscore(path: Path) -> CrossReferenceNetwork:
    """Return the network of a checkpoint with CrossScore's names of parameters, in evaluation mode.

    Raises:
        UserError: the file is truncated, holds objects other than weights, or weights of another architecture.
    """
    published = {
        key.removeprefix("model."): value
        for key, value in _tensors(path).items()
        if key.startswith("model.") and key.removeprefix("model.") not in _UNUSED
    }
    try:
        state = _renamed(published)
        settings = DINOv2Settings(position_size=state["positions.codes"].shape[-1])
    except KeyError as error:
        raise UserError(path, f"not a checkpoint of CrossScore (it lacks {error})", _REMEDY) from error
    except RuntimeError as error:
        raise UserError(path, "not CrossScore's architecture (a parameter has other dimensions)", _REMEDY) from error
    network = build_network(settings, seed=0).eval()
    try:
        network.load_state_dict(state)
    except RuntimeError as error:
        first = "".join(line.strip() for line in str(error).splitlines()[1:2])
        raise UserError(path, f"not CrossScore's architecture ({first[:120]})", _REMEDY) from error
    return network


class _PassedOver:
    """Stands where a checkpoint names a class that is not needed; takes any arguments and any state, keeps none."""

    def __new__(cls, *_: object) -> _PassedOver:
        """Return an empty object."""
        return super().__new__(cls)

    def __setstate__(self, state: object) -> None:
        pass


def _tensors(path: Path) -> dict[str, Tensor]:
    """Return ``state_dict`` of a Lightning checkpoint."""
    try:
        foreign = torch.serialization.get_unsafe_globals_in_checkpoint(path)
        refused = [name for name in foreign if not name.startswith(_PASSED_OVER) and name not in _PLAIN]
        with torch.serialization.safe_globals([(_PLAIN.get(name, _PassedOver), name) for name in foreign]):
            content = None if refused else torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # torch raises many types for a damaged file
        first = str(error).split("\n", maxsplit=1)[0][:120] or type(error).__name__
        raise UserError(path, f"not a readable checkpoint ({first})", _REMEDY) from error
    if refused:
        fault = f"holds an object that is not a weight ({refused[0]}), which could run code"
        raise UserError(path, fault, _REMEDY)
    state = content.get("state_dict") if isinstance(content, dict) else None
    if not isinstance(state, dict) or not all(isinstance(value, Tensor) for value in state.values()):
        raise UserError(path, "not a checkpoint of Lightning (it has no state_dict)", _REMEDY)
    return state


def _renamed(published: dict[str, Tensor]) -> dict[str, Tensor]:
    """Return CrossScore's parameters under the names of ``CrossReferenceNetwork``.

    Queries, keys and values of the backbone become one matrix. The position codes ``[1, rows, columns, channels]``
    become ``[1, channels, rows, columns]``.
    """
    state: dict[str, Tensor] = {}
    for key, value in published.items():
        if key == "pos_enc_fn.PE":
            state["positions.codes"] = value.permute(0, 3, 1, 2).contiguous()
        elif ".attention.attention." not in key:
            state[_renamed_key(key)] = value
        elif ".attention.attention.query." in key:
            parts = [published[key.replace("query", part)] for part in ("query", "key", "value")]
            state[_renamed_key(key.replace("attention.attention.query", "attn.qkv"))] = torch.cat(parts)
    return state


def _renamed_key(key: str) -> str:
    names = _NAMES if key.startswith("backbone.") else (*_NAMES, *_DECODER_NORMS)
    for old, new in names:
        key = key.replace(old, new)
    return key

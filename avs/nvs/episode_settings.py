"""What an episode reads of the configuration. Imports no torch, so that the workflow can read it quickly."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from avs.nvs.picture_settings import PictureSettings
from avs.nvs.protocol import ProtocolSettings
from avs.representations.kinds import AnyRepresentationSettings
from avs.system.models import StrictModel


class EpisodeSettings(StrictModel):
    """What an episode reads of the configuration."""

    method: str = Field(description="identifier of the selection method")
    device: Literal["cpu", "cuda"] = Field(description="where the reconstruction and networks run")
    protocol: ProtocolSettings = Field(description="the loop")
    own: tuple[str, ...] = Field(
        default=(), description="settings of the loop that the method has for itself: the run's are others"
    )
    representation: AnyRepresentationSettings = Field(description="the reconstruction")
    selector: dict[str, Any] = Field(description="settings of the method")
    pictures: PictureSettings | None = Field(default=None, description="pictures to keep, or null for none")

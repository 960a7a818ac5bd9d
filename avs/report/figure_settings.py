"""What the configuration tells the figures."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, PositiveInt

from avs.system.models import Different, StrictModel

REFERENCE, PROPOSED, BEST = "reference", "proposed", "best"
"""Words that stand for methods; which they are, a rule says that looks at no picture."""

ROLES = (REFERENCE, PROPOSED, BEST)


class FigureSettings(StrictModel):
    """What the figures show."""

    methods: Annotated[tuple[str, ...], Different] = Field(
        default=("random", REFERENCE, "fisherrf", PROPOSED, BEST),
        min_length=1,
        description="columns of figures of pictures: identifiers of methods, reference for the one that the tables "
        "compare with, proposed for those that the paper proposes, best for the ranked one with the highest mean test "
        "PSNR of the data set; each is shown once, and one without episodes is left out",
    )
    rows: PositiveInt = Field(
        default=4, description="rows of the figure qualitative, each a scene: the first of each data set, then others"
    )
    egocentric: Annotated[tuple[str, ...], Different] = Field(
        default=("egocentric", "aria_dtc"),
        description="data sets of egocentric photographs; the first that the run evaluates is set beside one of phone",
    )
    phone: Annotated[tuple[str, ...], Different] = Field(
        default=("handheld", "mapfree"), description="data sets of photographs by phones, of which the first counts"
    )
    moments: PositiveInt = Field(default=5, description="columns of the figure score_maps, spread over an episode")

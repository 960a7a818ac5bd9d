"""What the cross-reference network is trained to lower: the error of its maps, and of the order within a set."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from avs.iqa.cross_reference.network import CrossReferenceNetwork
from avs.iqa.cross_reference.training_batches import Batch


def predicted_maps(network: CrossReferenceNetwork, batch: Batch) -> Tensor:
    """Return the predicted SSIM maps of a batch's queries, ``[s, q, crop, crop]``.

    The batch holds pixels, or features of the network's backbone.
    """
    sets, per_set = batch.queries.shape[:2]
    present = batch.present.flatten(0, 1)
    images = torch.cat([batch.queries.flatten(0, 1), batch.references.flatten(0, 2)])
    tokens = network.tokens(images) if batch.encoded else network.encode(images)
    queries, references = tokens[: sets * per_set], tokens[sets * per_set :]
    memory = network.memory(references.reshape(len(present), -1, references.shape[-1]))
    absent = None
    if not bool(present.all()):
        absent = (~present).repeat_interleave(memory.shape[1] // present.shape[1], dim=1)
    return network.predict(queries, memory, absent).view_as(batch.maps)


def map_loss(predicted: Tensor, true: Tensor) -> Tensor:
    """Return the mean absolute error of the predicted SSIM maps, CrossScore's training loss."""
    return functional.l1_loss(predicted, true)


def centered_loss(predicted: Tensor, true: Tensor) -> Tensor:
    """Return the mean absolute error of scores less the mean of their set.

    The queries of a set are renderings of one moment. What it adds to the loss of maps is the order among them, which a
    choice depends on; nine tenths of the variance of scores lie between moments.

    Args:
        predicted: maps ``[s, q, crop, crop]``.
        true: likewise.
    """
    scores, truth = predicted.mean(dim=(2, 3)), true.mean(dim=(2, 3))
    return functional.l1_loss(scores - scores.mean(dim=1, keepdim=True), truth - truth.mean(dim=1, keepdim=True))

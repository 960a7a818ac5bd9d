"""Several processes that share each step of a training: torch.distributed, with gloo on CPUs and NCCL on GPUs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, distributed

from avs.iqa.cross_reference.training_batches import Batch
from avs.system.compatibility import prepare_torch
from avs.system.devices import VARIABLE, take_device
from avs.system.errors import UserError
from avs.system.files import temporary_folder
from avs.system.parent_process import die_with_parent


@dataclass(frozen=True)
class Group:
    """This process among those of a training. All draw the same batches; each computes its part of the sets.

    Attributes:
        rank: from 0; the first process alone reports, and writes.
        count: number of processes.
        sets: number of sets in a batch.
    """

    rank: int = 0
    count: int = 1
    sets: int = 1

    @property
    def weight(self) -> float:
        """The share of this process in the mean over a batch."""
        return len(range(self.rank, self.sets, self.count)) / self.sets

    def share(self, batch: Batch) -> Batch:
        """Return the sets of a batch that this process computes."""
        if self.count == 1:
            return batch
        own = slice(self.rank, None, self.count)
        return Batch(batch.queries[own], batch.maps[own], batch.references[own], batch.present[own])

    def add_gradients(self, parameters: Sequence[Tensor]) -> None:
        """Replace the gradients by their sums over the processes."""
        if self.count == 1:
            return
        gradients = [parameter.grad for parameter in parameters if parameter.grad is not None]
        joined = torch.cat([gradient.flatten() for gradient in gradients])
        distributed.all_reduce(joined)
        sizes = [gradient.numel() for gradient in gradients]
        for gradient, part in zip(gradients, torch.split(joined, sizes), strict=True):
            gradient.copy_(part.view_as(gradient))

    def added(self, value: float) -> float:
        """Return the sum of ``value`` over the processes."""
        if self.count == 1:
            return value
        values: list[float | None] = [None] * self.count
        distributed.all_gather_object(values, value)
        return sum(each for each in values if each is not None)


ALONE = Group()


@contextmanager
def group_of(count: int, sets: int, device: str, help_with: Callable[..., None], *told: object) -> Iterator[Group]:
    """Start ``count - 1`` more processes for the time of the context, and yield this one's place among all.

    Args:
        count: number of processes, this one included.
        sets: number of sets in a batch.
        device: ``cpu`` or ``cuda``; on several GPUs each process takes one.
        help_with: what another process does, given its group and ``told``; a function of a module.
        told: its arguments, which must survive being pickled.

    Raises:
        UserError: there are fewer sets or devices than processes, or one of them ended before its time.
    """
    if count == 1:
        yield Group(sets=sets)
        return
    _check(count, sets, device)
    context = get_context("spawn")
    with temporary_folder("avs-training-") as folder:
        place = folder / "meeting"
        others = [
            context.Process(target=_help, args=(Group(rank, count, sets), place, device, help_with, told), daemon=True)
            for rank in range(1, count)
        ]
        for process in others:
            process.start()
        try:
            _join(Group(0, count, sets), place, device)
            yield Group(0, count, sets)
        except RuntimeError as error:  # what torch.distributed raises when a process is gone
            if all(process.exitcode in (None, 0) for process in others):
                raise
            fault = f"one of {count} processes ended before its time ({str(error).splitlines()[0]})"
            raise UserError(
                "training", fault, "see above why; lower training.processes where memory is short"
            ) from error
        finally:
            for process in others:
                process.join(timeout=10)
                process.kill()
            if distributed.is_initialized():
                distributed.destroy_process_group()


def _check(count: int, sets: int, device: str) -> None:
    if sets < count:
        fault = f"{count}, and a batch has {sets} sets of queries to share"
        raise UserError("training.processes", fault, "lower it, or raise training.batch")
    listed = os.environ.get(VARIABLE)
    devices = torch.cuda.device_count() if listed is None else len(listed.split(","))
    if device == "cuda" and devices < count:
        raise UserError("training.processes", f"{count}, and there are {devices} GPUs", "lower it to as many")


def _join(group: Group, place: Path, device: str) -> None:
    if device == "cuda" and VARIABLE not in os.environ:
        torch.cuda.set_device(group.rank)
    backend = "nccl" if device == "cuda" else "gloo"
    distributed.init_process_group(backend, f"file://{place}", rank=group.rank, world_size=group.count)


def _help(group: Group, place: Path, device: str, help_with: Callable[..., None], told: tuple[Any, ...]) -> None:
    die_with_parent()
    prepare_torch()
    take_device(device)
    _join(group, place, device)
    help_with(group, *told)
    distributed.destroy_process_group()

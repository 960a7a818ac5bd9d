"""What differs from run to run: the clock, memory, the machine and the versions of the code."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import resource
import subprocess
import time
from datetime import UTC, datetime
from pathlib import Path

from avs.system.numerics import in_force

PACKAGES = ("numpy", "torch", "numba", "gsplat", "timm", "pyiqa", "lpips", "open3d-cpu", "pycolmap")


def clock(device: str) -> float:
    """Return seconds of a monotonic clock, after the work queued on ``device`` has ended."""
    if device == "cuda":
        import torch

        torch.cuda.synchronize()
    return time.perf_counter()


def peak_memory(device: str) -> int:
    """Return bytes: the process's peak resident memory, or on CUDA the allocator's peak."""
    if device == "cuda":
        import torch

        return int(torch.cuda.max_memory_allocated())
    # Linux counts ru_maxrss in kibibytes.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def reset_peak_memory(device: str) -> None:
    """Let ``peak_memory`` count from here on, on CUDA; the peak of a process cannot be set back everywhere."""
    if device == "cuda":
        import torch

        torch.cuda.reset_peak_memory_stats()


def machine(device: str) -> dict[str, str]:
    """Describe the class of machine: processor, number of cores, operating system, and the GPU if it is used.

    What ``avs.system.numerics`` made of the processor is there too.
    """
    facts = {
        "processor": _processor(),
        "cores": str(len(os.sched_getaffinity(0))),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "numerics": in_force(),
    }
    if device == "cuda":
        import torch

        facts["gpu"] = torch.cuda.get_device_name()
    return facts


def packages() -> dict[str, str]:
    """Return the versions of the installed packages that take part in a computation."""
    versions = {}
    for name in PACKAGES:
        try:
            versions[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            continue
    return versions


def revision() -> str | None:
    """Return the git revision of this code, with ``+`` where the tree has changes, or None outside a checkout."""
    command = [
        "git",
        "-C",
        str(Path(__file__).parents[1]),
        "describe",
        "--always",
        "--abbrev=40",
        "--dirty=+",
        "--exclude=*",
    ]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=10).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None


def now() -> str:
    """Return the time in UTC, ISO 8601, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = (line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    return next(names, platform.processor())

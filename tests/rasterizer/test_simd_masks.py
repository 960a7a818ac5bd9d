"""Masks as AVX2 has them and as LLVM has them: the same truth values, of numbers that are none, too."""

import json
import subprocess
import sys

import pytest

from avs.system import numerics

PROGRAM = """
import json, sys
import numpy as np
from avs.rasterizer import simd_masks
from avs.rasterizer.kernels import kernel
from avs.rasterizer.simd import any_of, bits_of, where
from avs.rasterizer.simd_memory import load, store

@kernel
def compared(a, b, chosen, found):
    x, y = load(a, 0), load(b, 0)
    masks = (x < y, x <= y, x > y, x >= y, (x < y) & (y < 1.0), (x <= y) & (x >= y))
    for k in range(len(masks)):
        found[2 * k] = bits_of(masks[k])
        found[2 * k + 1] = any_of(masks[k])
    store(chosen, 0, where(x < y, x, y))
    store(chosen, 16, where((x >= y) & (x > 0.0), 1.0, y))

numbers = np.array([0, -0.0, 1, -1, np.nan, np.inf, -np.inf, 1e-45, 3, 3, 2, np.nan, 0.5, -2, 7, 0], np.float32)
told = [simd_masks.AVX2]
for shift in range(16):
    chosen, found = np.zeros(32, np.float32), np.zeros(12, np.int64)
    compared(numbers, np.roll(numbers, shift), chosen, found)
    told += [found.tolist(), chosen.view(np.uint32).tolist()]
json.dump(told, sys.stdout)
"""


def told(features, monkeypatch):
    monkeypatch.setenv("NUMBA_CPU_NAME", "haswell")
    monkeypatch.setenv("NUMBA_CPU_FEATURES", features)
    shown = subprocess.run([sys.executable, "-c", PROGRAM], check=True, capture_output=True, text=True).stdout
    return json.loads(shown)


@pytest.mark.skipif(not numerics.processor_suffices(), reason="no processor with AVX2 under Linux")
def test_both_forms_tell_the_same(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    avx2, *ours = told("+avx2,+fma", monkeypatch)
    other, *llvms = told("+avx,+fma", monkeypatch)
    assert (avx2, other) == (True, False)
    assert ours == llvms
    assert ours[0][:6] == [0, 0, 0xF7EF, 1, 0, 0], "of a number and itself: never less, less or equal unless it is none"

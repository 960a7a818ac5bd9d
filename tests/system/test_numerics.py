"""Which numerics a process has, and torch's operations that portable numerics replace."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from avs.system import numerics
from avs.system.errors import UserError

ROOT = Path(__file__).parents[2]
needs_portable = pytest.mark.skipif(not numerics.processor_suffices(), reason="no processor for portable numerics")


def run(code, **environment):
    """Run ``code`` in a fresh interpreter without any of the variables of numerics but those given."""
    ours = {numerics.VARIABLE, *numerics.variables()}
    rest = {name: value for name, value in os.environ.items() if name not in ours}
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=ROOT, env=rest | environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    return done.stdout.strip()


FORCE = "from avs.system import compatibility, numerics; compatibility.prepare_torch(); print(numerics.in_force())"


@needs_portable
def test_numerics_are_portable_unless_asked_otherwise_or_a_variable_says_otherwise():
    assert run(FORCE) == "portable"
    assert run(FORCE, AVS_NUMERICS="native") == "native"
    assert run(FORCE, MKL_CBWR="AUTO") == "native"
    assert run(f"import numpy; {FORCE}") == "native"


def test_numerics_that_do_not_exist_are_refused(monkeypatch):
    monkeypatch.setenv(numerics.VARIABLE, "fast")
    with pytest.raises(UserError, match="AVS_NUMERICS: fast is none of portable, native; set it to one of these"):
        numerics.asked()


def test_other_numerics_are_another_origin(monkeypatch):
    from avs.system.code_inputs import stamp

    monkeypatch.setenv(numerics.VARIABLE, "portable")
    portable = stamp([])
    monkeypatch.setenv(numerics.VARIABLE, "native")
    assert stamp([]) != portable


@needs_portable
def test_libraries_are_held_to_the_instructions():
    code = """
from avs.system.compatibility import prepare_environment
prepare_environment()
import torch
from numba.core import codegen
from numba.core.registry import cpu_target
magic = cpu_target.target_context.codegen().magic_tuple()
print(torch.backends.cpu.get_cpu_capability(), magic[1], "avx512" in magic[2])
"""
    assert run(code) == "AVX2 haswell False"


# In a process of its own, because the replacement holds for all that follows in it.
OPERATIONS = """
from avs.system import compatibility
compatibility.prepare_environment()
import torch
kinds = (torch.float32, torch.float64, torch.bfloat16, torch.int32)

def results():
    generator = torch.Generator().manual_seed(0)
    for kind in kinds:
        some = (torch.rand(7, 6, generator=generator) * 3).to(kind)
        for name in ("acos", "asin", "atan", "log", "log10", "sqrt", "tan"):
            yield name, getattr(some.T, name)()
            if kind.is_floating_point:
                yield name + "_", getattr(some[:, ::2].clone(), name + "_")()
                yield name + ".out", getattr(torch, name)(some, out=torch.empty(0, dtype=kind))
        yield "mm", some @ some.T
        yield "mm of none", some[:0] @ some.T
        yield "bmm", some.expand(3, 7, 6) @ some.T.expand(3, 6, 7)
        yield "addmm", torch.addmm(some[:, :1], some, some[:6], beta=2, alpha=3)
        yield "baddbmm", torch.baddbmm(some[:, :1].expand(2, 7, 6), some.expand(2, 7, 6), some[:6].expand(2, 6, 6))
        if kind.is_floating_point and kind != torch.bfloat16:
            nothing = torch.full((7, 6), torch.nan, dtype=kind)
            yield "addmm to nothing", torch.addmm(nothing, some, some[:6], beta=0)
            pictures = torch.rand(2, 3, 9, 8, generator=generator).to(kind)
            bias = torch.rand(4, generator=generator).to(kind)
            weight = torch.rand(4, 3, 1, 1, generator=generator).to(kind)
            yield "1x1", torch.nn.functional.conv2d(pictures, weight, bias)
            weight = torch.rand(4, 3, 3, 2, generator=generator).to(kind).requires_grad_()
            found = torch.nn.functional.conv2d(pictures, weight, bias, stride=(2, 1), padding=(1, 0))
            found.square().sum().backward()
            yield "3x2", found.detach()
            yield "gradient", weight.grad
            linear = some.clone().requires_grad_()
            (torch.nn.functional.linear(linear, some[:4], some[:4, 0]).sqrt().sum() + linear.atan().sum()).backward()
            yield "gradient of a linear layer and a root", linear.grad

before = list(results())
compatibility.prepare_torch()
compatibility.prepare_torch()
after = list(results())
for (name, old), (_, new) in zip(before, after, strict=True):
    assert old.dtype == new.dtype and old.shape == new.shape, (name, old.dtype, new.dtype)
    tolerance = {torch.float32: 1e-5, torch.float64: 1e-12}.get(old.dtype, 1e-2)
    assert torch.allclose(old, new, rtol=tolerance, atol=tolerance, equal_nan=True), (name, old, new)
with torch.inference_mode():
    torch.nn.Linear(6, 3)(torch.ones(2, 6)).abs().sqrt_()
import numpy as np
values = torch.rand(10_001)
assert np.array_equal(values.sqrt().numpy(), np.sqrt(values.numpy()))
print(len(before))
"""


@needs_portable
def test_replaced_operations_of_torch_give_what_its_own_give_to_rounding():
    assert int(run(OPERATIONS)) > 80

"""Cures of the environment: each in a fresh process, as a program would use it."""

import importlib.util
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from avs.system import compatibility
from avs.system.stub_library import undefined_symbols

ROOT = Path(__file__).parents[2]


def run(code, **environment):
    """Run ``code`` in a fresh interpreter, with the named variables and none of those that the module sets."""
    ours = {*compatibility.variables(), *environment}
    rest = {name: value for name, value in os.environ.items() if name not in ours}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env=rest | environment, capture_output=True, text=True, check=True
    )
    return done.stdout.strip()


def test_variables_are_set_where_the_user_has_not_set_them():
    code = """
import os
from avs.system.compatibility import prepare_environment
prepare_environment()
print(os.environ["OMP_NUM_THREADS"], os.environ["OMP_WAIT_POLICY"], os.environ["HF_HUB_OFFLINE"])
"""
    assert run(code) == "1 passive 1"
    assert run(code, HF_HUB_OFFLINE="0") == "1 passive 0"


@pytest.mark.parametrize("numerics", ["portable", "native"])
def test_a_process_has_one_thread_whatever_is_set(numerics):
    """With two, OpenBLAS and MKL end in other bits, so that a scorer had other weights; and times would be of two."""
    code = """
import os
from avs.system.compatibility import prepare_environment
prepare_environment()
print(*(os.environ[f"{name}_NUM_THREADS"] for name in ("OMP", "MKL", "OPENBLAS", "NUMBA")))
"""
    told = {"OMP_NUM_THREADS": "4", "OPENBLAS_NUM_THREADS": "2", "MKL_NUM_THREADS": "2"}
    assert run(code, **told, AVS_NUMERICS=numerics) == "1 1 1 1"


def test_the_module_itself_imports_nothing_heavy():
    code = "import sys, avs.system.compatibility; print({'torch', 'numpy', 'open3d', 'numba'} & set(sys.modules))"
    assert run(code) == "set()"


def test_torch_torchvision_and_open3d_import_and_work():
    code = """
from avs.system.compatibility import import_open3d, prepare_torch, prepare_torchvision
prepare_torch()
for _ in range(2):
    prepare_torchvision()
    open3d = import_open3d()
import torch
from torchvision.models import resnet18
scene = open3d.t.geometry.RaycastingScene()
box = open3d.t.geometry.TriangleMesh.create_box()
scene.add_triangles(box)
rays = open3d.core.Tensor([[0.5, 0.5, -1, 0, 0, 1]], dtype=open3d.core.float32)
hit = scene.cast_rays(rays)["t_hit"].numpy().round(6)[0]
print(torch.get_num_threads(), hit, resnet18(weights=None).eval()(torch.zeros(1, 3, 32, 32)).shape)
"""
    assert run(code) == "1 1.0 torch.Size([1, 1000])"


def test_torchvision_cure_comes_only_where_its_operators_are_missing():
    if run("import torch; print(torch.version.cuda)") != "None":
        pytest.skip("beside a CUDA build of torch torchvision's own library declares its operators")
    code = """
import torch
torch.library.define("torchvision::nms", "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
torch.library.define("torchvision::qnms", "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
from avs.system.compatibility import prepare_torchvision
prepare_torchvision()
import torchvision
print("imported")
"""
    assert run(code) == "imported"


@pytest.mark.skipif(sys.platform != "linux" or platform.machine() != "x86_64", reason="for Linux on x86-64")
@pytest.mark.parametrize("version", ["", "NOTHING_1.2"])
def test_a_stand_in_is_found_by_name_and_answers_zero(version):
    code = f"""
import ctypes
from avs.system.stub_library import load_stub
load_stub("libother.so.1", ["one"])
load_stub("libnothing.so.9", ["alpha", "beta", "gamma"], {version!r})
library = ctypes.CDLL("libnothing.so.9")
print([getattr(library, name)(7) for name in ("alpha", "beta", "gamma")], hasattr(library, "one"))
linker = ctypes.CDLL(None)
linker.dlvsym.restype = ctypes.c_void_p
find = lambda version: linker.dlvsym(ctypes.c_void_p(library._handle), b"beta", version)
print(find({version!r}.encode()) is not None, find(b"OTHER_1") is not None)
"""
    # A library without versions serves whoever asks for any.
    assert run(code) == ("[0, 0, 0] False\nTrue False" if version else "[0, 0, 0] False\nTrue True")


@pytest.mark.skipif(sys.platform != "linux" or platform.machine() != "x86_64", reason="for Linux on x86-64")
def test_undefined_symbols_are_those_that_another_library_defines():
    origin = importlib.util.find_spec("open3d").origin
    (library,) = Path(origin).parent.glob("libOpen3D.so*")
    symbols = undefined_symbols(library)
    assert {"eglInitialize", "glViewport", "malloc"} < set(symbols)
    assert symbols == sorted(symbols)

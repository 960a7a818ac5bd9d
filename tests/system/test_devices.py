"""GPUs are dealt out to the processes of a machine; torch is replaced, since no GPU is needed for that."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yte

from avs.system import devices
from avs.system.errors import UserError

TAKE = """
import sys, types
torch = types.ModuleType("torch")
torch.cuda = types.SimpleNamespace(is_available=lambda: True)
sys.modules["torch"] = torch
from avs.system.devices import take_device
take_device("cuda")
take_device("cuda")
import os
print(os.environ.get("CUDA_VISIBLE_DEVICES"), flush=True)
sys.stdin.read()
"""


@pytest.fixture
def taker(tmp_path):
    """Start processes that take a device, and end them at last."""
    started = []

    def start(listed):
        names = {name: text for name, text in os.environ.items() if name != "CUDA_VISIBLE_DEVICES"}
        told = names | {"TMPDIR": str(tmp_path)} | ({} if listed is None else {devices.VARIABLE: listed})
        process = subprocess.Popen(
            [sys.executable, "-c", TAKE], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=told, text=True
        )
        started.append(process)
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def test_each_process_gets_a_device_of_its_own_and_waits_while_all_are_taken(taker):
    first = taker("3, 5")
    assert first.stdout.readline() == "3\n"
    second = taker("3, 5")
    assert second.stdout.readline() == "5\n"
    third = taker("3, 5")
    os.set_blocking(third.stdout.fileno(), False)
    time.sleep(2)
    assert third.stdout.readline() == ""
    second.kill()  # with no time to give anything back
    os.set_blocking(third.stdout.fileno(), True)
    assert third.stdout.readline() == "5\n"


def test_without_a_list_nothing_is_dealt_out(taker):
    assert taker(None).stdout.readline() == "None\n"


@pytest.mark.parametrize("listed", ["", "0,,1", "0,0", "../x", "0;1"])
def test_what_is_no_list_of_devices_is_refused(listed, monkeypatch):
    monkeypatch.setenv(devices.VARIABLE, listed)
    with pytest.raises(UserError, match="no list of different devices"):
        devices.take_device("cuda")


def test_the_processor_needs_no_device(monkeypatch):
    monkeypatch.setenv(devices.VARIABLE, "what")
    devices.take_device("cpu")


STAND_IN = """
import os, types
_SIZES = {"0": 24, "1": 8, "2": 48}
_SEEN = os.environ.get("CUDA_VISIBLE_DEVICES", "0,1,2").split(",")
cuda = types.SimpleNamespace(
    device_count=lambda: len(_SEEN),
    get_device_properties=lambda n: types.SimpleNamespace(total_memory=_SIZES[_SEEN[n]]),
)
"""


@pytest.mark.parametrize(("listed", "smallest"), [(None, 8), ("0,2", 24), ("2", 48)])
def test_the_smallest_device_is_of_those_that_are_dealt_out(listed, smallest, tmp_path, monkeypatch):
    (tmp_path / "torch.py").write_text(STAND_IN)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    if listed is not None:
        monkeypatch.setenv(devices.VARIABLE, listed)
    assert devices.smallest_gpu() == smallest


def test_the_profile_lets_as_many_jobs_run_as_there_are_devices(monkeypatch):
    text = (Path(__file__).parents[2] / "profiles" / "gpu" / "profile.yaml").read_text()
    monkeypatch.setenv(devices.VARIABLE, "0,1,2")
    assert yte.process_yaml(text)["resources"] == ["gpu=3"]
    monkeypatch.delenv(devices.VARIABLE)
    assert yte.process_yaml(text)["resources"] == ["gpu=1"]

"""The load of a machine: from counters made up for the test, and what is not known."""

import os
import time

import pytest

from avs.system import machine_load
from avs.system.machine_load import LoadMeter

TICKS = os.sysconf("SC_CLK_TCK")


@pytest.fixture
def counted(tmp_path, monkeypatch):
    """Measure while the kernel counts so many seconds of user, steal and idle time."""
    monkeypatch.setattr(machine_load, "_STAT", tmp_path / "stat")
    monkeypatch.setattr(machine_load, "_LEAST_SECONDS", 0.05)
    monkeypatch.setattr(machine_load, "_own_seconds", lambda: 1.0)

    def put(user, steal, idle):
        counts = [round(seconds * TICKS) for seconds in (user, 0, 0, idle, 0, 0, 0, steal, 0, 0)]
        (tmp_path / "stat").write_text(f"cpu  {' '.join(map(str, counts))}\ncpu0 1\n")

    def measure(user, steal, idle):
        put(100, 10, 1000)
        meter = LoadMeter()
        put(100 + user, 10 + steal, 1000 + idle)
        return meter.others()

    return measure


def test_what_others_and_the_hypervisor_took_is_counted(counted):
    start = time.perf_counter()
    found = counted(user=30.0, steal=10.0, idle=60.0)
    elapsed = time.perf_counter() - start
    # 40 seconds of others while the clock of this process went on by a twentieth of a second or more.
    assert elapsed >= 0.05
    assert 40.0 / elapsed <= found <= 40.0 / 0.05


def test_an_idle_machine_has_no_load(counted):
    assert counted(user=0.0, steal=0.0, idle=10.0) == pytest.approx(0.0)


def test_counters_that_stand_still_or_are_not_there_tell_nothing(counted, tmp_path, monkeypatch):
    assert counted(user=0.0, steal=0.0, idle=0.0) is None
    monkeypatch.setattr(machine_load, "_STAT", tmp_path / "absent")
    assert LoadMeter().others() is None


def test_a_hundredth_of_a_second_more_of_ones_own_is_rounding(counted, monkeypatch):
    own = iter([1.0, 1.02])
    monkeypatch.setattr(machine_load, "_own_seconds", lambda: next(own))
    assert counted(user=0.0, steal=0.0, idle=10.0) == 0.0


def test_ones_own_work_is_no_load_of_others(counted, monkeypatch):
    own = iter([1.0, 3.0])
    monkeypatch.setattr(machine_load, "_own_seconds", lambda: next(own))
    assert counted(user=2.0, steal=0.0, idle=10.0) == pytest.approx(0.0)


def test_the_kernel_of_this_machine_is_read():
    found = LoadMeter().others()
    assert found is None or 0.0 <= found <= os.cpu_count() + 0.5

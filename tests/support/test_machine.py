"""The speed of this machine: measured once, kept, and not taken from another machine."""

import pytest
from damage import flip

from fefinger.support import machine


MEASURE = machine.measure  # the tests of other modules take that of the reports


@pytest.fixture(autouse=True)
def _own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def test_the_work_takes_a_time_and_is_kept(monkeypatch):
    monkeypatch.setattr(machine, "ROUNDS", 1)
    monkeypatch.setattr(machine, "measure", MEASURE)
    assert machine.known() is None
    assert "measures this one" in machine.sentence()
    measured = machine.seconds()
    assert 0.001 < measured < 10
    monkeypatch.setattr(machine, "measure", lambda: pytest.fail("measured twice"))
    assert machine.seconds() == measured  # exact: kept, not measured again
    assert "Times are for this machine" in machine.sentence()


def test_times_scale_with_the_machine_of_the_report(monkeypatch):
    assert machine.slowness({"machine_seconds": 5.0}) == 1.0
    monkeypatch.setattr(machine, "measure", lambda: 0.3)
    machine.seconds()
    assert machine.slowness({"machine_seconds": 0.1}) == pytest.approx(3.0)
    assert machine.slowness({}) == pytest.approx(0.3 / machine.REPORTED)


def test_a_damaged_record_is_measured_again(monkeypatch):
    monkeypatch.setattr(machine, "measure", lambda: 0.25)
    assert machine.seconds() == 0.25
    flip(machine.kept_path() / "seconds.txt")
    assert machine.kept() is None
    assert not machine.kept_path().exists()
    assert machine.seconds() == machine.kept() == 0.25


def test_the_record_of_another_machine_counts_as_none(monkeypatch):
    monkeypatch.setattr(machine, "measure", lambda: 0.25)
    machine.seconds()
    monkeypatch.setattr(machine, "_name", lambda: "another")
    assert machine.kept() is None


def test_without_a_cache_it_is_measured_again(monkeypatch, tmp_path):
    (tmp_path / "fefinger").write_text("a file in the way")
    monkeypatch.setattr(machine, "measure", lambda: 0.25)
    monkeypatch.setattr(machine, "_unkept", {})
    assert machine.seconds() == 0.25
    assert machine.kept() is None
    said = machine.sentence()
    assert f"{machine.REPORTED / 0.25:.2g} times as fast" in said
    assert f"measured again every time, as {machine.kept_path()} cannot be written: " in said
    assert machine.slowness({"machine_seconds": 0.1}) == pytest.approx(2.5)
    monkeypatch.setattr(machine, "measure", lambda: pytest.fail("measured twice"))
    assert machine.seconds() == 0.25

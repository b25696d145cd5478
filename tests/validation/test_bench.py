"""The benchmarks: their record, their arithmetic and their baselines; never a time."""

import json

import numpy as np
import pytest
from fefinger.validation.bench import fem, neural, recorded, suites
from fefinger.validation.fem import hertz

from fefinger.__main__ import main
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.support import machine


def test_a_figure_has_a_ratio_only_where_there_is_a_baseline():
    assert suites.Figure("a", 3.0, "s", 2.0).ratio == 1.5
    assert suites.Figure("a", 3.0, "s").ratio is None
    assert suites.Figure("a", 3.0, "s", 0.0).ratio is None


def test_bench_prints_the_record_of_the_contract_and_a_table(capsys, monkeypatch, tmp_path):
    figures = [suites.Figure("fast", 0.1, "s", 1.0), suites.Figure("load", 0.5, "processes")]
    monkeypatch.setattr(neural, "figures", lambda progress: figures)
    assert main(["bench", "neural", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "figures": [
            {"name": "fast", "value": 0.1, "unit": "s", "baseline": 1.0, "ratio": 0.1},
            {"name": "load", "value": 0.5, "unit": "processes", "baseline": None, "ratio": None},
        ]
    }
    assert main(["bench", "neural", "-o", str(tmp_path)]) == 0
    assert "fast" in capsys.readouterr().out
    written = json.loads((tmp_path / "bench-neural.json").read_text())
    assert written["figures"][0]["ratio"] == 0.1
    assert set(written) == {"command", "commit", "date", "machine", "versions", "figures"}


def test_the_record_names_the_commit_of_the_program_alone(monkeypatch, tmp_path):
    """Not that of a repository around it, and none where there is no git."""
    machine.commit.cache_clear()
    monkeypatch.setenv("PATH", "")
    written = json.loads(suites.write("neural", [], tmp_path).read_text())
    machine.commit.cache_clear()
    assert written["commit"] == ""


def test_an_unknown_suite_is_refused(capsys):
    assert main(["bench", "neurol"]) == 2
    assert "Did you mean 'neural'?" in capsys.readouterr().err


def test_the_neural_suite_measures_every_method(monkeypatch):
    monkeypatch.setattr(neural, "UNITS", 4)
    monkeypatch.setattr(neural, "REPEATS", 1)
    monkeypatch.setattr(neural, "EXACT", 1)
    figures = suites.run(["neural"])["neural"]
    values = {figure.name: figure.value for figure in figures}
    assert len(values) == len(figures)
    for name in neural.methods():
        assert values[f"{name}: wall"] > 0
    assert values["Runge-Kutta 0.05 ms: units miscounted"] == 0
    assert 0 < values["splitting, tolerance 0.05 ms: median spike-time error"] < 0.05


def test_the_recorded_suite_drives_the_same_units_by_a_series_and_by_steps(monkeypatch):
    monkeypatch.setattr(recorded, "SHARES", dict.fromkeys(recorded.SHARES, 3))
    types, x = recorded.inputs()
    assert len(types) == x.shape[1] == 12
    assert x.max() == pytest.approx(0.55, rel=0.01)
    figures = recorded.series()
    assert figures[0].name == "12 units for 1 s: wall"
    assert figures[-1].value > 100


def test_the_fem_suite_measures_every_stage(monkeypatch):
    monkeypatch.setattr(fem, "RESOLUTION", "coarse")
    monkeypatch.setattr(fem, "REPEATS", 1)
    monkeypatch.setattr(fem, "STEPS", 20)
    monkeypatch.setattr(fem, "HERTZ", hertz.LEVELS[0])
    figures = {figure.name: figure for figure in suites.run(["fem"])["fem"]}
    assert figures["unknowns"].value > 10_000
    errors = {name for name in figures if name.startswith("Hertz") and figures[name].unit == "%"}
    assert {name.partition(": ")[2] for name in errors} < set(hertz.TARGETS)
    assert all(abs(figures[name].value) > 0 for name in errors)
    assert all(figures[name].value > 0 for name in figures.keys() - errors)
    assert figures["factor: entries"].ratio < 1.5
    for name in ("factor: CPU", "64 loads: CPU"):
        assert figures[name].baseline > 0


def test_the_plain_loop_and_the_vector_form_of_runge_kutta_are_one_method():
    current = neural.currents(3)
    slowed = HodgkinHuxley(neural.DIVISOR)
    fired = slowed.fire(neural.TIME, current, stimulus_driven=False).times
    for a, b in zip(neural.plain(current, exponential=False), fired, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-9)


def test_spike_times_are_compared_only_where_counts_agree():
    reference = [np.array([0.1, 0.2]), np.array([0.3]), np.array([])]
    error = neural.compare([np.array([0.1001, 0.2003]), np.array([]), np.array([])], reference)
    assert error.miscounted == 1
    assert error.worst == pytest.approx(0.3)
    assert error.median == pytest.approx(0.2)

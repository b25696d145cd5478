"""The suite `afferents`: its data, its closed forms against simulation, and its names."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from fefinger.validation.afferents import data, drawings, experiments, fit
from fefinger.validation.afferents.vibration import Probed, determination

from fefinger.neural.recorded import BOUNDS, fitted


FILES = {
    "vibration_rates": 180,
    "thresholds_units": 31,
    "thresholds_channels": 72,
    "curvature_SAI": 21,
    "curvature_distance_SAI": 55,
    "bar_SAI": 288,
    "dots_scanned": 36,
}


@pytest.mark.parametrize("name", FILES)
def test_every_file_of_data_has_its_points_and_says_where_they_are_from(name):
    assert len(data.rows(name)) == pytest.approx(FILES[name], abs=4)
    folder = data.resources.files("fefinger.validation.afferents")
    head = folder.joinpath(f"data/{name}.csv").read_text(encoding="utf-8")
    assert head.startswith("# ")
    assert "Ouyang" in head.partition("\n#")[2]


@pytest.mark.parametrize("kind", ["SAI", "FAI", "FAII"])
@pytest.mark.parametrize("frequency", [30.0, 200.0])
def test_the_threshold_in_closed_form_is_that_of_the_simulated_unit(kind, frequency):
    unit = replace(fitted()[kind], noise=0.0)
    probed = Probed(kind, unit, 0.5)
    edge = probed.threshold(frequency)
    for factor, fires in ((0.93, False), (1.07, True)):
        (times,) = probed.times(frequency, np.array([factor * edge]), np.ones(1), 0.6)
        assert bool(np.any(times > 0.2)) == fires


def test_the_gains_of_a_population_have_the_spread_of_the_type():
    unit = replace(fitted()["FAI"], spread=0.5)
    gains = np.log(Probed("FAI", unit, 0.5).gains(2000))
    assert gains.mean() == pytest.approx(0.0, abs=1e-9)
    assert gains.std() == pytest.approx(0.5, rel=0.01)


def test_determination_is_one_less_the_rest_over_the_spread():
    recorded = np.array([0.0, 1.0, 2.0])
    assert determination(recorded, recorded) == 1.0
    assert determination(np.ones(3), recorded) == 0.0
    assert determination(recorded + 1.0, recorded) == pytest.approx(-0.5)


def test_errors_of_a_fit_are_those_of_a_straight_line_and_large_where_nothing_depends():
    best = np.log(list(fit.FREE["FAI"].values())).mean(axis=1)
    n, off = len(best) - 1, 0.3

    def residuals(at):
        moved = 2.0 * (at - best)[:n]
        return np.concatenate([moved + off, moved - off, moved])

    found = fit.errors(SimpleNamespace(kind="FAI", residuals=residuals), best)
    variance = 2 * n * off**2 / (3 * n - len(best))
    assert found[:n] == pytest.approx(np.sqrt(variance / 12), rel=1e-6)
    assert found[n] == 10.0


@pytest.mark.parametrize(
    ("error", "text"), [(0.2, " ± 0.2"), (3.0, " (free)"), (1e-18, " (free)"), (None, "")]
)
def test_a_parameter_that_the_data_do_not_hold_is_said_to_be_free(error, text):
    assert drawings._error({"value": 1.0, "error": error}) == text


@pytest.mark.parametrize("kind", ["SAI", "FAI", "FAII"])
def test_every_parameter_is_fitted_or_set_with_a_reason(kind):
    fixed, free = fit.SET[kind], fit.FREE[kind]
    assert not set(fixed) & set(free)
    assert set(fixed) | set(free) <= set(BOUNDS)
    for name, (low, high) in free.items():
        assert BOUNDS[name].low <= low < high <= BOUNDS[name].high
        assert low <= getattr(fitted()[kind], name) <= high
    assert all(reason for _, reason in fixed.values())


@pytest.mark.usefixtures("operators")
def test_a_pin_at_small_strain_strains_in_proportion_to_its_depth_once_it_rests_on_its_flat():
    depths = np.array([0.3, 0.5, 0.7])
    drive = experiments.pressed(
        experiments.PROBE,
        depths,
        np.zeros(1),
        drive="compressive",
        organ=0.5,
        mechanics="condensed",
        finger=replace(experiments.MACAQUE, resolution="coarse"),
    )[:, 0]
    assert np.diff(drive) == pytest.approx(np.diff(drive).mean(), rel=0.1)

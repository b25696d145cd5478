"""The siblings of the Hodgkin-Huxley membrane against solvers of the published equations."""

import numpy as np
import pytest
from fefinger.validation.neural.connor_stevens import ConnorStevens
from refusals import refused
from scipy.integrate import solve_ivp

from fefinger.neural.afferent_units import simulate_units
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire
from fefinger.support.checks import InputError


MEMBRANES = pytest.mark.parametrize(
    "membrane",
    [HodgkinHuxley(), ConnorStevens(), IntegrateAndFire()],
    ids=lambda m: type(m).__name__,
)


def through(level, *, direction=1.0):
    def event(t, y):
        return y[0] - level

    event.direction = direction
    return event


def connor_stevens(t, y, current):
    """Dayan & Abbott (2001), Eq. 6.27 to 6.38, written out without care; ms, mV, mS/cm²."""
    v, n, m, h, a, b = y
    exp = np.exp
    a_n, b_n = 0.02 * (v + 45.7) / (1 - exp(-0.1 * (v + 45.7))), 0.25 * exp(-0.0125 * (v + 55.7))
    a_m, b_m = 0.38 * (v + 29.7) / (1 - exp(-0.1 * (v + 29.7))), 15.2 * exp(-0.0556 * (v + 54.7))
    a_h, b_h = 0.266 * exp(-0.05 * (v + 48)), 3.8 / (1 + exp(-0.1 * (v + 18)))
    a_oo = (0.0761 * exp(0.0314 * (v + 94.22)) / (1 + exp(0.0346 * (v + 1.17)))) ** (1 / 3)
    b_oo = (1 / (1 + exp(0.0688 * (v + 53.3)))) ** 4
    tau_a = 0.3632 + 1.158 / (1 + exp(0.0497 * (v + 55.96)))
    tau_b = 1.24 + 2.678 / (1 + exp(0.0624 * (v + 50)))
    ionic = 120 * m**3 * h * (v - 55) + 20 * n**4 * (v + 72) + 0.3 * (v + 17)
    ionic += 47.7 * a**3 * b * (v + 75)
    return [
        current - ionic,
        a_n * (1 - n) - b_n * n,
        a_m * (1 - m) - b_m * m,
        a_h * (1 - h) - b_h * h,
        (a_oo - a) / tau_a,
        (b_oo - b) / tau_b,
    ]


@MEMBRANES
def test_nothing_happens_without_current(membrane):
    firing = membrane.fire([0.0, 0.5], [0.0, 0.0])
    assert len(firing.times[0]) == firing.stimulus_driven[0] == 0
    assert firing.peak_mV[0] == pytest.approx(0.0, abs=5e-3)
    assert firing.final[0, 0] == pytest.approx(0.0, abs=5e-3)


@MEMBRANES
def test_units_of_every_membrane_are_independent(membrane):
    time = np.linspace(0, 0.1, 51)
    currents = np.outer(np.sin(60 * time) ** 2, np.linspace(5.0, 60.0, 5))
    together = membrane.fire(time, currents)
    assert sum(map(len, together.times)) > 5
    for i in range(5):
        alone = membrane.fire(time, currents[:, i])
        np.testing.assert_allclose(together.times[i], alone.times[0], rtol=0, atol=1e-9)
        np.testing.assert_allclose(together.final[i], alone.final[0], rtol=0, atol=1e-7)


@MEMBRANES
def test_every_membrane_refuses_what_its_siblings_refuse(membrane):
    with pytest.raises(InputError, match="lower the gain"):
        membrane.fire([0.0, 1.0], [0.0, 1e6])
    with refused("dt"):
        membrane.fire([0.0, 1.0], [0.0, 1.0], dt=1e-3)


@pytest.mark.parametrize("current", [9.0, 20.0, 40.0])
def test_connor_stevens_spikes_agree_with_an_adaptive_integrator(current):
    truth = solve_ivp(
        lambda t, y: connor_stevens(t, y, current),
        (0.0, 150.0),
        ConnorStevens().rest(),
        method="DOP853",
        rtol=1e-10,
        atol=1e-11,
        events=through(ConnorStevens().rest()[0] + 40.0),
    ).t_events[0]
    (times,) = ConnorStevens().fire([0.0, 0.15], [current, current]).times
    assert len(times) == len(truth) > 1
    np.testing.assert_allclose(times, 1e-3 * truth, atol=4e-5)


def test_connor_stevens_fires_at_any_low_rate_where_hodgkin_huxley_jumps():
    def lowest(membrane, levels, seconds):
        firing = membrane.fire([0.0, seconds], np.outer([1.0, 1.0], levels), stimulus_driven=False)
        rates = np.array([np.sum(times > seconds / 2) / (seconds / 2) for times in firing.times])
        assert rates[0] == 0.0
        assert np.all(np.diff(rates[rates > 0]) >= 0)
        return rates[rates > 0].min()

    assert lowest(ConnorStevens(), np.linspace(8.0, 8.6, 13), 2.0) < 6.0
    assert lowest(HodgkinHuxley(1.0), np.linspace(6.2, 6.8, 13), 2.0) > 48.0


def test_a_stronger_transient_current_slows_connor_stevens():
    rates = [len(ConnorStevens(g).fire([0.0, 1.0], [20.0] * 2).times[0]) for g in (40, 47.7, 60)]
    assert rates[0] > rates[1] > rates[2] > 0


def test_connor_stevens_reports_block():
    firing = ConnorStevens().fire([0.0, 0.5], [[80.0, 150.0], [80.0, 150.0]])
    assert firing.block_seconds[0] == 0.0
    assert 0.4 < firing.block_seconds[1] < 0.5


def test_the_transient_current_undoes_the_convergence_to_one_impulse_per_cycle():
    """Thesis 4.4.2: at 16 Hz all amplitudes give one impulse per cycle, with the current many."""
    time = np.linspace(0, 1.0, 3201)
    currents = np.outer(1 - np.cos(2 * np.pi * 16 * time), [6.25, 12.5, 25.0, 50.0])

    def per_cycle(membrane):
        firing = membrane.fire(time, currents, stimulus_driven=False)
        return [np.sum(times >= 0.5) / 8 for times in firing.times]

    assert per_cycle(HodgkinHuxley(6.0)) == [1.0, 1.0, 1.0, 1.0]
    np.testing.assert_allclose(per_cycle(ConnorStevens()), [1.0, 4.0, 8.0, 13.5], atol=0.26)


@pytest.mark.parametrize("current", [5.0, 6.2, 7.0, 20.0, 100.0])
def test_integrate_and_fire_has_the_closed_form_rate(current):
    membrane = IntegrateAndFire()
    firing = membrane.fire(np.linspace(0.0, 20.0, 77), np.full(77, current))
    (times,) = firing.times
    if current <= membrane.threshold:
        assert len(times) == membrane.rate(current) == 0
        reached = 1 - np.exp(-20.0 / membrane.time_constant)
        assert firing.peak_mV[0] == pytest.approx(40 * reached * current / membrane.threshold)
    else:
        np.testing.assert_allclose(np.diff(times), 1 / membrane.rate(current), rtol=1e-9)
        assert firing.peak_mV[0] == 40.0


@pytest.mark.parametrize("seed", range(4))
def test_integrate_and_fire_is_exact_in_any_piecewise_linear_current(seed):
    rng = np.random.default_rng(seed)
    time = np.sort(np.append(rng.uniform(0, 0.5, 38), [0.0, 0.5]))
    time[10] = time[9]
    current = rng.uniform(-15.0, 60.0, 40)
    membrane = IntegrateAndFire(refractory=0.004, time_constant=0.01)
    firing = membrane.fire(time, current)
    (times,) = firing.times
    u, free, expected = 0.0, 0.0, []
    for t0, t1, i0, i1 in zip(time, time[1:], current, current[1:], strict=False):
        start = max(t0, free)
        while start < t1:
            run = solve_ivp(
                lambda t, u, t0=t0, t1=t1, i0=i0, i1=i1: (
                    ((i0 + (i1 - i0) * (t - t0) / (t1 - t0)) / 6.2 - u) / 0.01
                ),
                (start, t1),
                [u],
                rtol=1e-11,
                atol=1e-13,
                method="DOP853",
                events=through(1.0),
            )
            if not len(run.t_events[0]):
                u = run.y[0, -1]
                break
            expected.append(run.t_events[0][0])
            u, free = 0.0, expected[-1] + 0.004
            start = free
    assert len(expected) > 8
    np.testing.assert_allclose(times, expected, atol=1e-9)
    assert firing.final[0, 0] == pytest.approx(40 * u, abs=1e-6)


@pytest.mark.parametrize(("kind", "depth"), [("SAI", 0.3), ("FAI", 0.4), ("SAII", 0.5)])
def test_integrate_and_fire_takes_a_jump_as_a_steep_ramp(kind, depth):
    x = np.array([0.0, 0.0, depth, depth])[:, None]
    jump, ramp = (
        simulate_units(
            [0, 0.1, end, 0.5], x, types=[kind], membrane=IntegrateAndFire(), check=False
        )
        for end in (0.1, 0.1 + 1e-9)
    )
    assert jump.count()[0] > 0
    np.testing.assert_allclose(jump.times[0], ramp.times[0], atol=1e-7)
    between = IntegrateAndFire().fire([0, 0.1, np.nextafter(0.1, 1), 0.3], [0, 0, 30, 30])
    at_once = IntegrateAndFire().fire([0, 0.1, 0.1, 0.3], [0, 0, 30, 30])
    np.testing.assert_allclose(between.times[0], at_once.times[0], rtol=1e-12)


def test_integrate_and_fire_reports_a_peak_between_samples():
    membrane = IntegrateAndFire(threshold=60.0, time_constant=0.01, refractory=0.01)
    fine = np.linspace(0, 0.04, 4001)
    expected = membrane.fire(fine, 100 - 5000 * fine).peak_mV
    assert expected[0] == pytest.approx(30.05, abs=0.01)
    np.testing.assert_allclose(membrane.fire([0, 0.04], [100, -100]).peak_mV, expected, rtol=1e-4)


def test_integrate_and_fire_finds_a_threshold_that_is_touched_between_samples():
    membrane = IntegrateAndFire(threshold=1.0, time_constant=0.01, refractory=0.0)
    time = [0.0, 0.01]
    for top, spikes in ((3.2, 0), (3.3, 1)):
        firing = membrane.fire(time, [top, 0.0])
        inside = np.linspace(*time, 20_001)
        falling = top * (1 - inside / 0.01)
        c = -top * 2.0
        u = falling + top + c * np.exp(-inside / 0.01)
        assert (u.max() >= 1.0) == (spikes == 1)
        assert u[-1] < 1.0
        assert len(firing.times[0]) == spikes
        if spikes:
            assert firing.times[0][0] == pytest.approx(inside[np.argmax(u >= 1.0)], abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        (IntegrateAndFire, {"threshold": 0.0}),
        (IntegrateAndFire, {"time_constant": 0.0}),
        (IntegrateAndFire, {"refractory": -1.0}),
        (ConnorStevens, {"transient": 20.0}),
    ],
)
def test_impossible_membranes_are_refused(kind, options):
    with pytest.raises(InputError, match=next(iter(options))):
        kind(**options)


@MEMBRANES
def test_every_membrane_serves_an_afferent(membrane):
    trains = simulate_units(
        [0.0, 0.1, 0.3], [[0.0], [1.0], [1.0]], types=["SAI"], membrane=membrane
    )
    assert len(trains.times[0]) > 2

"""The models of the thesis beside what its suite measures of them: identities, limits, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.oracles import goodwin, impedance
from fefinger.validation.oracles.ergonomics import dissipation, tap, vibration
from fefinger.validation.oracles.fingerpad import Fingerpad
from fefinger.validation.thesis.pressure import pad
from fefinger.validation.thesis.unloading import pressure_as_printed

from fefinger.scene import library
from fefinger.theory.contact.hertz import Hertz, relative_radius
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony, hereditary_integral


LUMPED = {name: (Spring(row.b, row.m), row.prony) for name, row in library.lumped().items()}
EVERY = pytest.mark.parametrize(("spring", "prony"), LUMPED.values(), ids=LUMPED)
MEANS = pad("means", "relaxed")


# Energy of the lumped finger


def test_a_spring_loses_nothing_and_stores_its_energy():
    spring = Spring(0.2, 2.0)
    lost = tap(spring, Prony((1.0,), ()), depth=1.0, speed=10.0)
    stored = spring.b / spring.m * (np.expm1(2.0) / 2.0 - 1.0)
    assert lost.loading == pytest.approx(stored, rel=1e-6)
    assert lost.fraction == pytest.approx(0.0, abs=1e-12)


def test_an_indenter_that_leaves_at_once_gets_nothing_back():
    """The thesis's extreme case: all the work is dissipated."""
    time, position = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.0])
    assert dissipation(time, position, [0.0, 1.0, -1.0]).loading == pytest.approx(0.5)
    gone = dissipation(np.array([0, 1, 1.0, 2]), np.array([0, 1, 1.0, 0]), [0, 1, -1, -1])
    assert gone.fraction == 1.0
    assert gone.power == pytest.approx(0.25)


@pytest.mark.parametrize(("swing", "lifts"), [(0.28, True), (0.14, False)])
def test_a_fast_and_wide_vibration_loses_contact(swing, lifts):
    options = {"offset": 1.5, "peak_to_peak": swing}
    slow, fast = (vibration(*LUMPED["a.h."], frequency=f, **options) for f in (1, 128))
    assert slow.contact == 1.0
    assert (fast.contact < 1) == lifts
    assert fast.peak_to_peak / slow.peak_to_peak <= 2.17  # 2.16 where the skin is glued


# Impedance of the lumped finger


@EVERY
def test_the_spectrum_is_the_laplace_transform_by_quadrature(spring, prony):
    """The integral of (G - c0) e^(-i w t), by trapezoids on a graded grid, plus c0 / i w."""
    t = np.concatenate([[0.0], np.geomspace(1e-7, 60, 400_000)])
    w = 2 * np.pi * 7.0
    decaying = prony.relaxation(t) - prony.long_time
    expected = np.trapezoid(decaying * np.exp(-1j * w * t), t) + prony.long_time / (1j * w)
    assert complex(impedance.relaxation_spectrum(prony, 7.0)) == pytest.approx(expected, rel=1e-5)


@EVERY
def test_the_stiffness_is_that_of_the_depth_which_relaxes_to_the_preload(spring, prony):
    """As printed it is low by the relaxation where the preload rules, and right at none."""
    depth, step = 1.3, 1e-6
    preload = prony.long_time * float(spring.force(depth))
    slope = np.diff(spring.force([depth - step, depth + step]))[0] / (2 * step)
    found = impedance.operating_stiffness(spring, prony, preload)
    assert float(found) == pytest.approx(slope, rel=1e-7)
    right, printed = (
        impedance.operating_stiffness(spring, prony, [0.0, 1e6], printed=p) for p in (False, True)
    )
    assert right[0] == printed[0] == spring.b
    assert right[1] / printed[1] == pytest.approx(1 / prony.long_time, rel=1e-5)
    separate = slope * impedance.relaxation_spectrum(prony, 30.0)
    assert impedance.impedance(spring, prony, 30.0, preload) == pytest.approx(separate, rel=1e-6)


@pytest.mark.parametrize("frequency", [0.0, -1.0, float("nan")])
def test_a_frequency_that_is_not_above_zero_is_refused(frequency):
    with pytest.raises(ValueError, match="frequencies > 0 Hz"):
        impedance.relaxation_spectrum(LUMPED["means"][1], frequency)


# Distributed pressure


@pytest.mark.parametrize("depth", [0.2, 1.0, 2.5])
def test_at_one_depth_it_is_hertz_of_the_modulus_there(depth):
    hertz = Hertz(MEANS.radius, depth, float(MEANS.modulus(depth)), 0.5)
    r = np.linspace(0, 1.2, 30) * hertz.contact_radius
    assert MEANS.pressure(r, depth) == pytest.approx(hertz.pressure(r), abs=1e-9)
    assert MEANS.force(depth) == pytest.approx(hertz.force)
    assert MEANS.contact_radius(depth) == pytest.approx(hertz.contact_radius)


def test_out_of_contact_there_is_nothing():
    assert MEANS.force([-1.0, 0.0]).tolist() == [0, 0]
    assert MEANS.pressure(0.0, np.array([-1.0, 0.0])).tolist() == [0, 0]


def test_the_depth_under_a_force_is_the_inverse_of_the_force():
    depth = np.array([0.0, 0.3, 1.0, 2.9])
    assert MEANS.depth_at(MEANS.force(depth)) == pytest.approx(depth, abs=1e-12)
    relaxed = MEANS.prony.long_time * MEANS.force(depth)
    assert MEANS.depth_at(relaxed, relaxed=True) == pytest.approx(depth, abs=1e-12)


def test_the_reading_of_b_scales_everything_by_c0():
    soft = pad("means", "instantaneous")
    assert MEANS.force(1.3) / soft.force(1.3) == pytest.approx(1 / MEANS.prony.long_time)
    assert soft.instantaneous_b == soft.b == MEANS.b
    assert MEANS.relaxed_pressure(1.0, 1.3) == pytest.approx(soft.pressure(1.0, 1.3))


def test_under_spheres_the_whole_model_fans_out_more_with_force_than_hertz():
    """Section 3.6 expects so: t grows with the depth, and a sphere reaches deeper."""
    row, spread = pad("f.c.", "relaxed"), []
    for curvature in (1e-9, 80.6e-3, 340e-3, 694e-3):
        finger = replace(row, radius=relative_radius(row.radius, 1 / curvature))
        depth = finger.depth_at([98.1, 196.1], relaxed=True)
        light, heavy = finger.relaxed_pressure(0.0, depth)
        spread.append(heavy / light)
    assert min(spread) > 1.05 * 2 ** (1 / 3)


def test_on_loading_the_printed_integral_and_the_lumped_one_are_right():
    time, depth = np.linspace(0, 0.2, 2001), np.linspace(0, 2.0, 2001)
    history = MEANS.press(time, depth, count=800)
    r = np.array([0.0, 1.0, 3.0])
    printed = pressure_as_printed(MEANS, time, depth, r)
    pressures = history.stress(MEANS.pressure(r, history.nodes[:, None]))
    assert pressures == pytest.approx(printed, abs=2e-3 * printed.max())
    expected = hereditary_integral(MEANS.prony, time, MEANS.force(depth))
    force = history.stress(MEANS.force(history.nodes))
    widest = np.diff(history.nodes).max()  # the force is straight between the nodes
    bend = np.gradient(np.gradient(MEANS.force(history.nodes), history.nodes), history.nodes).max()
    assert widest**2 / 8 * bend < 5e-5 * expected.max()
    assert force == pytest.approx(expected, abs=widest**2 / 8 * bend)


def test_late_in_the_hold_it_is_the_relaxed_pressure():
    time, r = np.array([0.0, 0.02, 100.0]), np.array([0.0, 2.5])
    history = MEANS.press(time, [0.0, 1.5, 1.5], count=2000)
    found = history.stress(MEANS.pressure(r, history.nodes[:, None]))[-1]
    assert found == pytest.approx(MEANS.relaxed_pressure(r, 1.5), rel=1e-6)


@pytest.mark.parametrize(
    ("values", "message"),
    [((0, 1, 1, "relaxed"), "above 0"), ((14, 1, 1, "steady"), "'relaxed' or 'instantaneous'")],
)
def test_what_cannot_be_used_gets_a_sentence(values, message):
    *numbers, reading = values
    with pytest.raises(ValueError, match=message):
        Fingerpad(*numbers, Prony((1.0,), ()), reading)
    with pytest.raises(ValueError, match="force of 0 or more"):
        MEANS.depth_at(-1.0)


# Goodwin's spheres


def test_goodwins_ratios_are_those_of_hertz_contacts_at_fixed_force_and_fixed_depth():
    curvatures = np.array([0.0, 80.6, 172.0, 340.0, 694.0]) * 1e-3  # 1/mm

    def contacts(force):
        radii = [relative_radius(15.0, 1 / c if c else math.inf) for c in (*curvatures, 0.7)]
        depths = [(9 * force**2 / (16 * r * 160.0**2)) ** (1 / 3) for r in radii]
        return [Hertz(r, d, modulus=120.0, poisson=0.5) for r, d in zip(radii, depths, strict=True)]

    limit = contacts(200.0)[-1]
    for curvature, forced in zip(curvatures, contacts(150.0)[:-1], strict=True):
        ratio = forced.peak_pressure / limit.peak_pressure
        assert goodwin.peak_at_force(curvature, 15, reference=(0.7, 20.0)) == pytest.approx(ratio)
        wide = forced.contact_radius / contacts(150.0)[0].contact_radius
        assert goodwin.contact_radius(curvature) == pytest.approx(wide)
        ratio = replace(forced, depth=0.1).peak_pressure / replace(limit, depth=0.1).peak_pressure
        assert goodwin.peak_at_depth(curvature) == pytest.approx(ratio)

"""Impedance of the lumped finger: the printed numbers, limits and the corrected preload."""

import numpy as np
import pytest
from fefinger.validation.oracles import impedance

from fefinger.scene import pawluk1997
from fefinger.theory.lumped.spring import Spring


SUBJECTS = {name: (Spring(row.b, row.m), row.prony) for name, row in pawluk1997.lumped().items()}
MEANS = SUBJECTS["means"]
EVERY = pytest.mark.parametrize(("spring", "prony"), SUBJECTS.values(), ids=SUBJECTS)

PHASES = {1: -78.1, 10: -76.5, 30: -74.0, 37: -74.7, 100: -81.8, 200: -85.6, 1000: -89.1}
MAGNITUDES = {  # N s/m at 30, 100, 200 Hz
    (1.0, True): (9.5, 3.5, 1.8),
    (5.6, True): (49.6, 18.3, 9.4),
    (1.0, False): (34, 12.6, 6.5),
    (5.6, False): (189, 69, 36),
}


@pytest.mark.parametrize(("frequency", "degrees"), PHASES.items())
def test_phase_of_the_relaxation_function(frequency, degrees):
    got = impedance.phase(impedance.relaxation_spectrum(MEANS[1], frequency))
    assert float(got) == pytest.approx(degrees, abs=0.06)


@pytest.mark.parametrize(("case", "expected"), MAGNITUDES.items())
def test_magnitude_with_the_printed_and_the_relaxed_preload(case, expected):
    preload, printed = case
    z = impedance.impedance(*MEANS, [30, 100, 200], preload, printed=printed)
    np.testing.assert_allclose(1e3 * np.abs(z), expected, rtol=0.015)  # two digits are given


@EVERY
def test_slope_is_less_than_20_db_per_decade_until_the_spring_limit(spring, prony):
    """Recomputed: -17.0 to -18.2 from 30 to 200 Hz; -20 is the limit of any G with G(0) = 1."""
    frequency = np.geomspace(30, 200, 50)
    level = impedance.decibel(impedance.relaxation_spectrum(prony, frequency))
    slope = np.polyfit(np.log10(frequency), level, 1)[0]
    assert -18.3 < slope < -17.0
    s = 2 * np.pi * 1e6
    assert abs(impedance.relaxation_spectrum(prony, 1e6)) * s == pytest.approx(1.0, rel=1e-6)


@EVERY
def test_the_fastest_term_breaks_near_37_hz(spring, prony):
    assert 29 <= max(prony.v) / (2 * np.pi) <= 42.1
    assert max(MEANS[1].v) / (2 * np.pi) == pytest.approx(36.8, abs=0.05)


@EVERY
def test_the_spectrum_is_the_laplace_transform_by_quadrature(spring, prony):
    """The integral of (G - c0) e^(-i w t), by trapezoids on a graded grid, plus c0 / i w."""
    t = np.concatenate([[0.0], np.geomspace(1e-7, 60, 400_000)])
    w = 2 * np.pi * 7.0
    decaying = prony.relaxation(t) - prony.long_time
    got = np.trapezoid(decaying * np.exp(-1j * w * t), t) + prony.long_time / (1j * w)
    assert complex(impedance.relaxation_spectrum(prony, 7.0)) == pytest.approx(got, rel=1e-5)


@EVERY
def test_the_printed_stiffness_is_low_by_the_relaxation(spring, prony):
    """Recomputed: 10.7 to 13.2 dB where the preload term rules; equal at no preload."""
    right, printed = (
        impedance.operating_stiffness(spring, prony, [0.0, 1e6], printed=p) for p in (False, True)
    )
    assert right[0] == printed[0] == spring.b
    assert right[1] / printed[1] == pytest.approx(1 / prony.long_time, rel=1e-5)


@EVERY
def test_the_stiffness_is_that_of_the_depth_which_relaxes_to_the_preload(spring, prony):
    depth, step = 1.3, 1e-6
    preload = prony.long_time * float(spring.force(depth))
    slope = np.diff(spring.force([depth - step, depth + step]))[0] / (2 * step)
    got = impedance.operating_stiffness(spring, prony, preload)
    assert float(got) == pytest.approx(slope, rel=1e-7)


@pytest.mark.parametrize("frequency", [0.0, -1.0, float("nan")])
def test_a_frequency_that_is_not_above_zero_is_refused(frequency):
    with pytest.raises(ValueError, match="frequencies > 0 Hz"):
        impedance.relaxation_spectrum(MEANS[1], frequency)


def test_the_relaxed_preload_is_what_is_meant_unless_the_print_is_asked_for():
    spring, prony = MEANS
    for tone in (1.0, 30.0):
        bare = impedance.relaxation_spectrum(prony, tone)
        separate = spring.stiffness(0.5 / prony.long_time) * bare
        assert impedance.impedance(spring, prony, tone, 0.5) == pytest.approx(separate, rel=1e-12)

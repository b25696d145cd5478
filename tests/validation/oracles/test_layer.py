"""The exact layer against recomputed tables, its limits and the published short cuts."""

import math

import numpy as np
import pytest
from fefinger.validation.oracles.layer import Faced, Sheet, paraboloid_at
from oracles.solved_contact import surface_displacement

from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.indentation import flat_punch, paraboloid, spectrum


INCOMPRESSIBLE = Sheet(1.0, modulus=30.0, poisson=0.5)


def against_hertz(sheet, wide, *, radius=1e3):
    """Return chi, P / P_Hertz(depth) and a / sqrt(R depth) at a / h = `wide`."""
    contact = paraboloid(sheet, radius, contact_radius=wide * sheet.thickness)
    half_space = Hertz(radius, contact.depth, modulus=sheet.modulus, poisson=sheet.poisson)
    chi = half_space.contact_radius / sheet.thickness
    return chi, contact.force / half_space.force, wide * sheet.thickness / half_space.contact_radius


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45, 0.5])
def test_the_bonded_kernel_is_the_printed_one(poisson):
    x = np.array([0.05, 0.3, 1.0, 4.0, 12.0])
    kappa = 3 - 4 * poisson
    top = 2 * kappa * np.sinh(2 * x) - 4 * x
    bottom = 2 * kappa * np.cosh(2 * x) + 4 * x**2 + 1 + kappa**2
    sheet = Sheet(2.0, modulus=3.0, poisson=poisson)
    np.testing.assert_allclose(sheet.compliance(x / 2), top / bottom, rtol=1e-11)


def test_the_sliding_kernel_is_the_printed_one():
    x = np.array([0.05, 0.3, 1.0, 4.0, 12.0])
    sheet = Sheet(2.0, modulus=3.0, poisson=0.2, base="sliding")
    printed = (np.cosh(2 * x) - 1) / (np.sinh(2 * x) + 2 * x)
    np.testing.assert_allclose(sheet.compliance(x / 2), printed, rtol=1e-12)


@pytest.mark.parametrize("base", ["bonded", "sliding"])
def test_the_kernel_ends_at_the_half_space_and_begins_as_a_foundation(base):
    """As xi -> 0 a layer is a spring of its oedometric (sliding: plane) modulus over h."""
    sheet = Sheet(2.0, modulus=3.0, poisson=0.3, base=base)
    assert sheet.compliance(np.array([1e3]))[0] == 1.0
    xi = 1e-4
    oedometric = 3.0 * 0.7 / (1.3 * 0.4) if base == "bonded" else 3.0 / 0.91
    deflection = 2 * 0.91 / 3.0 * sheet.compliance(np.array([xi]))[0] / xi
    assert deflection == pytest.approx(2.0 / oedometric, rel=1e-5)


@pytest.mark.parametrize(
    ("poisson", "base", "integral"),
    [
        (0.5, "bonded", 1.7702),
        (0.49, "bonded", 1.7375),
        (0.45, "bonded", 1.6255),
        (0.4, "bonded", 1.5187),
        (0.3, "bonded", 1.3769),
        (0.3, "sliding", 1.1676),
    ],
)
def test_printed_slope_of_a_small_contact(poisson, base, integral):
    sheet = Sheet(2.5, modulus=3.0, poisson=poisson, base=base)
    actual = sheet.thickness * spectrum(sheet, 0.0)[1].sum()
    assert actual == pytest.approx(integral, abs=6e-5)
    chi, ratio, _ = against_hertz(sheet, 1e-3)
    # The next term of the expansion is of the order of chi² = 1e-6.
    assert (ratio - 1) / chi == pytest.approx(2 / math.pi * actual, rel=5e-3)


RECOMPUTED = [
    (0.5, "bonded", 0.2, (0.1851, 1.2698, 1.081)),
    (0.49, "bonded", 0.2, (0.1854, 1.2638, 1.079)),
    (0.45, "bonded", 0.2, (0.1863, 1.2436, 1.073)),
    (0.5, "bonded", 1.0, (0.7479, 3.3711, 1.337)),
    (0.49, "bonded", 1.0, (0.7534, 3.2655, 1.327)),
    (0.45, "bonded", 1.0, (0.7712, 2.9464, 1.297)),
    (0.5, "sliding", 0.2, (0.1901, 1.1669, 1.052)),
    (0.1, "sliding", 1.0, (0.8210, 2.1391, 1.218)),
]


@pytest.mark.parametrize(("poisson", "base", "wide", "printed"), RECOMPUTED)
def test_printed_sphere_on_a_layer(poisson, base, wide, printed):
    """Tolerance: half a digit of the last printed place."""
    chi, ratio, contact = against_hertz(Sheet(2.0, 30.0, poisson, base=base), wide)
    assert (chi, ratio) == pytest.approx(printed[:2], abs=6e-5)
    assert contact == pytest.approx(printed[2], abs=6e-4)


@pytest.mark.parametrize(
    ("wide", "poisson", "kappa"),
    [(0.2, 0.5, 1.281), (1.0, 0.5, 3.619), (0.2, 0.3, 1.207), (1.0, 0.3, 2.484)],
)
def test_hayes_factor_of_a_flat_punch(wide, poisson, kappa):
    """P = 2 E a w kappa / (1 - nu²), Hayes et al. 1972 recomputed."""
    sheet = Sheet(2.0, modulus=30.0, poisson=poisson)
    contact = flat_punch(sheet, 2.0 * wide, depth=0.01)
    half_space = 2 * 30.0 / (1 - poisson**2) * 2.0 * wide * 0.01
    assert contact.force / half_space == pytest.approx(kappa, abs=6e-4)


@pytest.mark.parametrize(
    ("radius", "thickness", "depth", "chi", "ratio"),
    [
        (10, 5, 0.5, 0.45, 1.96),
        (10, 5, 1.0, 0.63, 2.75),
        (10, 5, 2.0, 0.89, 4.32),
        (14, 4, 0.5, None, 2.9),
        (14, 4, 1.0, None, 4.6),
        (14, 4, 2.0, None, 8.2),
    ],
)
def test_printed_stiffening_of_a_finger_over_bone(radius, thickness, depth, chi, ratio):
    sheet = Sheet(float(thickness), modulus=34.0, poisson=0.5)
    contact = paraboloid_at(sheet, float(radius), depth=depth)
    assert contact.depth == pytest.approx(depth, rel=1e-12)
    half_space = Hertz(radius, depth, modulus=34.0, poisson=0.5)
    tolerance = 6e-3 if chi else 6e-2
    assert contact.force / half_space.force == pytest.approx(ratio, abs=tolerance)
    if chi:
        assert half_space.contact_radius / thickness == pytest.approx(chi, abs=6e-3)


@pytest.mark.parametrize(("wide", "ratio"), [(5, 1.46), (10, 1.15), (20, 1.04), (40, 1.01)])
def test_the_thin_limit_is_reached_as_printed(wide, ratio):
    chi, exact, _ = against_hertz(INCOMPRESSIBLE, wide)
    assert exact / (3 * math.pi / 8 * chi**3) == pytest.approx(ratio, abs=6e-3)


def test_the_exact_pressure_tends_to_that_of_lubrication_at_the_first_order():
    """A bonded layer far thinner than its contact: 3 G (a² - r²)² / (32 R h³)."""

    def off(wide):
        exact = paraboloid(INCOMPRESSIBLE, 1e3, contact_radius=wide)
        limit = 3 * 10.0 / (32 * 1e3) * (wide**2 - (wide / 4) ** 2) ** 2
        return float(exact.pressure(wide / 4) / limit) - 1

    coarse, fine = off(40.0), off(80.0)
    assert coarse / fine == pytest.approx(2, abs=0.15)
    assert abs(fine) < 0.09


BALL = (31.0, 540.0)


@pytest.mark.parametrize(
    ("radius", "modulus", "force", "wide"), [(*BALL, 2.34, 4.49), (32.6, 570.0, 2.53, 4.61)]
)
def test_printed_ball_on_a_bonded_cover(radius, modulus, force, wide):
    cover = Faced(Sheet(2.0, 1000.0, 0.5), modulus, 0.5)
    contact = paraboloid_at(cover, radius, depth=0.59)
    assert 1e-3 * contact.force == pytest.approx(force, abs=0.005)
    assert contact.contact_radius == pytest.approx(wide, abs=0.005)


def test_a_rigid_ball_feels_the_sheet_alone_and_a_soft_one_itself():
    sheet = Sheet(2.0, 1000.0, 0.5)
    stiff = paraboloid_at(Faced(sheet, 1e9, 0.3), 31.0, depth=0.1)
    assert stiff.force == pytest.approx(paraboloid_at(sheet, 31.0, depth=0.1).force, rel=1e-5)
    soft = paraboloid_at(Faced(sheet, 1e-3, 0.3), 31.0, depth=0.1)
    alone = Hertz(31.0, 0.1, modulus=1e-3, poisson=0.3)
    assert soft.force == pytest.approx(alone.force, rel=1e-4)


def test_on_a_thick_cover_the_compliances_add_as_in_hertz():
    both = Faced(Sheet(1e4, 1000.0, 0.5), 540.0, 0.4)
    plane = 1 / ((1 - 0.4**2) / 540.0 + 0.75 / 1000.0)
    contact = paraboloid_at(both, 31.0, depth=0.1)
    assert contact.force == pytest.approx(4 / 3 * plane * np.sqrt(31.0) * 0.1**1.5, rel=1e-3)
    # The two surfaces meet: what each sinks under the one pressure fills the gap.
    r = np.array([0.0, 0.5, 1.2])
    np.testing.assert_allclose(surface_displacement(contact, r), 0.1 - r**2 / 62.0, rtol=1e-6)

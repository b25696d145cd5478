"""Repeated viscoelastic contact against boundary elements, Ting's integral, limits and creep.

The boundary elements are rings of constant pressure on a half-space or a bonded layer whose
pressure and gap are not negative in real space; `theory/contact/ting.py` knows no pressure
and no gap.
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk, j0, j1
from threadpoolctl import threadpool_limits

from fefinger.theory.contact.ting import (
    ElasticForce,
    NestedContact,
    press_by_depth,
    press_by_force,
    radius_nodes,
)
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


MEANS_3_1 = Prony(c=(0.31, 0.45, 0.14, 0.09), v=(212, 10.0, 0.64))
MEANS_2_1 = Prony(c=(0.26, 0.41, 0.18, 0.15), v=(231, 15, 0.69))
ELASTIC = Prony(c=(1.0,), v=())
MODULUS, RADIUS = 40.0, 14.0  # instantaneous E* in kPa; mm
TIME = np.linspace(0, 1.2, 401)
KNOTS = [0, 0.1, 0.2, 0.3, 0.45, 0.6, 0.7, 0.9, 1.0, 1.2]
DEPTH = np.interp(TIME, KNOTS, [0, 1.0, 0.4, 0.8, -0.3, -0.3, 0.9, 0.2, 1.1, 0.1])
"""Three loadings, the third after contact was lost."""

RISING, FALLING = np.linspace(0, 0.2, 101), np.linspace(0.2, 0.4, 101)[1:]
ONCE = np.concatenate([RISING, FALLING])
UP_AND_DOWN = 1.0 - np.abs(ONCE - 0.2) / 0.2


def hertz(depth):
    return 4 / 3 * MODULUS * np.sqrt(RADIUS) * depth**1.5


def hertz_pressure(r, depth):
    return 2 * MODULUS / np.pi / RADIUS * np.sqrt(np.maximum(RADIUS * depth - r**2, 0))


@pytest.fixture(autouse=True)
def _one_thread():
    with threadpool_limits(1):  # thousands of small solves
        yield


# The second method


def disc(r, b):
    """Surface displacement at r times E* under unit pressure on a disc of radius b (Johnson)."""
    inside = 4 * b / np.pi * ellipe(np.minimum(r / b, 1.0) ** 2)
    m = np.minimum(b / r, 1.0) ** 2
    outside = 4 * r / np.pi * (ellipe(m) - (1 - m) * ellipk(np.minimum(m, 1 - 1e-15)))
    return np.where(r < b, inside, outside)


def bonded(x):
    """Hankel compliance of an incompressible layer bonded to a rigid base."""
    return (2 * np.sinh(2 * x) - 4 * x) / (2 * np.cosh(2 * x) + 4 * x**2 + 2)


class Rings:
    """Compliance (n, n) of rings of constant pressure, and their middles (n,) and areas (n,)."""

    def __init__(self, reach, count=150, thickness=None):
        edges = np.linspace(0, reach, count + 1)
        self.middle, self.areas = (edges[1:] + edges[:-1]) / 2, np.pi * np.diff(edges**2)
        self.gap = self.middle**2 / 2 / RADIUS
        of_discs = np.stack([disc(self.middle, b) for b in edges[1:]], axis=1)
        if thickness is not None:
            x, weight = np.polynomial.legendre.leggauss(120)
            xi = 7.0 * (x + 1)  # up to 14, where 1 - L is e^-28
            waves = j0(np.outer(self.middle / thickness, xi))
            waves *= 7.0 * weight * (bonded(xi) - 1) / xi
            b = edges[1:] / thickness
            of_discs += 2 * thickness * waves @ (b * j1(np.outer(xi, b)))
        self.compliance = np.diff(of_discs, axis=1, prepend=0.0) / MODULUS

    def press(self, compliance, free):
        """Solve compliance p + free >= 0, p >= 0, one of them zero, by exchange."""
        active = free < 0
        for _ in range(200):
            p = np.zeros(len(free))
            if active.any():
                p[active] = np.linalg.solve(compliance[np.ix_(active, active)], -free[active])
            new = np.where(active, p > 0, compliance @ p + free < -1e-13)
            if (new == active).all():
                return p
            active = new
        pytest.fail("the contact of the rings was not found")

    def march(self, prony, time, depth):
        """Pressure (n_t, n), the integral of G d(elastic pressure)."""
        c, v = np.array(prony.weights), np.array(prony.v)
        q, terms = np.zeros(len(self.gap)), np.zeros((len(v), len(self.gap)))
        pressures, before = [], time[0]
        for now, reach in zip(time, depth, strict=True):
            x = v * (now - before)
            decay = np.exp(-x)
            ramp = np.where(x > 0, (1 - decay) / np.where(x > 0, x, 1), 1.0)
            g = c[0] + c[1:] @ ramp
            past = c[1:] @ (decay[:, None] * terms - np.outer(ramp, q))
            p = self.press(self.compliance / g, self.gap - reach - self.compliance @ past / g)
            terms = decay[:, None] * terms + np.outer(ramp, (p - past) / g - q)
            q, before = (p - past) / g, now
            pressures.append(p)
        return np.array(pressures)


def test_the_rings_alone_give_hertz():
    rings = Rings(4.2)
    p = rings.press(rings.compliance, rings.gap - 0.9)
    assert p @ rings.areas == pytest.approx(hertz(0.9), rel=2e-4)


def test_force_and_pressure_of_three_loadings_equal_the_rings_on_a_half_space():
    rings = Rings(4.5)
    pressure = rings.march(MEANS_3_1, TIME, DEPTH)
    nodes = radius_nodes(DEPTH.max())
    contact = press_by_depth(MEANS_3_1, TIME, DEPTH, nodes)
    force = pressure @ rings.areas
    assert contact.stress(hertz(nodes)) == pytest.approx(force, abs=2e-4 * force.max())
    table = hertz_pressure(rings.middle, nodes[:, None])
    rim = 2 * (rings.middle[1] - rings.middle[0])  # a ring is in contact as a whole or not
    inside = rings.middle < np.sqrt(RADIUS * contact.edge)[:, None] - rim
    error = np.abs(contact.stress(table) - pressure)
    assert error[inside].max() < 0.02 * pressure.max()
    touching = pressure @ rings.areas > 0
    radius = np.sqrt((pressure > 0) @ rings.areas / np.pi)
    assert np.sqrt(RADIUS * contact.edge)[touching] == pytest.approx(radius[touching], abs=rim)
    assert 0.2 < touching.mean() < 0.9  # contact is lost and found again


def test_force_of_three_loadings_equals_the_rings_on_a_bonded_layer():
    rings = Rings(6.0, thickness=4.0)
    nodes = radius_nodes(DEPTH.max(), 60)
    elastic = np.array([rings.press(rings.compliance, rings.gap - d) @ rings.areas for d in nodes])
    assert elastic[-1] > 2 * hertz(DEPTH.max())  # the base is felt
    force = rings.march(MEANS_3_1, TIME, DEPTH) @ rings.areas
    contact = press_by_depth(MEANS_3_1, TIME, DEPTH, nodes)
    assert contact.stress(elastic) == pytest.approx(force, abs=2e-3 * force.max())


# Exact limits


@pytest.mark.parametrize("prony", [MEANS_3_1, MEANS_2_1], ids=["t31", "t21"])
def test_one_unloading_is_the_integral_of_ting_up_to_t1(prony):
    """Straight legs: the memory of contact is cut at t1, where the integral of G d(depth) is 0."""
    contact = press_by_depth(prony, ONCE, UP_AND_DOWN, radius_nodes(1.0, 400))
    force = contact.stress(hertz(contact.nodes))
    lost = 0
    rate = 1.5 * hertz(1.0) / 0.2**1.5
    for i in range(105, len(ONCE), 5):
        t = ONCE[i]
        if _pull(prony, 0.0, t) <= 0:
            assert (contact.edge[i], force[i]) == (0, 0)
            lost += 1
            continue
        t1 = brentq(lambda start, t=t: _pull(prony, start, t), 0.0, 0.2)
        want, _ = quad(lambda s, t=t: prony.relaxation(t - s) * rate * np.sqrt(s), 0, t1)
        assert contact.edge[i] == pytest.approx(t1 / 0.2, abs=1e-4)
        assert force[i] == pytest.approx(want, abs=1e-4 * force.max())
    assert lost >= 3


def _pull(prony, start, now):
    """Integral of G(now - s) d depth(s) from `start`: up until 0.2 s, down from there."""
    x, weight = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for sign, low, high in ((1, start, 0.2), (-1, 0.2, now)):
        s = low + (high - low) / 2 * (x + 1)
        total += sign * (high - low) / 2 * weight @ prony.relaxation(now - s)
    return total


def test_loading_and_hold_equal_the_hereditary_integral_of_the_elastic_force():
    depth = np.interp(TIME, [0, 0.2, 0.5, 0.6, 1.2], [0, 0.7, 0.7, 1.0, 1.0])
    nodes = np.unique(depth)
    contact = press_by_depth(MEANS_3_1, TIME, depth, nodes)
    want = hereditary_integral(MEANS_3_1, TIME, hertz(depth))
    assert contact.stress(hertz(nodes)) == pytest.approx(want, rel=1e-12, abs=1e-12)
    assert contact.strain(nodes) == pytest.approx(depth, abs=1e-12)
    assert contact.edge == pytest.approx(depth, abs=1e-12)


def test_an_elastic_body_has_no_memory():
    contact = press_by_depth(ELASTIC, TIME, DEPTH, radius_nodes(DEPTH.max()))
    want = hertz(np.maximum(DEPTH, 0))
    assert contact.stress(hertz(contact.nodes)) == pytest.approx(want, abs=2e-5 * want.max())
    off = DEPTH <= 0
    assert np.abs(contact.strained[off]).max() < 1e-12


def test_after_contact_nothing_pulls_and_the_dent_recovers():
    contact = press_by_depth(MEANS_3_1, TIME, DEPTH, radius_nodes(DEPTH.max()))
    assert contact.stressed.min() == 0
    assert (np.diff(contact.stressed, axis=1) <= 1e-9).all()  # nested: the middle touches most
    away = (TIME >= 0.46) & (TIME <= 0.6)
    dent = contact.strained[away, 0]
    assert (np.diff(dent) < 0).all()
    assert dent[-1] > 0.05


def test_the_step_converges_with_second_order():
    forces = []
    for count in (41, 81, 161, 1281):
        time = np.linspace(0, 0.4, count)
        depth = np.interp(time, [0, 0.2, 0.3, 0.4], [0, 1.0, 0.5, 0.8])
        contact = press_by_depth(MEANS_3_1, time, depth, radius_nodes(1.0, 2000))
        forces.append(float(contact.stress(hertz(contact.nodes))[-1]))
    errors = np.abs(np.array(forces[:-1]) - forces[-1]) / forces[-1]
    assert errors[2] < errors[1] / 3 < errors[0] / 9 < 1e-3


# Force control


def test_depth_control_of_the_depth_under_force_returns_the_force():
    nodes = radius_nodes(2.0)
    force = 60 * np.sin(9 * TIME) ** 2 * (1 + TIME)
    pushed = press_by_force(MEANS_3_1, TIME, force, ElasticForce(nodes, hertz(nodes)))
    moved = press_by_depth(MEANS_3_1, TIME, pushed.depth, nodes)
    assert moved.stress(hertz(nodes)) == pytest.approx(force, abs=1e-9 * force.max())


@pytest.mark.parametrize(
    ("prony", "ratios"),
    [
        (MEANS_3_1, (1.112, 1.262, 1.374, 1.463, 1.473)),
        (MEANS_2_1, (1.109, 1.255, 1.388, 1.544, 1.567)),
    ],
    ids=["t31", "t21"],
)
def test_the_contact_radius_creeps_as_the_reference_says(prony, ratios):
    """Independent values to three decimals, of the Prony inversion and J^(1/3)."""
    requested = [0, 5e-3, 0.05, 0.5, 5.0, 200.0]
    time = np.unique(np.concatenate([requested, np.geomspace(1e-5, 200, 2000)]))
    nodes = radius_nodes(2.0, 500)
    contact = press_by_force(
        prony, time, np.full(len(time), 40.0), ElasticForce(nodes, hertz(nodes))
    )
    radius = np.sqrt(contact.edge[np.searchsorted(time, requested)])
    assert radius[1:] / radius[0] == pytest.approx(ratios, abs=1e-3)
    elastic = creep_integral(prony, time, np.full(len(time), 40.0))
    by_inversion = np.cbrt(elastic[np.searchsorted(time, requested)] / elastic[0])
    assert by_inversion[1:] == pytest.approx(ratios, abs=5.1e-4)


def test_creep_undoes_relaxation():
    signal = np.sin(3 * TIME) + 0.5
    fine = np.linspace(0, 1.2, 20001)
    again = creep_integral(
        MEANS_3_1, fine, hereditary_integral(MEANS_3_1, fine, np.interp(fine, TIME, signal))
    )
    assert again == pytest.approx(np.interp(fine, TIME, signal), abs=1e-6)
    assert creep_integral(ELASTIC, TIME, signal) == pytest.approx(signal)


# Bodies that stiffen

NODES = radius_nodes(2.0)
LAWS = {
    "linear": NODES,
    "Hertz": hertz(NODES),
    "exponential": np.expm1(2.1 * NODES) / 2.1,
    "unresolved touch": np.maximum(NODES - 0.05, 0.0) ** 1.5,
    "softening": np.sqrt(1 + NODES) - 1,
}
MEASURES = {"linear": NODES, "stiffening": NODES * np.exp(NODES)}
HERTZ = ElasticForce(NODES, hertz(NODES))


@pytest.fixture(params=LAWS)
def force(request):
    return LAWS[request.param]


@pytest.fixture(params=MEASURES)
def measure(request):
    return MEASURES[request.param]


def test_on_loading_and_hold_a_stiffening_body_relaxes_as_a_whole(force, measure):
    time = np.concatenate([np.linspace(0, 0.75, 601), np.geomspace(0.76, 20, 50)])
    depth = np.minimum(2 * time, 1.5)
    contact = press_by_depth(MEANS_3_1, time, depth, NODES, measure)
    want = hereditary_integral(MEANS_3_1, time, np.interp(depth, NODES, force))
    assert contact.stress(force) == pytest.approx(want, abs=1e-4 * want.max())
    assert contact.strain(NODES) == pytest.approx(depth, abs=1e-12)
    assert contact.edge == pytest.approx(depth, abs=2e-3)  # nodes are up to 0.02 mm apart


def test_a_stiffening_body_without_relaxation_has_no_memory(force, measure):
    time = np.linspace(0, 1, 101)
    depth = 1.5 * np.sin(np.pi * time)
    contact = press_by_depth(ELASTIC, time, depth, NODES, measure)
    want = np.interp(depth, NODES, force)
    assert contact.stress(force) == pytest.approx(want, abs=1e-3 * want.max())
    assert contact.strain(NODES) == pytest.approx(depth, abs=1e-12)
    assert contact.edge == pytest.approx(depth, abs=1e-9)


BAR = 0.5 * np.linspace(0.0, 1.0, 201)
STRETCH = 1 - BAR
PULLED = 1 - STRETCH**-3  # second Piola-Kirchhoff stress, neo-Hookean and incompressible
BAR_FORCE = ElasticForce(BAR, -STRETCH * PULLED, BAR * np.exp(BAR), STRETCH / STRETCH[:, None])
"""Elastic force of a bar that is pushed: the stress S of a stretch works on another one as K = S
stretch, which is closed forms of all that it does."""


def test_a_bar_at_finite_strain_bears_its_stretch_times_its_relaxing_stress():
    time = np.concatenate([np.linspace(0, 0.2, 2001), np.geomspace(0.21, 20, 50)])
    depth = np.minimum(2 * time, 0.4)
    contact = press_by_depth(MEANS_3_1, time, depth, BAR, BAR_FORCE.measure)
    stress = hereditary_integral(MEANS_3_1, time, 1 - (1 - depth) ** -3)
    exact = -(1 - depth) * stress
    found = BAR_FORCE.along(contact.stress_weights, contact.depth)
    assert found == pytest.approx(exact, abs=1e-4 * exact.max())
    # Without the work ratio the force relaxes as one, which is less.
    assert contact.stress(BAR_FORCE.values)[:2001].min() >= 0
    assert (exact - contact.stress(BAR_FORCE.values)).max() > 0.02 * exact.max()


def test_of_small_motions_about_a_preload_the_stress_at_rest_does_not_relax():
    """K(a, d) = a^(1 + s) d^-s: the stiffness of the material is 1 + s, that of the stress -s."""
    share, preload, swing = 0.15, 1.0, 0.01
    nodes = radius_nodes(1.1, 400)
    rising = np.maximum(nodes, 1e-9)
    elastic = ElasticForce(nodes, nodes, work=(rising[:, None] / rising) ** share)
    time = np.concatenate([np.linspace(0, 50, 50, endpoint=False), np.linspace(50, 52, 4001)])
    depth = np.minimum(time, preload) + swing * np.sin(10 * np.pi * np.maximum(time - 50, 0))
    contact = press_by_depth(MEANS_3_1, time, depth, nodes)
    found = elastic.along(contact.stress_weights, depth) - MEANS_3_1.long_time * preload
    relaxing = hereditary_integral(MEANS_3_1, time, depth - np.minimum(time, preload))
    exact = (1 + share) * relaxing - share * MEANS_3_1.long_time * (depth - preload)
    later = time > 51
    assert found[later] == pytest.approx(exact[later], abs=0.02 * np.abs(exact[later]).max())


def test_a_bar_without_relaxation_bears_its_elastic_force_on_the_way_back_too():
    time = np.linspace(0, 1, 101)
    depth = 0.4 * np.sin(np.pi * time)
    contact = press_by_depth(ELASTIC, time, depth, BAR, BAR_FORCE.measure)
    found = BAR_FORCE.along(contact.stress_weights, contact.depth)
    exact = (1 - depth) ** -2 - (1 - depth)
    assert found == pytest.approx(exact, abs=1e-4 * exact.max())


def test_the_depth_of_a_bar_under_a_force_gives_that_force():
    time = np.linspace(0, 3, 601)
    depth = 0.2 - 0.15 * np.cos(2 * np.pi * time) - 0.05 * np.exp(-20 * time)
    moved = press_by_depth(MEANS_3_1, time, depth, BAR, BAR_FORCE.measure)
    borne = BAR_FORCE.along(moved.stress_weights, moved.depth)
    assert (borne >= 0).all()
    pushed = press_by_force(MEANS_3_1, time, borne, BAR_FORCE)
    touching = borne > 1e-9 * borne.max()
    assert touching.mean() > 0.5
    assert pushed.depth[touching] == pytest.approx(depth[touching], abs=1e-6)


@pytest.mark.parametrize("light", [1e-10, 1e-14, 1e-20])
def test_a_light_force_is_borne_where_tissue_recovers(light):
    time = np.linspace(0, 1, 101)
    load = np.where(time < 0.3, 0.5, light)
    contact = press_by_force(MEANS_3_1, time, load, BAR_FORCE)
    free = press_by_force(MEANS_3_1, time, np.where(time < 0.3, load, 0.0), BAR_FORCE)
    found = BAR_FORCE.along(contact.stress_weights, contact.depth)
    assert found == pytest.approx(load, abs=1e-12)
    assert contact.depth == pytest.approx(free.depth, abs=1e-4)


def test_the_depth_under_a_force_gives_that_force(force, measure):
    time = np.linspace(0, 3, 201)
    depth = 0.9 - 0.5 * np.cos(2 * np.pi * time) - 0.4 * np.exp(-20 * time)
    moved = press_by_depth(MEANS_3_1, time, depth, NODES, measure)
    borne = moved.stress(force)
    pushed = press_by_force(MEANS_3_1, time, borne, ElasticForce(NODES, force, measure))
    touching = borne > 1e-9 * borne.max()
    assert touching.mean() > 0.5
    assert pushed.stress(force) == pytest.approx(borne, abs=1e-9 * borne.max())
    assert pushed.depth[touching] == pytest.approx(depth[touching], abs=1e-6)


def test_with_its_force_for_a_measure_a_body_is_one_spring(force):
    """Its force follows Pawluk (1997), Eq. 2.3, as long as it does not pull."""
    time = np.linspace(0, 0.6, 1201)
    depth = np.interp(time, [0, 0.2, 0.3, 0.45, 0.6], [0, 1.2, 1.2, 0.9, 1.4])
    rising = force + 1e-9 * NODES  # a measure rises from the first node on
    contact = press_by_depth(MEANS_3_1, time, depth, NODES, rising)
    want = hereditary_integral(MEANS_3_1, time, np.interp(depth, NODES, force))
    assert want.min() >= 0
    assert contact.stress(force) == pytest.approx(want, abs=1e-6 * want.max())


def test_free_of_contact_the_middle_recovers_in_the_measure(measure):
    """Free, the integral of G dM is zero there: M recovers as the strain of a linear body."""
    time = np.concatenate([np.linspace(0, 0.2, 2001), np.geomspace(0.2001, 5, 400)])
    depth = np.where(time <= 0.2, 5 * time, -1.0)
    contact = press_by_depth(MEANS_3_1, time, depth, NODES, measure)
    linear = press_by_depth(MEANS_3_1, time, np.interp(depth, NODES, measure), measure)
    free = time > 0.21
    middle = np.interp(contact.strain(NODES), NODES, measure)
    assert contact.stress(NODES)[free].max() == 0
    assert middle[free] == pytest.approx(linear.strain(measure)[free], abs=1e-9)
    assert (np.diff(contact.strain(NODES)[free]) < 0).all()


def test_without_force_an_indenter_just_touches_what_recovers(force, measure):
    time = np.concatenate([np.linspace(0, 0.2, 101), np.geomspace(0.201, 5, 60)])
    load = np.interp(time, [0.0, 0.1, 0.2], [0.0, 0.5, 0.0]) * force[-1] / 2
    contact = press_by_force(MEANS_3_1, time, load, ElasticForce(NODES, force, measure))
    rest = time >= 0.2
    assert contact.depth[0] == 0
    assert (contact.edge[rest] == 0).all()
    assert (contact.stressed[rest] == 0).all()
    assert (np.diff(contact.depth[rest]) <= 1e-12).all()
    assert contact.depth[rest][0] > 0
    assert contact.strain(NODES)[rest] == pytest.approx(contact.depth[rest], abs=1e-9)


def test_a_step_that_is_refused_moves_nothing_and_a_reset_forgets():
    contact = NestedContact(MEANS_3_1, NODES, deepest=0.5)
    contact.advance_force(0.1, 0.3 * hertz(0.5), HERTZ)
    before = contact.depth, contact.stressed.tolist(), contact.strained.tolist()
    for refused in (
        lambda: contact.advance(0.1, 0.51),
        lambda: contact.advance_force(0.1, 2 * hertz(0.5), HERTZ),
    ):
        with pytest.raises(ValueError, match=r"expected at most .*0\.5 mm"):
            refused()
        # exact: left as it was
        assert (contact.depth, contact.stressed.tolist(), contact.strained.tolist()) == before
    contact.advance(0.1, 0.5)
    contact.reset()
    assert (contact.depth, contact.edge, contact.strained.any()) == (0.0, 0.0, False)


BAD = [
    (
        lambda: press_by_depth(ELASTIC, [0, 1], [0, 2], radius_nodes(1.0)),
        "at most 1 mm, received 2",
    ),
    (lambda: press_by_depth(ELASTIC, [0, 1], [0], radius_nodes(1.0)), r"signal \(n_t,\), received"),
    (lambda: press_by_depth(ELASTIC, [1, 0], [0, 1], radius_nodes(1.0)), "never decrease"),
    (lambda: press_by_depth(ELASTIC, [0, 1], [0, 1], np.array([0.5, 1])), "start at 0"),
    (lambda: press_by_force(ELASTIC, [0], [-1], HERTZ), "cannot pull"),
    (
        lambda: press_by_force(ELASTIC, [0], [1], ElasticForce(NODES, np.sin(NODES))),
        "0 at first and then rises",
    ),
    (lambda: NestedContact(ELASTIC, NODES, NODES + 0.1), "measure: expected 257 depths"),
    (lambda: NestedContact(ELASTIC, NODES, NODES[:-1]), "measure: expected 257 depths"),
    (lambda: NestedContact(ELASTIC, NODES).advance(0.1, 2.5), "depth: expected at most 2 mm"),
    (
        lambda: NestedContact(ELASTIC, NODES).advance_force(0.1, 1e6, HERTZ),
        r"force: expected at most .*, that of the largest depth, 2 mm",
    ),
    (
        lambda: press_by_depth(ELASTIC, [0, 1], [0, 1], radius_nodes(1.0)).stress([1, 2]),
        "257 values at the nodes",
    ),
]


@pytest.mark.parametrize(("call", "message"), BAD)
def test_what_cannot_be_used_gets_a_sentence(call, message):
    with pytest.raises(ValueError, match=message):
        call()

"""Soft objects: their flexibility by exact integrals, and the contact of two elastic bodies."""

from functools import cache

import numpy as np
import pytest
from fefinger.validation.fem import hertz as block
from fefinger.validation.problems.quarter import Exact, half_space

from fefinger.contact.active_set import DONE
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.elastic_kernel import Facets, Kernel, flexibility, moved_points, one_sided
from fefinger.contact.frictionless import FrictionlessContact, energy
from fefinger.contact.soft import NONE, SoftContact, SoftObject
from fefinger.contact.stepper import Target
from fefinger.fem.contact.patch import trace_of
from fefinger.fem.elements.assembly import Elastic
from fefinger.theory.contact import indentation, ting
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.stack import Layer, Stack, moment
from fefinger.theory.relaxation import ELASTIC, Prony, in_series


HALF_SPACE = Stack((Layer(np.inf, 80.0, 0.4),))
LAYERS = [Stack((Layer(0.7, 80.0, nu),)) for nu in (0.0, 0.3, 0.5)]
QUARTERS = np.array([[x, y, 1.0] for x in (1.0, -1.0) for y in (1.0, -1.0)])


def kernel(body: Stack) -> Kernel:
    return Kernel(*moment(body))


@cache
def disc(size: float, count: int) -> Facets:
    """Facets of a square of half a side `size` mm, cut into 2 (2 count)² triangles."""
    axis = np.linspace(-size, size, 2 * count + 1)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    number = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (
        each.ravel()
        for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    triangles = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    corners = points[triangles]
    # Dunavant's rule of degree 5.
    low, high = (6 - np.sqrt(15)) / 21, (6 + np.sqrt(15)) / 21
    rows = [[1 / 3] * 3]
    for each in (low, high):
        rows += [[1 - 2 * each if i == j else each for j in range(3)] for i in range(3)]
    weights = np.array(
        [0.225] + [(155 - np.sqrt(15)) / 1200] * 3 + [(155 + np.sqrt(15)) / 1200] * 3
    )
    linear = np.array(rows)
    areas = (size / count) ** 2 / 2
    hats = np.broadcast_to(areas * (weights[:, None] * linear).T, (len(triangles), 3, 7))
    places = np.einsum("qi,tid->tqd", linear, corners)
    return Facets(corners, triangles.astype(np.int64), places, np.array(hats))


def weighted(skin: Facets, function) -> np.ndarray:
    """Return the integrals (n,) of a function (...,) of the places times each hat."""
    out = np.zeros(skin.owner.max() + 1)
    np.add.at(out, skin.owner, np.einsum("tiq,tq->ti", skin.hats, function(skin.places)))
    return out


def bowl(radius: float):
    return lambda at: (at[..., 0] ** 2 + at[..., 1] ** 2) / (2 * radius)


@cache
def pressed(body: Stack, radius: float, depth: float, count: int) -> float:
    """Force in mN of a rigid bowl on a soft body, on a square wider than the contact."""
    skin = disc(0.75, count)
    matrix = flexibility(kernel(body), skin, skin.owner.max() + 1)
    area = weighted(skin, lambda at: np.ones(at.shape[:-1]))
    pressure = Complementarity(matrix).solve(weighted(skin, bowl(radius)) - depth * area)
    return float(area @ pressure)


def wilton(corners: np.ndarray, x: np.ndarray) -> float:
    """Integral of 1 / |x - y| over a triangle (Wilton et al., IEEE Trans. AP 32:276, 1984)."""
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    z = (x - corners[0]) @ normal
    total = 0.0
    for a, b in ((0, 1), (1, 2), (2, 0)):
        along = (corners[b] - corners[a]) / np.linalg.norm(corners[b] - corners[a])
        out = np.cross(along, normal)
        d, s, e = (corners[a] - x) @ out, (corners[a] - x) @ along, (corners[b] - x) @ along
        low, high = np.sqrt(d**2 + z**2 + s**2), np.sqrt(d**2 + z**2 + e**2)
        square = d**2 + z**2
        total += d * np.log((high + e) / (low + s))
        total -= abs(z) * (
            np.arctan2(d * e, square + abs(z) * high) - np.arctan2(d * s, square + abs(z) * low)
        )
    return total


@pytest.mark.parametrize("height", [0.0, 0.02, 0.3])
def test_a_pressure_on_a_facet_moves_a_half_space_as_in_closed_form(height: float) -> None:
    corners = np.array([[[0.0, 0.0, 0.0], [0.4, 0.05, 0.0], [0.1, 0.5, 0.0]]])
    skin = Facets(corners, np.array([[0, 1, 2]]), corners, np.ones((1, 3, 3)))
    plane = np.array(
        [[0.15, 0.2], [0.05, 0.02], [0.3, 0.4], [-0.3, 0.1], [0.1, 0.501], [3.0, -2.0]]
    )
    points = np.column_stack([plane, np.full(len(plane), height)])
    found = moved_points(kernel(HALF_SPACE), skin, points, 3).sum(axis=1)
    unit = (1 - 0.4**2) / (np.pi * 80.0)
    assert found == pytest.approx([unit * wilton(corners[0], x) for x in points], rel=2e-5)


@pytest.mark.parametrize("body", LAYERS)
def test_a_wide_pressure_moves_a_layer_as_a_column_or_not_at_all(body: Stack) -> None:
    """Far from its edge: confined compression, which an incompressible layer does not allow."""
    layer = body.layers[0]
    skin = disc(16.0, 16)
    middle = moved_points(kernel(body), skin, np.zeros((1, 3)), skin.owner.max() + 1).sum()
    nu = layer.poisson
    column = layer.thickness / layer.modulus * (1 + nu) * (1 - 2 * nu) / (1 - nu)
    assert middle == pytest.approx(column, rel=1e-4, abs=1e-4 * layer.thickness / layer.modulus)


@pytest.mark.parametrize(("radius", "depth"), [(5.0, 0.05), (15.0, 0.016)])
def test_a_rigid_bowl_on_a_soft_half_space_is_hertz(radius: float, depth: float) -> None:
    truth = Hertz(radius, depth, 80.0, 0.4)
    assert pressed(HALF_SPACE, radius, depth, 8) == pytest.approx(truth.force, rel=0.01)


@pytest.mark.parametrize("body", LAYERS)
def test_a_rigid_bowl_on_a_soft_layer_is_the_exact_contact(body: Stack) -> None:
    exact = indentation.paraboloid(body, 5.0, contact_radius=0.6)
    assert pressed(body, 5.0, exact.depth, 8) == pytest.approx(exact.force, rel=0.015)


def test_the_flexibility_is_reciprocal_definite_and_converges() -> None:
    """The defect of symmetry is the error of the quadrature; energies tend to the closed form.

    Of a pressure exp(-r² / 2 s²) it is pi^1.5 (1 - nu²) s³ / E.
    """
    width, errors, defects = 0.25, [], []
    exact = np.pi**1.5 * (1 - 0.4**2) * width**3 / 80.0
    for count in (3, 6):
        skin = disc(1.0, count)
        n = skin.owner.max() + 1
        single = one_sided(kernel(HALF_SPACE), skin, n)
        matrix = flexibility(kernel(HALF_SPACE), skin, n)
        defects.append(np.abs(single - single.T).max() / np.abs(single).max())
        assert np.linalg.eigvalsh(matrix).min() > 0
        pressure = np.zeros(n)
        pressure[skin.owner] = np.exp(-(skin.corners**2).sum(axis=2) / (2 * width**2))
        errors.append(abs(pressure @ matrix @ pressure / 2 / exact - 1))
    assert max(defects) < 2e-3
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 0.04  # of a pressure that is linear over a cell of 2/3 of its width


@cache
def two_bodies() -> tuple:
    """Return the finite-element block of `validation.fem.hertz` under a soft bowl, and Hertz."""
    own, poisson = Stack((Layer(np.inf, 60.0, 0.45),)), 0.49
    single = block.MODULUS / (1 - poisson**2)
    both = 1 / (1 / single + (1 - 0.45**2) / 60.0)
    depth = block.hertz(poisson).depth
    # The block is under the pressure of a rigid bowl of another radius, pressed less deep.
    alone = Hertz(block.RADIUS * single / both, depth * both / single, block.MODULUS, poisson)
    space = block.LEVELS[1].space(block.CONTACT_RADIUS)
    elastic, exact = Elastic(block.MODULUS, poisson), block.exact(alone)
    assert alone.contact_radius == pytest.approx(block.CONTACT_RADIUS)
    exact = Exact(depth, alone.force, exact.axes, exact.pressure)
    quarter = half_space(space, elastic, block.bowl(block.RADIUS), exact, spread=1.3)
    part, owner = trace_of(space, quarter.patch)
    skin = Facets(space.points[part.triangles], owner, part.places, part.hats)
    matrix = flexibility(kernel(own), skin, len(quarter.patch.vertices), QUARTERS)
    free = quarter.patch.gap + quarter.patch.loads.T @ quarter.unloaded
    return quarter, matrix, free, depth, alone.force


def test_two_elastic_bodies_are_hertz_on_the_block() -> None:
    quarter, own, free, depth, force = two_bodies()
    area = quarter.patch.projected
    pressure = Complementarity(quarter.flexibility + own).solve(free - depth * area)
    assert 4 * area @ pressure == pytest.approx(force, rel=0.01)
    rigid = Complementarity(quarter.flexibility).solve(free - depth * area)
    assert 4 * area @ rigid > 2 * force  # so that the soft object counts


BRANCHES = np.array([0.8, 0.5]), np.array([30.0, 2.0])
PATH = 0.002 * np.array([0.2, 0.5, 0.9, 1.0, 1.0, 0.7, 0.3, 0.0, 0.4])


def contact(own: np.ndarray | None, skin=BRANCHES, branches=NONE) -> FrictionlessContact:
    quarter, _, _, _, _ = two_bodies()
    parts = quarter.flexibility, quarter.patch.gap, quarter.patch.projected, skin
    if own is None:
        return FrictionlessContact(*parts)
    return SoftObject(own, own, branches).frictionless(*parts)


def steps(made: FrictionlessContact, targets: list[Target], dt: float = 0.01) -> np.ndarray:
    forces = []
    for target in targets:
        assert made.advance(dt, target) == DONE
        forces.append(made.projected @ made.pressure)
    return np.array(forces)


DEPTHS = [Target(depth) for depth in PATH.tolist()]
HELD = [Target(0.05, by_force=True), Target(0.02, by_force=True), Target(0.0, by_force=True)]


def test_a_hard_object_is_the_rigid_one() -> None:
    _, own, *_ = two_bodies()
    for targets in (DEPTHS, HELD):
        rigid, hard = contact(None), contact(own * 1e-12)
        assert steps(hard, targets) == pytest.approx(steps(rigid, targets), rel=1e-9, abs=1e-12)
        assert hard.depth == pytest.approx(rigid.depth, rel=1e-9)


def test_the_force_of_a_very_soft_object_is_its_modulus_times_that_of_rigid_skin() -> None:
    """And does not relax: nothing of the skin moves."""
    quarter, own, *_ = two_bodies()
    made = contact(own * 1e7)
    gap, area = quarter.patch.gap, quarter.patch.projected
    alone = area @ Complementarity(own).solve(gap - 0.002 * area) / 1e7
    assert steps(made, [Target(0.002)] * 3, 1.0) == pytest.approx([alone] * 3, rel=1e-5)


def test_the_displacements_of_both_bodies_add_up_to_the_approach() -> None:
    quarter, own, *_ = two_bodies()
    made = contact(own)
    for target in (*DEPTHS[:6], HELD[0]):
        steps(made, [target])
        gap = quarter.patch.gap - made.depth * made.projected
        apart = gap + quarter.flexibility @ made.elastic + own @ made.pressure
        scale = np.abs(gap).max()
        assert np.abs(apart[made.pressure > 0]).max() < 1e-9 * scale
        assert apart.min() > -1e-9 * scale
        assert (made.pressure > 0).any()


OWN = np.array([1.5]), np.array([8.0])


def test_two_bodies_that_relax_alike_are_one_that_does() -> None:
    quarter, own, *_ = two_bodies()
    made = contact(own, OWN, OWN)
    rest = quarter.patch.gap, quarter.patch.projected, OWN
    one = FrictionlessContact(quarter.flexibility + own, *rest)
    for targets in (DEPTHS, HELD):
        assert steps(made, targets) == pytest.approx(steps(one, targets), rel=1e-9, abs=1e-12)
        assert made.depth == pytest.approx(one.depth, rel=1e-9)
        assert made.elastic == pytest.approx(one.elastic, rel=1e-9, abs=1e-9)


def test_terms_without_weight_are_those_of_an_elastic_object() -> None:
    _, own, *_ = two_bodies()
    elastic, none = contact(own), contact(own, branches=(np.zeros(1), np.ones(1)))
    for targets in (DEPTHS, HELD):
        assert steps(none, targets) == pytest.approx(steps(elastic, targets), rel=1e-12)


def test_an_object_that_relaxes_closes_its_gap_and_is_restored() -> None:
    quarter, own, *_ = two_bodies()
    object_, made = SoftObject(own, own, OWN), contact(own, branches=OWN)
    kept, pressures, time = made.state(), [np.zeros_like(made.pressure)], [0.0]
    for target in (*DEPTHS[:6], HELD[0]):
        steps(made, [target])
        pressures.append(made.pressure.copy())
        time.append(time[-1] + 0.01)
        receded = object_.recession(np.array(time), np.array(pressures))[-1]
        gap = quarter.patch.gap - made.depth * made.projected
        apart = gap + quarter.flexibility @ made.elastic + receded
        scale = np.abs(gap).max()
        assert np.abs(apart[made.pressure > 0]).max() < 1e-9 * scale
        assert apart.min() > -1e-9 * scale
    made.restore(kept)
    steps(made, [*DEPTHS[:6], HELD[0]])
    assert made.pressure == pytest.approx(pressures[-1], rel=1e-11)
    still = own @ pressures[-1]
    assert np.abs(receded).max() < 0.8 * np.abs(still).max()  # it has not relaxed all


@pytest.mark.parametrize("branches", [NONE, OWN])
def test_work_is_stored_in_both_bodies_or_lost_in_what_relaxes(branches) -> None:
    _, own, *_ = two_bodies()
    made, count = contact(own, branches=branches), 400
    depth = 0.002 * np.sin(np.linspace(0, np.pi, count + 1)[1:] * 0.8)
    work, before, last, lost = 0.0, 0.0, 0.0, [made.energy()[1]]
    for value in depth.tolist():
        force = steps(made, [Target(value)], 1e-3)[0]
        work += (force + before) / 2 * (value - last)
        before, last = force, value
        lost.append(made.energy()[1])
    stored = made.energy()[0]
    dissipated = 1e-3 * float(np.sum((np.array(lost)[1:] + np.array(lost)[:-1]) / 2))
    assert dissipated > 0.1 * work
    assert stored + dissipated == pytest.approx(work, rel=2e-3)
    assert energy(made.body, own)[0] > 0.1 * stored


def test_a_state_is_restored_and_a_slope_fits_differences() -> None:
    """Taylor test: a force is found by Newton's method, whose slope is that of both bodies."""
    _, own, *_ = two_bodies()
    made = contact(own)
    steps(made, DEPTHS[:4])
    kept = made.state()
    first = steps(made, DEPTHS[4:])
    made.restore(kept)
    assert steps(made, DEPTHS[4:]) == pytest.approx(first, rel=1e-11)
    made.restore(kept)
    force = steps(made, [Target(0.0021)])[0]
    made.restore(kept)
    solved = made.lcp.counts[1]
    steps(made, [Target(force, by_force=True)])
    assert made.depth == pytest.approx(0.0021, rel=1e-7)
    assert made.lcp.counts[1] - solved <= 8
    made.reset()
    assert not made.pressure.any()
    assert not made.elastic.any()


def test_the_stiffening_of_the_skin_is_of_the_skin_alone() -> None:
    quarter, own, *_ = two_bodies()
    made = contact(own)
    assert isinstance(made, SoftContact)
    made.stiffening = 3.0
    made.advance(0.01, Target(0.002))
    q = made.elastic / 3.0
    gap = quarter.patch.gap - 0.002 * made.projected
    apart = gap + quarter.flexibility @ q + own @ made.pressure
    assert np.abs(apart[made.pressure > 0]).max() < 1e-9 * np.abs(gap).max()


SKIN, BODY = Prony((0.4, 0.35, 0.25), (20.0, 1.5)), Prony((0.3, 0.7), (6.0,))


@cache
def of_a_half_space() -> tuple[float, np.ndarray]:
    """Return a plane-strain modulus in kPa, and the flexibility on the square of `pressed`."""
    body, facets = Stack((Layer(np.inf, 30.0, 0.5),)), disc(0.75, 8)
    return 40.0, flexibility(kernel(body), facets, facets.owner.max() + 1)


@pytest.mark.parametrize(
    ("prony", "soft"),
    [(SKIN, ELASTIC), (ELASTIC, BODY), (SKIN, BODY)],
    ids=["skin", "object", "both"],
)
def test_two_relaxing_half_spaces_are_nested_contacts_in_series(prony: Prony, soft: Prony) -> None:
    """Loading and unloading, step by step, against the closed form with the creep of both."""
    facets, radius, depth = disc(0.75, 8), 5.0, 0.05
    plane, own = of_a_half_space()
    area = weighted(facets, lambda at: np.ones(at.shape[:-1]))
    rest = weighted(facets, bowl(radius)), area, prony.branches
    made = SoftContact((own, soft.branches), own, *rest)
    time = np.linspace(0, 0.4, 81)
    path = depth * np.interp(time, [0, 0.1, 0.2, 0.4], [0, 1, 1, 0.3])
    found = steps(made, [Target(each) for each in path[1:].tolist()], float(time[1]))
    at_once = plane / prony.long_time, plane / soft.long_time
    both = in_series(prony, at_once[0] / sum(at_once), soft)
    nodes = ting.radius_nodes(depth)
    elastic = 4 / 3 * at_once[0] * at_once[1] / sum(at_once) * np.sqrt(radius) * nodes**1.5
    expected = ting.press_by_depth(both, time, path, nodes).stress(elastic)[1:]
    assert np.abs(found - expected).max() < 0.02 * expected.max()
    assert expected[38] < 0.95 * expected[19]  # it has relaxed in the hold

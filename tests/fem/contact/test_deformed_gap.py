"""Weighted gaps on a deformed surface, and strain measures of large gradients."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from scipy import sparse
from scipy.linalg import expm, logm

from fefinger.fem.contact.deformed_gap import BEND, MOST, ContactSurface, contact_surface
from fefinger.fem.contact.obstacle import FAR, Obstacle
from fefinger.fem.contact.patch import candidates, patch
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.probe import gradient_at, gradient_at_vertices
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.material import material_of
from fefinger.fem.hyperelastic.state import State
from fefinger.geometry.profiles import FLANK, Bar, Ellipsoid, Plane, Profile, Relief
from fefinger.support.tensors import logarithmic


GRID = np.linspace(0.0, 1.0, 4)
AXIS = np.array([0.6, 0.0, -0.8])
UP = np.array([0.0, 0.0, 1.0])
BALL = Ellipsoid((0.8, 0.8, 0.8))


def surface(profile: Profile, axis: np.ndarray = AXIS) -> tuple[Space, ContactSurface, np.ndarray]:
    """Return a cube whose top faces an obstacle, and the triangles of the top."""
    space = box(GRID, GRID, GRID)
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    obstacle = Obstacle(axis, np.array([0.4, 0.5, 1.0]), profile)
    return space, contact_surface(space, top, np.zeros_like(space.points), obstacle, reach=2.0), top


def moved(space: Space, contact: ContactSurface, seed: int = 0, depth: float = 0.2) -> State:
    """Return a surface that crosses the obstacle back and forth, under some pressure."""
    random = np.random.default_rng(seed)
    values = 0.1 * random.normal(size=space.n_unknowns)
    return State(values, random.uniform(1, 2, len(contact)), depth)


def raised(space: Space, across: np.ndarray, height: float = 0.0) -> State:
    """Return a plane top of the cube that is bent to heights (n_nodes,) mm, and moved up as one."""
    values = np.zeros(space.n_unknowns)
    values[2 : space.n_displacements : 3] = across + height
    return State(values, np.zeros(0), 0.0)


@pytest.mark.parametrize("profile", [Plane(), Ellipsoid((3.0, 2.0, 4.0))], ids=["plane", "round"])
@pytest.mark.parametrize("spreads", [True, False])
def test_the_loads_are_the_derivatives_of_the_gaps_per_deformed_area(
    profile: Profile, spreads: bool
):
    space, contact, _ = surface(profile)
    contact = replace(contact, spreads=spreads)
    state, h = moved(space, contact), 1e-5
    along = np.random.default_rng(7).normal(size=space.n_unknowns)
    found = contact.at(state)
    ahead, behind = (contact.at(replace(state, values=state.values + s * along)) for s in (h, -h))
    slope = 1.0 - MOST * np.tanh(found.distance * BEND / (MOST * contact.sizes))
    gap = found.weighted / (found.steepness * contact.projected)
    area = contact.on.integrated(
        contact.on.part.hats * (slope * (ahead.spread - behind.spread))[:, None]
    )
    change = (ahead.weighted - behind.weighted - gap * area) / (2 * h)
    assert found.steepness * (found.loads.T @ along) == pytest.approx(change, rel=1e-7, abs=1e-8)


def test_the_gaps_close_as_fast_as_their_weights_and_the_force_along_the_axis_says_so():
    space, contact, _ = surface(Ellipsoid((3.0, 2.0, 4.0)))
    state, h = moved(space, contact, 1), 1e-6
    found = contact.at(state)
    before, after = (contact.at(replace(state, depth=0.2 + s)).weighted for s in (-h, h))
    assert (before - after) / (2 * h) == pytest.approx(found.steepness * contact.projected)
    assert contact.projected.sum() == pytest.approx(1.0)
    rigid = np.zeros(space.n_unknowns)
    rigid[: space.n_displacements] = np.tile(AXIS, space.n_nodes)
    assert found.loads.T @ rigid == pytest.approx(contact.projected)


def test_the_bed_resists_what_closes_the_gaps_and_nothing_else():
    space, contact, _ = surface(Plane())
    found = contact.at(moved(space, contact, 2))
    area = contact.on.integrated(contact.on.part.hats * found.spread[:, None]).sum()
    support = found.support(np.ones(len(contact), dtype=bool))
    rigid, across = np.zeros((2, space.n_unknowns))
    rigid[: space.n_displacements] = np.tile(AXIS, space.n_nodes)
    across[: space.n_displacements] = np.tile([0.8, 0.0, 0.6], space.n_nodes)
    assert rigid @ support @ rigid == pytest.approx(area)
    assert np.abs(support @ across).max() < 1e-15
    one = np.arange(len(contact)) == 0
    assert found.support(one).sum() < support.sum()


def test_the_stiffness_of_a_flat_contact_is_the_derivative_of_its_loads():
    space, contact, _ = surface(Plane(), -UP)
    random, h = np.random.default_rng(5), 1e-6
    state = replace(moved(space, contact, 4), depth=0.0)
    across, along = state.values.copy(), random.normal(size=space.n_unknowns)
    across[2 : space.n_displacements : 3] = 0.0  # the top stays on the plate
    state = replace(state, values=across)
    found = contact.at(state)
    multipliers = state.pressure / found.steepness
    loads = found.loads.toarray()
    along -= loads @ np.linalg.lstsq(loads, along, rcond=None)[0]  # closes no weighted gap

    def load(way: float) -> np.ndarray:
        there = contact.at(replace(state, values=across + way * along))
        return there.loads @ (multipliers * there.steepness)

    change = (load(h) - load(-h)) / (2 * h)
    folds, spreads = found.stiffness(), found.spreading_stiffness()
    assert -(folds + spreads) @ along == pytest.approx(change, abs=1e-6 * np.abs(change).max())
    assert np.linalg.eigvalsh(folds.toarray()).min() > -1e-12 * abs(folds).max()
    assert (found.fold_stiffness > 0).all()
    pulled = contact.at(replace(state, pressure=-state.pressure))
    assert abs(pulled.stiffness()).max() == abs(pulled.spreading_stiffness()).max() == 0


def test_a_facet_that_is_flat_has_its_mean_gap_and_one_that_is_folded_has_less():
    space, contact, _ = surface(Plane(), -UP)
    size, at = contact.sizes.max(), space.node_points
    top = at[:, 2] == 1
    flat = contact.at(raised(space, top * -0.02 * size))
    assert flat.gaps == pytest.approx(0.02 * size * contact.projected, rel=0.05)
    touching = contact.at(raised(space, 0.0 * top))
    assert touching.gaps == pytest.approx(0.0, abs=1e-15)
    middle = top & (np.abs(3 * at[:, :2] - np.round(3 * at[:, :2])) > 0.1).any(axis=1)
    folds = {}
    for fold in (0.02, 0.04):
        bent = contact.at(raised(space, fold * size * (top * 2.0 / 3.0 - middle)))
        hats = contact.on.part.hats * bent.spread[:, None]
        mean = contact.on.integrated(hats * bent.distance[:, None])
        folds[fold] = (mean - bent.weighted) / size
    assert (folds[0.02] > 0).all()
    assert folds[0.04] / folds[0.02] == pytest.approx(4.0, rel=0.1)  # of second order


@pytest.mark.parametrize("pressure", [5.0, 50.0])
def test_an_enclosed_incompressible_block_stays_stable_under_any_pressure(pressure: float):
    """Rigid walls all around and a plate on top: a pressure changes nothing but the mean stress.

    Stability is read from the inertia of the tangent bordered by the closed gaps. Without the
    spreading of facets, as with gaps that are weighted over the undeformed pad, it is lost.
    """
    space, contact, _ = surface(Plane(), -UP)
    body = continuum(space, {1: material_of(Elastic(3.0, 0.5))})
    n, at = space.n_displacements, space.node_points
    held = np.stack([(at[:, 0] % 1 == 0), (at[:, 1] % 1 == 0), at[:, 2] == 0], axis=1).ravel()
    free = np.flatnonzero(~np.concatenate([held, np.zeros(space.n_unknowns - n, dtype=bool)]))

    def negative(load: float, *, spreads: bool) -> int:
        values = np.zeros(space.n_unknowns)
        values[n:] = -load / body.scale
        found = contact.at(State(values, np.full(len(contact), load), 0.0))
        inner, _ = body.residual(values, body.at_rest)
        assert inner[free] == pytest.approx((found.loads @ found.pressure)[free], abs=1e-12 * load)
        tangent = body.tangent(values, body.at_rest)
        if spreads:
            tangent = tangent + found.spreading_stiffness()
        bordered = sparse.bmat([[tangent, found.loads], [found.loads.T, None]]).toarray()
        rows = np.concatenate([free, space.n_unknowns + np.arange(len(contact))])
        return int((np.linalg.eigvalsh(bordered[np.ix_(rows, rows)]) < -1e-9).sum())

    at_rest = negative(0.0, spreads=True)
    assert negative(pressure, spreads=True) == at_rest
    assert negative(50.0, spreads=False) > at_rest


def test_an_undeformed_surface_has_the_gaps_of_small_strain():
    space, contact, top = surface(Plane())
    flat = np.zeros_like(space.points)
    small = patch(space, top, flat, contact.obstacle, reach=2.0)
    rest = contact.at(State(np.zeros(space.n_unknowns), np.zeros(len(contact)), 0.0))
    mean = contact.on.integrated(contact.on.part.hats * rest.distance[:, None])
    assert mean == pytest.approx(small.gap, abs=1e-15)
    assert rest.loads.sum(axis=0) == pytest.approx(small.loads.sum(axis=0))


def test_skin_beside_an_edge_may_fold_around_it_though_its_gap_is_beyond_all_reach():
    space, obstacle = box(GRID, GRID, GRID), Obstacle(-UP, np.array([0.0, 0.5, 1.0]), Bar(0.7, 0.1))
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    flat = np.zeros_like(space.points)
    under = {reach: candidates(space, top, flat, obstacle, reach) for reach in (0.3, 1.0)}
    around = contact_surface(space, top, flat, obstacle, 0.3).on
    across = {name: set(space.points[each.vertices][:, 0].round(3)) for name, each in under.items()}
    assert across[0.3] == {0.0, 0.333} == across[1.0]
    assert set(space.points[around.vertices][:, 0].round(3)) == {0.0, 0.333, 0.667}
    assert not around.obstacle_border.any()


def test_candidates_beyond_the_flank_of_a_ball_are_marked():
    fine = np.linspace(0.0, 1.0, 9)
    space, ball = box(fine, fine, GRID), Obstacle(-UP, np.array([0.0, 0.0, 1.0]), BALL)
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    on = contact_surface(space, top, np.zeros_like(space.points), ball, 5.0).on
    away = np.linalg.norm(space.points[on.vertices][:, :2], axis=1)
    flank = BALL.radii[0] * np.sin(np.radians(FLANK))
    assert away.max() > BALL.radii[0]
    assert np.array_equal(on.beyond, away > flank)
    assert not on.obstacle_border.any()


def test_the_gaps_at_vertices_are_distances_along_the_normal():
    space, contact, _ = surface(Plane())
    values = np.zeros(space.n_unknowns)
    values[: space.n_displacements] = np.tile(0.3 * AXIS, space.n_nodes)
    gap, moved = contact.clearance(State(values, np.zeros(len(contact)), 0.1))
    rest, _ = contact.clearance(State(np.zeros(space.n_unknowns), np.zeros(len(contact)), 0.0))
    assert gap - rest == pytest.approx(0.2)
    assert moved == pytest.approx(np.tile(0.3 * AXIS, (len(gap), 1)))


def test_points_that_the_obstacle_is_not_ahead_of_are_far_away():
    lines = np.linspace(-2.0, 2.0, 5)
    tile = Relief(lines, lines, np.zeros((5, 5)))
    space, contact, _ = surface(tile, np.array([0.0, 0.0, -1.0]))
    values = np.zeros(space.n_unknowns)
    values[: space.n_displacements : 3] = 10.0
    found = contact.at(State(values, np.ones(len(contact)), 0.0))
    assert (found.gaps > 0.5 * FAR * contact.projected).all()
    assert contact.clearance(State(values, np.zeros(len(contact)), 0.0))[0] == pytest.approx(FAR)
    for each in (found.loads.data, found.fold_stiffness, found.stiffness().data):
        assert np.isfinite(each).all()


def test_logarithmic_strain_is_half_the_logarithm_of_c():
    gradient = 0.4 * np.random.default_rng(2).normal(size=(5, 3, 3))
    for h, log in zip(gradient, logarithmic(gradient), strict=True):
        c = (np.eye(3) + h).T @ (np.eye(3) + h)
        assert log == pytest.approx(logm(c).real / 2, abs=1e-12)
        assert expm(2 * log) == pytest.approx(c)


def test_a_tiny_gradient_has_its_small_strain_to_all_digits():
    h = 1e-12 * np.random.default_rng(3).normal(size=(3, 3))
    assert logarithmic(h) == pytest.approx((h + h.T) / 2, rel=1e-10)


def test_gradients_of_a_quadratic_displacement_are_exact_at_points_and_vertices():
    space = box(GRID, GRID, GRID)
    values = np.zeros(space.n_unknowns)
    places = space.node_points
    values[: space.n_displacements] = np.column_stack(
        [places[:, 1] ** 2, places[:, 0] * places[:, 2], places[:, 2] ** 2]
    ).ravel()

    def exact(points: np.ndarray) -> np.ndarray:
        gradient = np.zeros((len(points), 3, 3))
        gradient[:, 0, 1] = 2 * points[:, 1]
        gradient[:, 1, 0], gradient[:, 1, 2] = points[:, 2], points[:, 0]
        gradient[:, 2, 2] = 2 * points[:, 2]
        return gradient

    points = np.array([[0.3, 0.2, 0.7], [0.5, 0.0, 0.25]])
    found = (gradient_at(space, points) @ values).reshape(-1, 3, 3)
    assert found == pytest.approx(exact(points), abs=1e-12)
    mirrored = (gradient_at(space, points, (1,)) @ values).reshape(-1, 3, 3)
    assert mirrored[0] == pytest.approx(found[0])
    assert mirrored[1, 1, ::2] == pytest.approx([0.0, 0.0])
    vertices = (gradient_at_vertices(space) @ values).reshape(-1, 3, 3)
    assert vertices == pytest.approx(exact(space.points), abs=1e-12)

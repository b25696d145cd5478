"""Weighted gaps on a deformed surface, and strain measures of large gradients."""

import numpy as np
import pytest
from scipy.linalg import expm, logm

from fefinger.fem.contact import candidates, patch
from fefinger.fem.grids import box
from fefinger.fem.obstacle import FAR, Obstacle
from fefinger.fem.probe import gradient_at, gradient_at_vertices
from fefinger.fem.sliding import Sliding, sliding
from fefinger.fem.spaces import Space
from fefinger.fem.strain import logarithmic
from fefinger.profiles import Bar, Ellipsoid, Plane, Profile


GRID = np.linspace(0.0, 1.0, 4)
AXIS = np.array([0.6, 0.0, -0.8])
UP = np.array([0.0, 0.0, 1.0])
BALL = Ellipsoid((0.8, 0.8, 0.8))


def surface(profile: Profile, axis: np.ndarray = AXIS) -> tuple[Space, Sliding, np.ndarray]:
    """Return a cube whose top faces an obstacle, and the triangles of the top."""
    space = box(GRID, GRID, GRID)
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    obstacle = Obstacle(axis, np.array([0.4, 0.5, 1.0]), profile)
    return space, sliding(space, top, np.zeros_like(space.points), obstacle, reach=2.0), top


@pytest.mark.parametrize("profile", [Plane(), Ellipsoid((3.0, 2.0, 4.0))], ids=["plane", "round"])
def test_the_loads_are_the_derivatives_of_the_weighted_gaps(profile: Profile):
    space, contact, _ = surface(profile)
    random = np.random.default_rng(0)
    values, along = 0.1 * random.normal(size=(2, space.n_unknowns))
    _, loads = contact.gaps(values, 0.2)
    h = 1e-5
    ahead, behind = (contact.gaps(values + s * along, 0.2)[0] for s in (h, -h))
    assert loads.T @ along == pytest.approx((ahead - behind) / (2 * h), rel=1e-7, abs=1e-9)


def test_the_gaps_close_as_fast_as_their_weights_and_the_force_along_the_axis_says_so():
    space, contact, _ = surface(Ellipsoid((3.0, 2.0, 4.0)))
    values = 0.1 * np.random.default_rng(1).normal(size=space.n_unknowns)
    before, loads = contact.gaps(values, 0.2)
    after, _ = contact.gaps(values, 0.3)
    assert before - after == pytest.approx(0.1 * contact.travel)
    assert contact.travel.sum() == pytest.approx(1.0)
    rigid = np.zeros(space.n_unknowns)
    rigid[: space.n_displacements] = np.tile(AXIS, space.n_nodes)
    assert loads.T @ rigid == pytest.approx(contact.travel)


def test_the_bed_resists_what_closes_the_gaps_and_nothing_else():
    space, contact, _ = surface(Plane())
    values = 0.1 * np.random.default_rng(2).normal(size=space.n_unknowns)
    bed = contact.bed(values, 0.2, np.ones(len(contact), dtype=bool))
    rigid, across = np.zeros((2, space.n_unknowns))
    rigid[: space.n_displacements] = np.tile(AXIS, space.n_nodes)
    across[: space.n_displacements] = np.tile([0.8, 0.0, 0.6], space.n_nodes)
    assert rigid @ bed @ rigid == pytest.approx(contact.travel.sum())
    assert np.abs(bed @ across).max() < 1e-15
    _, loads = contact.gaps(values, 0.2)
    assert bed @ rigid == pytest.approx(loads @ np.ones(len(contact)))
    one = np.arange(len(contact)) == 0
    assert contact.bed(values, 0.2, one).sum() < bed.sum()


def folded(depth: float = 0.2) -> tuple[Sliding, np.ndarray, np.ndarray]:
    """Return a surface that crosses the obstacle back and forth, and its weighted gaps."""
    space, contact, _ = surface(Plane())
    values = 0.15 * np.random.default_rng(4).normal(size=space.n_unknowns)
    return contact, values, np.maximum(contact.gaps(values, depth)[0], 0.0)


def test_what_holds_a_folded_facet_has_its_derivative_and_its_force():
    contact, values, gaps = folded()
    found = contact.hold(values, 0.2, gaps, 40.0)
    along = np.random.default_rng(5).normal(size=len(values))
    h = 1e-7
    ahead, behind = (contact.hold(values + s * along, 0.2, gaps, 40.0).force for s in (h, -h))
    change = (ahead - behind) / (2 * h)
    assert -found.stiffness @ along == pytest.approx(change, abs=1e-6 * np.abs(change).max())
    pushed = found.force[: 3 * (len(values) // 3)].reshape(-1, 3).sum(axis=0)
    assert pushed @ AXIS == pytest.approx(contact.travel @ found.pressure)
    assert np.linalg.norm(np.cross(pushed, AXIS)) < 1e-12 * np.linalg.norm(pushed)
    assert (found.pressure >= 0).all()


def test_nothing_holds_a_facet_that_is_flat_or_not_closed_yet():
    space, contact, _ = surface(Plane(), np.array([0.0, 0.0, -1.0]))
    values = np.zeros(space.n_unknowns)
    values[2 : space.n_displacements : 3] = 0.5
    inside, _ = contact.gaps(values, 0.0)
    assert inside == pytest.approx(-0.5 * contact.travel)
    assert not contact.hold(values, 0.0, inside, 40.0).force.any()
    assert contact.hold(values, 0.0, np.zeros_like(inside), 40.0).force.any()


def test_an_undeformed_surface_has_the_gaps_of_small_strain():
    space, contact, top = surface(Plane())
    flat = np.zeros_like(space.points)
    small = patch(space, top, flat, contact.obstacle, reach=2.0)
    gaps, loads = contact.gaps(np.zeros(space.n_unknowns), 0.0)
    assert gaps == pytest.approx(small.gap, abs=1e-15)
    assert abs(loads - small.loads).max() < 1e-15


def test_skin_beside_an_edge_may_fold_around_it_though_its_gap_is_beyond_all_reach():
    space, obstacle = box(GRID, GRID, GRID), Obstacle(-UP, np.array([0.0, 0.5, 1.0]), Bar(0.7, 0.1))
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    flat = np.zeros_like(space.points)
    under = {reach: candidates(space, top, flat, obstacle, reach) for reach in (0.3, 1.0)}
    around = sliding(space, top, flat, obstacle, 0.3).on
    across = {name: set(space.points[each.vertices][:, 0].round(3)) for name, each in under.items()}
    assert across[0.3] == {0.0, 0.333} == across[1.0]
    assert set(space.points[around.vertices][:, 0].round(3)) == {0.0, 0.333, 0.667}
    assert not around.rim.any()


def test_beyond_the_outline_of_a_ball_no_patch_goes_and_its_rim_is_marked():
    fine = np.linspace(0.0, 1.0, 9)
    space, ball = box(fine, fine, GRID), Obstacle(-UP, np.array([0.0, 0.0, 1.0]), BALL)
    facets = np.asarray(space.scalar.mesh.facets.T)
    top = facets[(space.points[facets][:, :, 2] == 1).all(axis=1)]
    on = sliding(space, top, np.zeros_like(space.points), ball, 5.0).on
    away = np.linalg.norm(space.points[on.vertices][:, :2], axis=1)
    assert away.max() < BALL.radii[0]
    assert on.rim.any()
    assert not on.rim[away == 0].any()


def test_the_gaps_at_vertices_are_distances_along_the_normal():
    space, contact, _ = surface(Plane())
    values = np.zeros(space.n_unknowns)
    values[: space.n_displacements] = np.tile(0.3 * AXIS, space.n_nodes)
    gap, moved = contact.clearance(values, 0.1)
    rest, _ = contact.clearance(np.zeros(space.n_unknowns), 0.0)
    assert gap - rest == pytest.approx(0.2)
    assert moved == pytest.approx(np.tile(0.3 * AXIS, (len(gap), 1)))


def test_points_that_the_obstacle_is_not_ahead_of_are_far_away():
    space, contact, _ = surface(Ellipsoid((2.0, 2.0, 2.0)), np.array([0.0, 0.0, -1.0]))
    values = np.zeros(space.n_unknowns)
    values[: space.n_displacements : 3] = 10.0
    gaps, loads = contact.gaps(values, 0.0)
    assert gaps == pytest.approx(FAR * contact.travel)
    assert contact.clearance(values, 0.0)[0] == pytest.approx(FAR)
    assert np.isfinite(loads.data).all()


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

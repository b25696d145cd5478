"""The contact area to a fraction of an element, from gaps that are known exactly."""

import numpy as np
import pytest
from fefinger.validation.problems.grids import box
from scipy.spatial import Delaunay

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.contact import contact_area as areas
from fefinger.fem.contact.contact_area import CandidateSurface, fit_rims
from fefinger.fem.contact.obstacle import FAR, Obstacle
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.linalg.system import factor
from fefinger.geometry.profiles import Bar, Ellipsoid, Grating, Pin, Profile


UP = np.array([0.0, 0.0, 1.0])


def scattered(spacing: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3) of an uneven triangulation of a square of 4 by 4, and its triangles."""
    count = round(4 / spacing)
    line = np.linspace(-2, 2, count + 1)
    grid = np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
    grid += np.random.default_rng(seed).uniform(-0.25, 0.25, grid.shape) * spacing
    return np.column_stack([grid, np.zeros(len(grid))]), Delaunay(grid).simplices.astype(np.int64)


def hertz_gap(r: np.ndarray, a: float) -> np.ndarray:
    """Return the gap outside the Hertz contact of radius a, for R = 1."""
    x = np.maximum(r / a, 1.0)
    u = ((2 - x**2) * np.arcsin(1 / x) + np.sqrt(x**2 - 1)) / np.pi
    return a**2 * (x**2 / 2 - 1 + u)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("a", [0.9, 1.03, 1.17])
def test_the_area_of_a_circular_contact_is_that_of_its_circle(a: float, seed: int) -> None:
    points, triangles = scattered(0.25, seed)
    r = np.hypot(*points.T[:2])
    surface = CandidateSurface(points, triangles, UP)
    area = surface.area((r < 0.97 * a)[None], hertz_gap(r, a)[None])[0]
    assert area == pytest.approx(np.pi * a**2, rel=0.025)


def test_times_with_one_contact_are_fitted_together_and_as_each_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    points, triangles = scattered(0.25, 0)
    r, fits = np.hypot(*points.T[:2]), []
    pressed = np.array([r < bound for bound in (0.97, 0.97, 0.97, 0.7, 0.97)])
    gap = np.array([hertz_gap(r, a) for a in (1.0, 1.01, 1.03, 0.75, 1.02)])
    surface = CandidateSurface(points, triangles, UP)
    alone = [surface.area(p[None], g[None])[0] for p, g in zip(pressed, gap, strict=True)]
    monkeypatch.setattr(areas, "fit_rims", lambda *args: fits.append(0) or fit_rims(*args))
    assert surface.area(pressed, gap).tolist() == pytest.approx(alone, rel=1e-12)
    assert len(fits) == 2  # one for each of the two contacts
    monkeypatch.setattr(areas, "ROWS", 1)
    assert surface.area(pressed, gap).tolist() == pytest.approx(alone, rel=1e-12)


def test_the_error_falls_with_the_mesh() -> None:
    worst = []
    for spacing in (0.25, 0.1):
        errors = []
        for seed in range(6):
            points, triangles = scattered(spacing, seed)
            r = np.hypot(*points.T[:2])
            area = CandidateSurface(points, triangles, UP).area(
                (r < 1)[None], hertz_gap(r, 1.0)[None]
            )
            errors.append(abs(area[0] / np.pi - 1))
        worst.append(max(errors))
    assert worst[0] < 0.025
    assert worst[1] < 0.004


def turned_up(points: np.ndarray, upright: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points of a skin that leaves a plate along a circle of 1, and their gaps.

    It rises as the distance along it to the power 3/2, to a wall `upright` mm from the rim.
    """
    r = np.hypot(*points.T[:2])
    way = np.linspace(0, 3, 30001)
    slope = np.minimum(np.sqrt(way / upright), 1.0)
    middle = (slope[1:] + slope[:-1]) / 2
    step = np.diff(way)
    height = np.concatenate([[0.0], np.cumsum(middle * step)])
    out = np.concatenate([[0.0], np.cumsum(np.sqrt(1 - middle**2) * step)])
    gap = np.interp(r - 1, way, height)
    radius = np.where(r > 1, 1 + np.interp(r - 1, way, out), r)
    return np.column_stack([points[:, :2] * (radius / r)[:, None], gap]), gap


@pytest.mark.parametrize("upright", [0.6, 1.0, 2.0])
@pytest.mark.parametrize(("spacing", "worst"), [(0.25, 0.02), (0.15, 0.005)])
def test_skin_that_turns_up_beside_the_contact_is_none_of_it(
    upright: float, spacing: float, worst: float
) -> None:
    for seed in range(3):
        flat, triangles = scattered(spacing, seed)
        points, gap = turned_up(flat, upright)
        pressed = np.hypot(*flat.T[:2]) < 0.97
        area = CandidateSurface(points, triangles, UP).area(pressed[None], gap[None])[0]
        assert area == pytest.approx(np.pi, rel=worst)


def test_what_the_obstacle_is_not_ahead_of_does_not_change_the_area() -> None:
    points, triangles = scattered(0.25, 2)
    r = np.hypot(*points.T[:2])
    pressed, gap = (r < 0.97)[None], hertz_gap(r, 1.0)
    lost = np.where(r > 1.6, FAR, gap)
    found = [CandidateSurface(points, triangles, UP).area(pressed, g[None])[0] for g in (gap, lost)]
    assert found[1] == pytest.approx(found[0], rel=0.01)


def test_a_long_contact_with_two_parts_is_measured_as_both() -> None:
    points, triangles = scattered(0.1, 1)
    left, right = (np.hypot((points[:, 0] - x) / 0.6, points[:, 1]) for x in (-1.0, 1.0))
    inside = np.minimum(left, right)
    gap = np.where(inside > 1, np.abs(inside - 1) ** 1.5, 0.0)
    area = CandidateSurface(points, triangles, UP).area((inside < 0.95)[None], gap[None])[0]
    assert area == pytest.approx(2 * np.pi * 0.6, rel=0.04)


def test_no_contact_has_no_area_and_a_single_vertex_some() -> None:
    points, triangles = scattered(0.25, 0)
    r = np.hypot(*points.T[:2])
    pressed = np.zeros((3, len(points)), dtype=bool)
    pressed[1, int(np.argmin(r))] = True
    pressed[2] = pressed[1]
    gap = np.tile(hertz_gap(r, 0.15), (3, 1))
    area = CandidateSurface(points, triangles, UP).area(pressed, gap)
    assert area[0] == 0
    assert area[1:] == pytest.approx(np.pi * 0.15**2, abs=0.08)
    assert area[1] == pytest.approx(area[2], rel=1e-12)


def test_the_area_is_the_same_in_any_position_and_unit() -> None:
    points, triangles = scattered(0.25, 3)
    r = np.hypot(*points.T[:2])
    pressed, gap = (r < 1)[None], hertz_gap(r, 1.0)[None]
    plain = CandidateSurface(points, triangles, UP).area(pressed, gap)[0]
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turned = CandidateSurface(1e-3 * points @ turn.T + 5.0, triangles, turn @ UP)
    assert turned.area(pressed, 1e-3 * gap)[0] == pytest.approx(1e-6 * plain, rel=1e-6)


def test_with_too_few_points_outside_whole_vertices_are_counted() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    surface = CandidateSurface(points, np.array([[0, 1, 2]]), UP)
    area = surface.area(np.array([[True, False, False]]), np.array([[0.0, 0.1, 0.1]]))
    assert area == pytest.approx([0.5 / 3])
    assert surface.area(np.ones((1, 3), dtype=bool), np.zeros((1, 3))) == pytest.approx([0.5])


def test_a_vertex_that_is_touched_without_pressure_counts_near_an_edge_alone() -> None:
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    bar = Obstacle(UP, np.array([-0.5, 0.0, 0.0]), Bar(2.0, 0.002))  # its edge is at x = 0.5
    pressed = np.array([[True, False, True], [True, False, False]])
    gap = np.array([[0.0, 0.1, 0.0], [0.0, 0.1, -1e-6]])
    under = CandidateSurface(points, np.array([[0, 1, 2]]), UP, bar).area(pressed, gap)
    assert under[1] == pytest.approx(under[0], rel=1e-12)
    triangles, flat = np.array([[0, 1, 2]]), Obstacle(UP, np.zeros(3))
    for smooth in (None, flat, Obstacle(UP, np.zeros(3), Ellipsoid((2.0, 2.0, 2.0)))):
        found = CandidateSurface(points, triangles, UP, smooth).area(pressed, gap)
        assert found == pytest.approx([1 / 3, 1 / 6])


@pytest.mark.parametrize("spacing", [0.2, 0.4, 0.6])
def test_the_area_under_a_pin_rises_and_is_that_of_its_face_and_edge(spacing: float) -> None:
    """A pin of radius 1, its edge rounded to 0.4; contact spreads from its face to its wall."""
    pin, spread = Pin(2.0, 0.4), np.linspace(0.6, 1.0, 15)
    for seed in range(3):
        points, triangles = scattered(spacing, seed)
        r = np.hypot(*points.T[:2])
        obstacle = Obstacle(UP, np.zeros(3), pin)
        height, _ = obstacle.gap(points)
        pressed = r < spread[:, None]
        rim = 0.4 - np.sqrt(np.maximum(0.16 - (spread - 0.6) ** 2, 0.0))
        gap = np.where(pressed, 0.0, np.minimum(height - rim[:, None], FAR))
        pressed[1::2] &= np.arange(len(r)) % 5 > 0  # pressures oscillate, so that some are zero
        area = CandidateSurface(points, triangles, UP, obstacle).area(pressed, gap)
        assert np.diff(area).min() > -0.02 * area[-1]
        assert area[0] < 0.95 * area[-1]
        assert np.abs(area - np.pi * spread**2).max() < 0.25 * np.pi


def pressed_strip(profile: Profile, cells: int, shift: float) -> tuple[float, float]:
    """Return the area under a profile pressed into a block in plane strain, and without edges.

    The block is 8 long, 2 cells wide and 3 high, and `shift` moves its cells past the obstacle. The
    areas: of a width of 1.
    """
    width = 2 / cells
    space = box(
        np.linspace(-4, 4, 8 * cells + 1) + shift,
        np.linspace(0, width, 3),
        np.linspace(0, 3, 2 * cells + 1),
    )
    places = space.node_points
    held = np.repeat((places[:, 2] == 3)[:, None], 3, axis=1)
    held[:, 1] |= (places[:, 1] == 0) | np.isclose(places[:, 1], width)
    system = factor(space, stiffness(space, {1: Elastic(30.0, 0.45)}), np.flatnonzero(held.ravel()))
    facets = np.asarray(space.scalar.mesh.facets.T, dtype=np.int64)
    top = facets[(space.points[facets][:, :, 2] == 0).all(axis=1)]
    obstacle = Obstacle(UP, np.zeros(3), profile)
    on = patch(space, top, np.zeros_like(space.points), obstacle, 1.5)
    moved = system.solve(on.loads.toarray())
    flexibility = on.loads.T @ moved
    pressure = Complementarity((flexibility + flexibility.T) / 2).solve(on.gap - 0.3 * on.projected)
    gap = on.clearance(np.array([0.3]), (on.places.T @ moved @ pressure)[None])
    number = np.full(len(space.points), -1)
    number[on.neighborhood.vertices] = np.arange(len(on.neighborhood.vertices))
    triangles = number[on.neighborhood.triangles]
    triangles = triangles[(triangles >= 0).all(axis=1)]
    points = space.points[on.neighborhood.vertices]
    pressed = np.pad(pressure > 0, (0, len(points) - len(pressure)))
    found = [
        CandidateSurface(points, triangles, UP, ahead).area(pressed[None], gap)[0]
        for ahead in (obstacle, None)
    ]
    return found[0] / width, found[1] / width


@pytest.mark.parametrize("cells", [3, 4])
def test_the_area_under_a_bar_is_that_of_its_face(cells: int) -> None:
    found = [pressed_strip(Bar(2.0, 0.05), cells, shift) for shift in (0.05, 0.12, 0.2)]
    for area, _ in found:
        assert 1.9 < area < 2.0  # the contact ends somewhere on the rounded corners
    assert max(abs(blind - 1.95) for _, blind in found) > 0.25


@pytest.mark.parametrize("end", [0.25, 0.625])
@pytest.mark.parametrize("alone", [True, False])
def test_an_edge_cuts_the_corner_of_a_triangle_off(end: float, alone: bool) -> None:
    """One corner in contact and two free, or two and one: the edge of the bar lies at x = end."""
    x = [0.0, 1.0, 1.0] if alone else [1.0, 0.0, 0.0]
    points = np.column_stack([x, [0.0, 0.5, -0.5], np.zeros(3)])
    bar = Obstacle(UP, np.array([end - 1.0, 0.0, 0.0]), Bar(2.0, 0.002))
    gap, _ = bar.gap(points)
    surface = CandidateSurface(points, np.array([[0, 1, 2]]), UP, bar)
    share = end**2 if alone else 1 - (1 - end) ** 2
    assert surface.area((gap == 0)[None], gap[None]) == pytest.approx([share / 2], rel=1e-12)


@pytest.mark.parametrize(
    "profile", [Ellipsoid((3.0, np.inf, 3.0)), Bar(2.0, 1.0), Grating(4.0, 2.0, 0.6)]
)
def test_what_turns_away_slowly_has_no_edges(profile: Profile) -> None:
    area, blind = pressed_strip(profile, 3, 0.1)
    assert area == pytest.approx(blind, rel=1e-12)

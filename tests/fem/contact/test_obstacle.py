"""Obstacles: profiles and their derivatives, placed and turned; planes and spheres as known."""

import numpy as np
import pytest

from fefinger.fem.contact.obstacle import Obstacle
from fefinger.geometry.profiles import Bar, Ellipsoid, Grating, Pin, Plane, Profile, Relief


AXIS = np.array([-0.5, 0.0, np.sqrt(0.75)])
ORIGIN = np.array([0.1, 0.0, 0.2])
GRID = np.linspace(-3, 3, 41)


def waves(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return 0.3 * np.cos(1.1 * u) * np.cos(0.9 * v + 0.2)


PROFILES: dict[str, Profile] = {
    "plane": Plane(),
    "sphere": Ellipsoid((5.0, 5.0, 5.0)),
    "small": Ellipsoid((0.9, 0.7, 1.1)),
    "ellipsoid": Ellipsoid((3.0, 4.0, 2.0)),
    "cylinder": Ellipsoid((4.0, np.inf, 4.0)),
    "bar": Bar(3.0, 0.8),
    "edge": Bar(1.0, 0.5),
    "pin": Pin(2.0, 0.6),
    "grating": Grating(2.0, 0.7, 0.4, shift=0.3),
    "wide ridges": Grating(2.0, 1.4, 0.4),
    "relief": Relief.sampled(waves, GRID, GRID),
}
KINKS = {"bar": (0.7, 0.7 + 0.8 * np.sin(np.radians(75))), "edge": (0.0, 0.5 * np.sin(1.309))}
RINGS = {"pin": (0.0, 0.4, 0.4 + 0.6 * np.sin(np.radians(75)))}


def places(name: str) -> np.ndarray:
    """Return places (n, 2) at which the profile has second derivatives."""
    found = np.random.default_rng(3).uniform(-1.6, 1.6, (300, 2))
    for kink in KINKS.get(name, ()):
        found = found[np.abs(np.abs(found[:, 0]) - kink) > 1e-3]
    if name == "small":
        on = np.sqrt((found**2 / (0.9**2, 0.7**2)).sum(axis=1))
        found = found[np.abs(on - np.sin(np.radians(75))) > 1e-3]
    for ring in RINGS.get(name, ()):
        found = found[np.abs(np.linalg.norm(found, axis=1) - ring) > 1e-3]
    return found


@pytest.mark.parametrize("name", PROFILES)
def test_derivatives_of_a_profile_are_those_of_its_heights(name: str) -> None:
    profile, across, step = PROFILES[name], places(name), 1e-5
    h, slope, curvature = profile.height(across)
    assert h.min() >= (-1e-3 if name == "relief" else 0)
    assert np.isfinite(h).all()
    assert curvature == pytest.approx(np.swapaxes(curvature, -1, -2))
    for k, unit in enumerate(np.eye(2) * step):
        after, before = profile.height(across + unit), profile.height(across - unit)
        numeric = (after[0] - before[0]) / (2 * step)
        assert slope[:, k] == pytest.approx(numeric, abs=2e-8 * (1 + np.abs(numeric).max()))
        bend = (after[1] - before[1]) / (2 * step)
        assert curvature[:, k] == pytest.approx(bend, abs=2e-7 * (1 + np.abs(bend).max()))


@pytest.mark.parametrize("name", PROFILES)
def test_implicit_derivatives_are_those_of_g_in_space(name: str) -> None:
    obstacle = Obstacle(AXIS, ORIGIN, PROFILES[name], roll=25.0)
    local = np.column_stack([places(name), np.linspace(-1, 1, len(places(name)))])
    points, step = ORIGIN + local @ obstacle.frame, 1e-5
    g, gradient = obstacle.implicit(points, depth=0.3)
    assert g + 0.3 == pytest.approx(obstacle.gap(points)[0])
    assert gradient @ AXIS == pytest.approx(np.ones(len(points)))
    for k, unit in enumerate(np.eye(3) * step):
        after, before = obstacle.implicit(points + unit), obstacle.implicit(points - unit)
        numeric = (after[0] - before[0]) / (2 * step)
        assert gradient[:, k] == pytest.approx(numeric, abs=2e-8 * (1 + np.abs(numeric).max()))


def test_the_frame_is_a_rotation_and_rolls_about_the_axis() -> None:
    plain, rolled = Obstacle(AXIS, ORIGIN).frame, Obstacle(AXIS, ORIGIN, roll=90.0).frame
    for frame in (plain, rolled, Obstacle(AXIS, ORIGIN, roll=33.0).frame):
        assert frame @ frame.T == pytest.approx(np.eye(3))
        assert np.linalg.det(frame) == pytest.approx(1.0)
    assert plain[0, 1] == 0
    assert rolled[0] == pytest.approx(plain[1])


def test_a_sphere_is_a_sphere_and_a_large_one_a_plane() -> None:
    points = np.random.default_rng(2).uniform(-1, 1, (20, 3))
    distance, normal = Obstacle(AXIS, ORIGIN, Ellipsoid((5.0, 5.0, 5.0))).gap(points)
    ahead = points - distance[:, None] * AXIS
    center = ORIGIN - 5.0 * AXIS
    assert np.linalg.norm(ahead - center, axis=1) == pytest.approx(np.full(20, 5.0))
    assert normal == pytest.approx((ahead - center) / 5.0)
    plane = Obstacle(AXIS, ORIGIN).gap(points)[0]
    large = Obstacle(AXIS, ORIGIN, Ellipsoid((1e8, 1e8, 1e8)))
    assert large.gap(points)[0] == pytest.approx(plane, abs=1e-6)


@pytest.mark.parametrize("roll", [0.0, 90.0, 37.0])
def test_a_cylinder_is_as_far_from_its_own_axis_as_its_radius(roll: float) -> None:
    obstacle = Obstacle(AXIS, ORIGIN, Ellipsoid((4.0, np.inf, 4.0)), roll)
    points = ORIGIN + np.random.default_rng(4).uniform(-2, 2, (50, 3))
    distance, normal = obstacle.gap(points)
    ahead = points - distance[:, None] * AXIS
    own = obstacle.frame[1]
    away = ahead - (ORIGIN - 4.0 * AXIS)
    away -= np.outer(away @ own, own)
    assert np.linalg.norm(away, axis=1) == pytest.approx(np.full(50, 4.0))
    assert normal == pytest.approx(away / 4.0)


def test_where_no_surface_is_ahead_the_gap_is_infinite_and_the_derivatives_are_harmless() -> None:
    beyond = np.array([[5.5, 0.0]])
    h, slope, curvature = PROFILES["relief"].height(beyond)
    assert np.isinf(h).all()
    assert not slope.any()
    assert not curvature.any()
    g, gradient = Obstacle(AXIS, ORIGIN, PROFILES["relief"]).implicit(
        ORIGIN + np.array([[0.0, 9.0, 0.0]])
    )
    assert np.isposinf(g).all()
    assert gradient == pytest.approx(AXIS[None])


def test_a_ball_is_a_pin_without_a_flat_end() -> None:
    across = np.random.default_rng(5).uniform(-4, 4, (200, 2))
    ball, pin = Ellipsoid((2.0, 2.0, 2.0)), Pin(4.0, 2.0)
    for ours, theirs in zip(ball.height(across), pin.height(across), strict=True):
        assert ours == pytest.approx(theirs, rel=1e-12, abs=1e-12)
    flank = 2.0 * np.sin(np.radians(75))
    assert np.array_equal(ball.beyond(across), np.linalg.norm(across, axis=1) > flank)


def test_a_bar_is_flat_then_round_then_steep() -> None:
    bar = Bar(3.0, 0.8)
    u = np.array([0.0, 0.69, 0.7 + 0.8 * np.sin(np.radians(45)), 2.5])
    h, slope, _ = bar.height(np.column_stack([u, 0 * u]))
    assert h[:3] == pytest.approx([0, 0, 0.8 * (1 - np.cos(np.radians(45)))])
    assert slope[:, 0] == pytest.approx([0, 0, 1, np.tan(np.radians(75))])


def test_a_grating_repeats_and_is_as_wide_as_it_says_at_half_height() -> None:
    grating = Grating(2.0, 0.7, 0.4, shift=0.3)

    def height(u: np.ndarray) -> np.ndarray:
        return grating.height(np.column_stack([u, 0 * u]))[0]

    u = np.linspace(-1, 1, 21)
    assert height(u + 2.0) == pytest.approx(height(u))
    assert height(np.array([0.3, 0.3 + 0.35, 0.3 - 0.35, 1.3])) == pytest.approx([0, 0.2, 0.2, 0.4])


def test_a_relief_goes_through_its_function() -> None:
    across = np.random.default_rng(5).uniform(-2, 2, (100, 2))
    relief = Relief.sampled(waves, GRID, GRID)
    u, v = across.T
    h, slope, _ = relief.height(across)
    assert h == pytest.approx(relief.heights.max() - waves(u, v), abs=1e-5)
    assert slope[:, 0] == pytest.approx(0.33 * np.sin(1.1 * u) * np.cos(0.9 * v + 0.2), abs=1e-4)
    assert h.shape == (100,)

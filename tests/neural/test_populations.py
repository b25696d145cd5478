"""Places of units and end organs on surfaces whose shape is known."""

import numpy as np
import pytest
from refusals import refused

from fefinger.neural.populations import (
    Surface,
    grid,
    lifted,
    over,
    populate,
    scatter,
    squares,
)
from fefinger.neural.variation import numbered


DEPTHS = {"SAI": 0.8, "SAII": 1.25, "FAI": 0.5, "FAII": 2.5}


def cap(radius=10.0, half=5.0, n=31):
    """Return the top of a sphere that touches z = 0, over a square."""
    x = np.linspace(-half, half, n)
    xy = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    z = np.sqrt(radius**2 - np.sum(xy**2, axis=1))
    normals = np.column_stack([xy, z]) / radius
    areas = np.full(len(xy), (2 * half / (n - 1)) ** 2) / normals[:, 2]
    return Surface(np.column_stack([xy, z - radius]), normals, areas)


def flat(half=10.0, n=41):
    """Return a square in z = 0."""
    return Surface(*_plane(half, n))


def _plane(half, n):
    x = np.linspace(-half, half, n)
    xy = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    points = np.column_stack([xy, np.zeros(len(xy))])
    return points, np.tile([0.0, 0.0, 1.0], (len(xy), 1)), np.full(len(xy), (2 * half / n) ** 2)


CAP, FLAT = cap(), flat()
UP = np.array([0.0, 0.0, 1.0])


def test_places_between_the_points_of_a_sphere_lie_on_it_to_a_hundredth_of_the_spacing():
    rng = np.random.default_rng(0)
    xy = rng.uniform(-4.5, 4.5, (200, 2))
    height = np.sqrt(100 - np.sum(xy**2, axis=1)) - 10 + rng.uniform(-0.3, 0.3, 200)
    points, normals, on = CAP.project(np.column_stack([xy, height]))
    from_center = points + np.array([0, 0, 10])
    assert on.all()
    np.testing.assert_allclose(np.linalg.norm(from_center, axis=1), 10, atol=0.01 * CAP.spacing)
    np.testing.assert_allclose(normals, from_center / 10, atol=0.02)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_places_beside_the_skin_are_told():
    _, _, on = FLAT.project([[0, 0, 0.5], [10.2, 0, 0], [11.2, 0, 0], [0, -40, 3]])
    assert on.tolist() == [True, True, False, False]


def test_numbers_are_density_times_area_and_the_places_are_even():
    wanted = {"SAI": 70.0, "SAII": 6.0, "FAI": 900.0}
    types, places = scatter(wanted, 10.0, [0.0, 0.6, 0.8], seed=1)
    for kind, density in wanted.items():
        assert types.count(kind) == round(density * np.pi)
    np.testing.assert_allclose(places @ [0.0, 0.6, 0.8], 0.0, atol=1e-12)
    fast = places[np.array(types) == "FAI"]
    rings = np.histogram(np.linalg.norm(fast, axis=1) ** 2, bins=8, range=(0, 100))[0]
    turns = np.histogram(np.arctan2(fast @ [0.0, 0.8, -0.6], fast[:, 0]), bins=8)[0]
    for counts in (rings, turns):
        expected = len(fast) / 8
        # Pearson's statistic has 7 degrees of freedom: 24.3 is passed once in a thousand.
        assert np.sum((counts - expected) ** 2 / expected) < 24.3


def test_a_seed_gives_the_same_places_and_types_do_not_move_each_other():
    both = {"SAI": 70.0, "FAI": 140.0}
    one = scatter(both, 5.0, UP, seed=3)
    # exact: one call, made twice
    np.testing.assert_array_equal(one[1], scatter(both, 5.0, UP, seed=3)[1])
    alone = scatter({"FAI": 140.0}, 5.0, UP, seed=3)[1]
    np.testing.assert_allclose(one[1][np.array(one[0]) == "FAI"], alone, rtol=1e-12)
    assert not np.array_equal(alone, scatter({"FAI": 140.0}, 5.0, UP, seed=4)[1])


def test_places_are_lifted_along_the_axis_to_the_near_side_of_the_skin():
    ball = cap()
    both = Surface(
        np.concatenate([ball.points, ball.points * [1, 1, -1] - [0, 0, 20]]),
        np.concatenate([ball.normals, ball.normals * [1, 1, -1]]),
        np.concatenate([ball.areas, ball.areas]),
    )
    xy = np.random.default_rng(2).uniform(-4, 4, (40, 2))
    lifted_to = lifted(both, np.column_stack([xy, np.full(40, 3.0)]), -UP)
    np.testing.assert_allclose(lifted_to[:, :2], xy, atol=1e-12)
    # On the plane that touches the sphere at the nearest point: spacing² / radius above it.
    height = np.sqrt(100 - np.sum(xy**2, axis=1)) - 10
    assert np.all(np.abs(lifted_to[:, 2] - height) < 0.01)


def test_a_grid_covers_the_skin_and_a_line_its_length():
    places, which = grid(CAP, 2.0, 4.5)
    np.testing.assert_array_equal(which, np.arange(21))
    np.testing.assert_allclose(places[:, :2] / 2, np.round(places[:, :2] / 2), atol=0.05)
    along = over(CAP, np.linspace((-4, 0), (4, 0), 9), "places", "move them")
    assert along.shape == (9, 3)
    np.testing.assert_allclose(along[4], 0.0, atol=0.005)
    np.testing.assert_allclose(along[:, 1], 0.0, atol=0.01)


def test_a_grid_has_its_outermost_places_in_spite_of_rounding():
    assert len(squares(0.4, 1.2)) == 29
    assert len(squares(0.1, 0.3)) == 29


@pytest.mark.parametrize("n", [13, 25, 61])
def test_which_places_of_a_grid_lie_beside_the_skin_does_not_depend_on_its_points(n):
    # The skin ends at 3.4 mm with an upright wall, as at the tip of a finger.
    top = cap(half=3.4, n=n)
    y = np.linspace(-3.4, 3.4, n)
    wall = np.stack(np.meshgrid([3.4], y, -np.linspace(1.3, 8, n), indexing="ij"), -1)
    points = np.concatenate([top.points, wall.reshape(-1, 3)])
    normals = np.concatenate([top.normals, np.tile([1.0, 0.0, 0.0], (n * n, 1))])
    skin = Surface(points, normals, np.concatenate([top.areas, np.full(n * n, top.areas.mean())]))
    places, which = grid(skin, 1.0, 4.2)
    requested = squares(1.0, 4.2)
    assert set(requested[which, 0]) == {-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0}
    np.testing.assert_allclose(places[:, :2], requested[which], atol=0.5)


def test_branches_are_drawn_by_number_whichever_units_are_beside_the_skin():
    options = {"organs": {"SAI": (4, 7)}, "fields": {"SAI": 3.0}, "depths": DEPTHS, "seed": 5}
    all_three = populate(FLAT, ("SAI",) * 3, np.zeros((3, 3)), **options)
    third = numbered(("SAI",) * 3)[2:]
    last = populate(FLAT, ("SAI",), np.zeros((1, 3)), numbers=third, **options)
    np.testing.assert_allclose(last.skin, all_three.skin[all_three.unit == 2], rtol=1e-12)


def test_end_organs_lie_at_their_depth_along_the_normal():
    population = populate(CAP, ("SAI", "FAII"), [[0, 0, 0], [3, 0, -0.4]], depths=DEPTHS)
    depth = 10 - np.linalg.norm(population.sites + np.array([0, 0, 10]), axis=1)
    np.testing.assert_allclose(depth, [0.8, 2.5], atol=0.01)
    np.testing.assert_array_equal(population.unit, [0, 1])
    assert population.organ_types == ("SAI", "FAII")


def test_branches_are_as_many_as_asked_and_within_the_field():
    n = 300
    options = {"organs": {"SAI": (4, 7)}, "fields": {"SAI": 3.0}, "depths": DEPTHS, "seed": 5}
    population = populate(FLAT, ("SAI",) * n, np.zeros((n, 3)), **options)
    counts = np.bincount(population.unit)
    assert set(counts) == {4, 5, 6, 7}
    # Each of the four is drawn with probability 1/4: five standard deviations.
    assert np.all(np.abs(np.bincount(counts)[4:] - n / 4) < 5 * np.sqrt(n * 3 / 16))
    radius = np.linalg.norm(population.skin[:, :2], axis=1)
    assert radius.max() <= 1.5
    # Even over a disc: the mean squared distance is half of the squared radius.
    assert np.mean(radius**2) == pytest.approx(1.5**2 / 2, rel=0.06)
    again = populate(FLAT, ("SAI",) * n, np.zeros((n, 3)), **options)
    np.testing.assert_array_equal(population.skin, again.skin)  # exact: one call, made twice


def test_branches_stay_on_the_skin_at_its_edge():
    population = populate(
        FLAT,
        ("FAI",) * 4,
        [[9.9, 9.9, 0]] * 4,
        depths=DEPTHS,
        organs={"FAI": (12, 17)},
        fields={"FAI": 4.0},
        seed=1,
    )
    assert np.bincount(population.unit).min() >= 12
    assert population.skin[:, :2].max() < 10 + FLAT.spacing


@pytest.mark.parametrize(
    ("call", "field"),
    [
        (lambda: scatter({"SAI": 0.01}, 10.0, UP, seed=1), "densities.SAI"),
        (lambda: scatter({"SA": 70.0}, 5.0, UP, seed=1), "densities"),
        (
            lambda: scatter({"SAI": -1.0}, 5.0, UP, seed=1),
            "densities.SAI",
        ),
        (lambda: scatter({"SAI": 70.0}, 5.0, UP, seed=None), "seed"),
        (
            lambda: over(FLAT, np.linspace((0, 0), (30, 0), 5), "places", "move them"),
            "places",
        ),
        (
            lambda: over(FLAT, [[20, 0], [30, 0]], "places", "move them"),
            "places",
        ),
        (lambda: grid(FLAT, 0.0, 5.0), "spacing"),
        (lambda: populate(FLAT, (), np.zeros((0, 3)), depths=DEPTHS), "places"),
        (
            lambda: populate(FLAT, ("SAI",), [[40, 0, 0]], depths=DEPTHS),
            "places",
        ),
        (lambda: populate(FLAT, ("SAI",), [[0, 0, np.nan]], depths=DEPTHS), "places"),
        (lambda: populate(FLAT, ("SAI",), [[0, 0, 0]], depths={}), "depths"),
        (
            lambda: populate(
                FLAT, ("SAI",), [[0, 0, 0]], depths=DEPTHS, organs={"SAI": (0, 2)}, seed=1
            ),
            "organs.SAI",
        ),
        (
            lambda: populate(
                FLAT, ("SAI",), [[0, 0, 0]], depths=DEPTHS, organs={"SAI": (2, 3)}, seed=1
            ),
            "fields.SAI",
        ),
        (
            lambda: populate(
                flat(0.1, 9),
                ("SAI",),
                [[0, 0, 0]],
                depths=DEPTHS,
                organs={"SAI": (20, 20)},
                fields={"SAI": 900.0},
                seed=1,
            ),
            "fields.SAI",
        ),
        (lambda: Surface(*(a[:4] for a in _plane(1.0, 4))), "surface"),
        (lambda: Surface(_plane(1, 4)[0], 2 * _plane(1, 4)[1], _plane(1, 4)[2]), "surface"),
    ],
)
def test_impossible_populations_are_refused(call, field):
    with refused(field):
        call()

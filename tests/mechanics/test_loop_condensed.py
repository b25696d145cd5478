"""A finger that is driven from a loop."""

import tracemalloc
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys
from refusals import refused

import fefinger as ff
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.geometry.profiles import Ellipsoid
from fefinger.mechanics import condensed
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.results.records import Sites
from fefinger.scene.indenter import direction
from fefinger.support.checks import InputError
from fefinger.support.tensors import tensor_from_voigt
from fefinger.theory.relaxation import hereditary_integral


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
BALL = Ellipsoid((1.0, 1.0, 1.0))
small_strain = partial(ff.Loop, mechanics="condensed")
DEPTHS = 0.6 * np.sin(np.linspace(0, 9, 60))


pytestmark = pytest.mark.usefixtures("operators")


@pytest.fixture(scope="module")
def finger(kept: Path) -> ff.Loop:
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("XDG_CACHE_HOME", str(kept))
        return small_strain(FINGER, ff.Flat(30), deepest=1.2)


def trace(finger: ff.Loop, depths: np.ndarray = DEPTHS) -> np.ndarray:
    """Return everything that the steps to some depths give."""
    finger.reset()
    steps = (finger.step(2e-3, depth=float(depth)) for depth in depths)
    return np.array(
        [
            np.concatenate([[s.force, s.contact_area, s.x, s.y], s.pressure, s.strain.ravel()])
            for s in steps
        ]
    )


def along(finger: ff.Loop, motion: ff.Ramp, time: np.ndarray) -> dict[str, np.ndarray]:
    """Results of the steps along a motion at its times (n_t,)."""
    finger.reset()
    steps = zip(motion.value(time).tolist(), np.diff(time, prepend=0.0).tolist(), strict=True)
    rows = [
        (s.depth, s.force, (s.x, s.y), tensor_from_voigt(np.array(s.strain)))
        for s in (finger.step(dt, **{motion.control: value}) for value, dt in steps)
    ]
    names = ("depth", "force", "centroid", "strain")
    return dict(zip(names, map(np.array, zip(*rows, strict=True)), strict=True))


def agree(found: np.ndarray, expected: np.ndarray) -> None:
    """Check that two traces differ by rounding alone."""
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("indenter", "motion"),
    [
        (ff.Flat(30), ff.RampHold(60, 1.2, hold=0.2)),
        (ff.Flat(20, 15), ff.RampSinusoid(20, 0.5, amplitude=0.6, frequency=8, cycles=1)),
        (ff.Sphere(6), ff.Trapezoid(loading_rate=2, force=0.2, hold=0.1)),
    ],
)
def test_a_motion_gives_the_response_of_the_mechanics(
    indenter: ff.Flat | ff.Sphere, motion: ff.Ramp
) -> None:
    asked = ff.Scene(finger=FINGER, indenter=indenter, motion=motion, ask=ff.Ask(fields=False))
    expected = condensed.respond(asked)
    stepped = small_strain(FINGER, indenter, deepest=1.2)
    found = along(stepped, motion, expected.time)
    found["centroid"][found["force"] == 0] = np.nan
    for name in ("depth", "force", "centroid", "strain"):
        exact = getattr(expected, name)
        scale = np.nanmax(np.abs(exact))
        assert found[name] == pytest.approx(exact, rel=1e-9, abs=1e-11 * scale, nan_ok=True)
    pressed = expected.pad.areas[expected.pressure[-1] > 0]
    assert stepped.now.contact_area == pytest.approx(pressed.sum())
    ask = ff.Ask(fields=False, spikes=("SAI", "SAII", "FAI", "FAII"))
    fired = condensed.respond(replace(asked, motion=ff.Ramp(60, 0.3), ask=ask))
    lengths = fired.reference.lengths(stepped.sites.types)
    units = stepped.afferents(family="thesis")
    assert units.state.length == pytest.approx([lengths[kind] for kind in units.types], abs=1e-12)


def test_a_place_that_was_made_once_is_read_again(operators: Path) -> None:
    made = trace(small_strain(FINGER, ff.Flat(24), deepest=0.8))
    kept = set((operators.parent / "patches").iterdir())
    agree(trace(small_strain(FINGER, ff.Flat(24), deepest=0.8)), made)
    assert set((operators.parent / "patches").iterdir()) == kept
    stiffer = replace(FINGER, skin=replace(FINGER.skin, modulus=200.0))
    assert (
        small_strain(stiffer, ff.Flat(24), deepest=0.8).step(0, depth=0.5).force > made[:, 0].max()
    )


def test_it_repeats_itself_bit_for_bit(finger: ff.Loop) -> None:
    first = trace(finger)  # the same code on the same arrays: exact
    # exact: the same code on the same arrays
    assert np.array_equal(first, trace(finger), equal_nan=True)
    agree(trace(small_strain(FINGER, ff.Flat(30), deepest=1.2)), first)


def test_single_precision_is_good_to_five_digits(finger: ff.Loop) -> None:
    single = small_strain(FINGER, ff.Flat(30), deepest=1.2, precision="single")
    double, found = trace(finger), trace(single)
    strain = slice(-finger.now.strain.size, None)
    assert single.now.strain.dtype == np.float32
    error = np.abs(double[:, strain] - found[:, strain]).max()
    assert error < 1e-5 * np.abs(double[:, strain]).max()
    before = slice(0, -finger.now.strain.size)
    agree(found[:, before], double[:, before])


def test_a_step_makes_no_array() -> None:
    inside = np.array([0.5, 0.7, 1.5]) + np.linspace(0, 0.5, 200)[:, None]
    sites = Sites(inside, np.tile([0.0, 0.0, -1.0], (200, 1)), np.full(200, 1.5), ("SAI",) * 200)
    finger = small_strain(FINGER, ff.Flat(30), deepest=1.2, sites=sites)
    depths = np.linspace(0.3, 0.8, 500).tolist()
    tracemalloc.start()
    for depth in depths:
        finger.step(1e-3, depth=depth)
    before, _ = tracemalloc.get_traced_memory()
    tracemalloc.reset_peak()
    for depth in depths:
        finger.step(1e-3, depth=depth)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # An array of strains would add all of its bytes; numbers of Python take up to half as many.
    assert peak - before < 0.9 * finger.now.strain.nbytes


def test_compiled_steps_make_no_array_either(finger: ff.Loop) -> None:
    """Count what is counted: one record for every array that is passed, and none made inside."""
    leaky = finger.afferents(family="thesis")
    axons = finger.afferents(family="thesis", membrane=HodgkinHuxley())

    def step_all() -> None:
        finger.step(1e-3, depth=0.5)
        finger.step(1e-3, force=0.3)
        finger.step(1e-3, depth=-0.1)
        for units in (leaky, axons):
            units.step(finger.now.strain, 1e-3)

    contact, each = finger.prepared.contact, arrays(leaky.state)
    step = arrays(contact.lcp, contact.history) + 5  # search, gap, areas, limits, offset
    once = step + arrays(finger.prepared.readout) + 2  # pressure, elastic stress
    passed = 3 * once + 2 * (each + 1) + (each + 1) + (each + 3)
    step_all()
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats().alloc
    step_all()
    made = rtsys.get_allocation_stats().alloc - before
    _nrt_python.memsys_disable_stats()
    assert made == passed


def arrays(*records: tuple) -> int:
    return sum(isinstance(entry, np.ndarray) for record in records for entry in record)


def test_sites_beyond_the_medial_plane_have_the_mirror_image_of_the_strain() -> None:
    inside = np.array([[0.5, 0.7, 1.5], [0.5, -0.7, 1.5]])
    normals = np.tile([0.0, 0.0, -1.0], (2, 1))
    sites = Sites(inside, normals, np.full(2, 1.5), ("SAI", "SAI"))
    half = small_strain(FINGER, ff.Flat(30), deepest=0.6, sites=sites)
    whole = small_strain(FINGER, ff.Flat(30, 1e-9), deepest=0.6, sites=sites)
    left, right = (each.step(0.01, depth=0.5).strain for each in (half, whole))
    assert left == pytest.approx(right, abs=1e-7 * np.abs(right).max())
    assert left[0, 3] == pytest.approx(-left[1, 3])


def test_the_energy_of_half_a_model_is_that_of_the_whole_finger() -> None:
    half = small_strain(FINGER, ff.Flat(30), deepest=0.6)
    whole = small_strain(FINGER, ff.Flat(30, 1e-9), deepest=0.6)

    def energy(finger: ff.Loop) -> np.ndarray:
        return finger.solid.sides * np.array(finger.prepared.contact.energy())

    for depth in (0.2, 0.5, 0.3):
        forces = [each.step(0.01, depth=depth).force for each in (half, whole)]
        assert forces[0] == pytest.approx(forces[1], rel=1e-6)
        assert energy(half) == pytest.approx(energy(whole), rel=1e-6)


def test_the_reference_is_that_of_the_central_sites_wherever_ones_own_are(
    finger: ff.Loop,
) -> None:
    inside = np.array([[0.5, 0.7, 1.5], [0.5, 0.3, 2.0], [1.0, 0.0, 1.5]])
    types = ("FAI", "FAI", "SAI")
    sites = Sites(inside, np.tile([0.0, 0.0, -1.0], (3, 1)), np.full(3, 1.5), types)
    central = finger.afferents(family="thesis")
    lengths = dict(zip(central.types, central.state.length, strict=True))
    own = small_strain(FINGER, ff.Flat(30), deepest=1.2, sites=sites).afferents(family="thesis")
    assert own.state.length == pytest.approx([lengths[kind] for kind in types], rel=1e-9)


class Bare:
    """A plate with an axis and gaps alone."""

    def __init__(self, plate: Obstacle) -> None:
        self.axis, self.gap = plate.axis, plate.gap


@pytest.mark.parametrize("mechanics", ["condensed", "modal"])
def test_an_axis_and_gaps_are_enough_for_an_obstacle(mechanics: str) -> None:
    known = ff.Loop(FINGER, ff.Flat(30), mechanics=mechanics, deepest=0.8)
    bare = Bare(Obstacle(direction(ff.Flat(30)), known.prepared.touch))
    own = ff.Loop(FINGER, bare, mechanics=mechanics, deepest=0.8)
    for depth in (0.3, 0.6):
        force = own.step(1e-4, depth=depth).force
        assert force == pytest.approx(known.step(1e-4, depth=depth).force, rel=1e-6)


@pytest.mark.parametrize(
    ("indenter", "options", "words"),
    [
        ("bare", {"mechanics": "pressed"}, "indenter: expected an ff.Indenter"),
        ("bare", {"reach": 1.0}, "indenter: expected an ff.Indenter"),
        (object(), {}, "indenter: expected an ff.Indenter.*`axis`"),
        ("long", {}, "indenter.axis: expected a unit vector"),
        ("distances", {}, r"indenter.gap.points.: expected two arrays.*received ndarray \(\d+,"),
        ("one point", {}, r"indenter.gap.points.: .*received \(\(1, 7\), \(1, 7, 3\)\)"),
    ],
)
def test_an_obstacle_that_a_loop_cannot_take_is_refused(
    indenter: object, options: dict, words: str
) -> None:
    plate = Bare(Obstacle(direction(ff.Flat(30)), np.zeros(3)))
    if indenter == "long":
        plate.axis = 2 * plate.axis
    gap = plate.gap
    if indenter == "distances":
        plate.gap = lambda points: gap(points)[0]
    if indenter == "one point":
        plate.gap = lambda points: gap(points[:1])
    given = plate if isinstance(indenter, str) else indenter
    with pytest.raises(InputError, match=words):
        ff.Loop(FINGER, given, **{"mechanics": "condensed"} | options)


def test_an_obstacle_of_ones_own(finger: ff.Loop) -> None:
    sites = finger.sites
    origin = sites.points[0] - sites.depths[0] * direction(ff.Flat(30))
    plate = Obstacle(direction(ff.Flat(30)), origin)
    own = small_strain(FINGER, plate, deepest=1.2)
    own.step(1e-3, depth=0.5)
    finger.reset()
    assert own.now.force == pytest.approx(finger.step(1e-3, depth=0.5).force, rel=1e-9)


def test_the_reading_of_the_thesis_is_the_integral_of_g_over_t_times_the_elastic_force() -> None:
    def t(depth: float) -> float:
        return 2.0 * np.expm1(1.5 * depth)

    elastic = small_strain(replace(FINGER, prony=ff.Prony((1.0,), ())), ff.Flat(30), deepest=1.2)
    scaled = small_strain(FINGER, ff.Flat(30), deepest=1.2, stiffening=t)
    time = np.linspace(0, 0.5, 501)
    depth = 1.0 * np.minimum(time / 0.1, 1.0)
    for each in (elastic, scaled):
        each.reset()
    forces = [
        (t(d) * elastic.step(1e-3, depth=d).force, scaled.step(1e-3, depth=d).force)
        for d in depth.tolist()
    ]
    wanted, found = np.array(forces).T
    expected = hereditary_integral(FINGER.prony, time, wanted) / FINGER.prony.long_time
    assert found == pytest.approx(expected, rel=2e-3, abs=2e-3 * expected.max())
    assert scaled.now.strain == pytest.approx(elastic.now.strain, rel=1e-9, abs=1e-12)
    with pytest.raises(InputError, match="expected depth control"):
        scaled.step(1e-3, force=0.1)
    with refused("stiffening"):
        scaled.step(1e-3, depth=0.0)


def test_contact_alone_stiffens_as_the_whole_step_does() -> None:
    one, other = (
        small_strain(FINGER, ff.Flat(30), deepest=1.2, stiffening=lambda depth: 1.0 + 2.0 * depth)
        for _ in range(2)
    )
    for k, depth in enumerate((0.2, 0.5, 0.9, 0.9, 0.4)):
        mixed = one.step(5e-3, depth=depth, strain=k % 2 == 1)
        wanted = other.step(5e-3, depth=depth)
        assert mixed.force == pytest.approx(wanted.force, rel=1e-9)
        assert mixed.pressure == pytest.approx(wanted.pressure, rel=1e-9, abs=1e-9)
        assert one.prepared.contact.elastic == pytest.approx(
            other.prepared.contact.elastic, rel=1e-9, abs=1e-9
        )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"deepest": -1.0}, "deepest: expected"),
        ({"precision": "half"}, "precision: expected"),
        ({"indenter": Obstacle(np.array([0, 0, 1.0]), np.array([0, 99.0, 0]), BALL)}, "over"),
    ],
)
def test_what_cannot_be_placed_gets_a_sentence(options: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        small_strain(FINGER, **options)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"relaxation": "deviatoric"}, "finger.relaxation = 'deviatoric'.* use the mechanics"),
        (
            {"skin": replace(FINGER.skin, prony=ff.Prony((0.5, 0.5), (1.0,)))},
            "^finger.skin.prony: set.* use the mechanics 'solid'",
        ),
    ],
)
def test_tissues_that_relax_apart_are_refused(changes: dict, words: str) -> None:
    with pytest.raises(InputError, match=words):
        small_strain(replace(FINGER, **changes))
    with pytest.raises(InputError, match=words):
        small_strain(replace(FINGER, **changes), angles=(10, 40))


def test_the_force_asked_for_is_the_force_found(finger: ff.Loop) -> None:
    finger.reset()
    for force in (0.05, 0.4, 0.4, 0.1, 0.0, 0.2):
        step = finger.step(5e-3, force=force)
        assert step.force == pytest.approx(force, rel=1e-8, abs=1e-15)
    depth = step.depth
    elastic = small_strain(replace(FINGER, prony=ff.Prony((1.0,), ())), ff.Flat(30), deepest=1.2)
    rested = finger.step(1e4, force=0.2)
    assert rested.depth > depth
    settled = finger.step(1e4, force=0.2).depth
    assert elastic.step(0.0, depth=settled).force == pytest.approx(0.2, 1e-6)


def test_forces_are_those_of_their_depths_from_first_touch_on(finger: ff.Loop) -> None:
    forces = [0.0, 0.0, 1e-4, 0.05, 0.4, 0.1, 0.0, 0.0, 0.2, 0.0]
    finger.reset()
    depths = [finger.step(5e-3, force=force).depth for force in forces]
    assert depths[:2] == [0.0, 0.0]
    assert depths[2] > 0
    finger.reset()
    again = [finger.step(5e-3, depth=depth).force for depth in depths]
    assert again == pytest.approx(forces, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize(
    "indenter", [ff.Bar(2.0, 0.5, roll=20), ff.Bar(2.0, 1.0), ff.Grating(4.0, 2.0, 2.0)]
)
def test_an_edge_is_answered_to_the_depth_that_was_said(indenter: ff.Bar | ff.Grating) -> None:
    """Beside an edge the gap grows within a facet to more than any reach."""
    finger = small_strain(FINGER, indenter, deepest=1.2)
    scene = ff.Scene(
        finger=FINGER, indenter=indenter, motion=ff.Ramp(10.0, 1.2), ask=ff.Ask(fields=False)
    )
    expected = condensed.respond(scene)
    found = along(finger, scene.motion, expected.time)
    assert found["force"] == pytest.approx(expected.force, rel=1e-9, abs=1e-12)


def test_an_edge_along_the_finger_is_answered_to_the_depth_that_was_said() -> None:
    """Its candidates reach the end of the palmar part, beside which they still have to grow."""
    finger = small_strain(FINGER, ff.Bar(2.0, 0.5, roll=90), deepest=2.0)
    force = [finger.step(1e-3, depth=depth).force for depth in (0.5, 1.0, 1.5, 2.0)]
    assert (np.diff(force) > 0).all()


def test_where_the_indenter_ends_and_where_the_pad_ends_are_told_apart() -> None:
    lines = np.linspace(-2.0, 2.0, 9)
    tile = small_strain(FINGER, ff.Relief.of(lambda x, y: 0 * x * y, lines, lines), deepest=1.2)
    with pytest.raises(InputError, match="beyond which the indenter turns away"):
        tile.step(1e-3, depth=1.0)
    with pytest.raises(InputError, match=r"deepest: expected a depth .* received 2 mm"):
        small_strain(FINGER, ff.Flat(60), deepest=2.0)

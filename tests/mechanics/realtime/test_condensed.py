"""A finger that is driven from a loop."""

import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numba.core.runtime import _nrt_python, rtsys

import fefinger as ff
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.geometry.profiles import Ellipsoid
from fefinger.geometry.voigt import tensor_from_voigt
from fefinger.mechanics import condensed
from fefinger.mechanics.realtime.condensed import Condensed
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.results.records import Sites
from fefinger.scene.indenter import direction
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import hereditary_integral


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
BALL = Ellipsoid((1.0, 1.0, 1.0))
DEPTHS = 0.6 * np.sin(np.linspace(0, 9, 60))


pytestmark = pytest.mark.usefixtures("operators")


@pytest.fixture(scope="module")
def finger(kept: Path) -> Condensed:
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("XDG_CACHE_HOME", str(kept))
        return Condensed(FINGER, ff.Flat(30), deepest=1.2)


def trace(finger: Condensed, depths: np.ndarray = DEPTHS) -> np.ndarray:
    """Return everything that the steps to some depths give."""
    finger.reset()
    steps = (finger.step(float(depth), 2e-3) for depth in depths)
    return np.array(
        [
            np.concatenate([[s.force, s.contact_area, s.x, s.y], s.pressure, s.strain.ravel()])
            for s in steps
        ]
    )


def along(finger: Condensed, motion: ff.Ramp, time: np.ndarray) -> dict[str, np.ndarray]:
    """Results of the steps along a motion at its times (n_t,)."""
    finger.reset()
    take = finger.step if motion.control == "depth" else finger.step_force
    steps = zip(motion.value(time).tolist(), np.diff(time, prepend=0.0).tolist(), strict=True)
    rows = [
        (s.depth, s.force, (s.x, s.y), tensor_from_voigt(np.array(s.strain)))
        for s in (take(value, dt) for value, dt in steps)
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
        (ff.Sphere(6), ff.ForceTrapezoid(2, 0.2, hold=0.1)),
    ],
)
def test_a_motion_gives_the_response_of_the_mechanics(
    indenter: ff.Flat | ff.Sphere, motion: ff.Ramp
) -> None:
    asked = ff.Scene(finger=FINGER, indenter=indenter, motion=motion, ask=ff.Ask(fields=False))
    expected = condensed.respond(asked)
    stepped = Condensed(FINGER, indenter, deepest=1.2)
    found = along(stepped, motion, expected.time)
    for name in ("depth", "force", "centroid", "strain"):
        exact = np.nan_to_num(getattr(expected, name))
        close = pytest.approx(exact, rel=1e-9, abs=1e-11 * np.abs(exact).max())
        assert np.nan_to_num(found[name]) == close
    pressed = expected.pad.areas[expected.pressure[-1] > 0]
    assert stepped.now.contact_area == pytest.approx(pressed.sum())
    ask = ff.Ask(fields=False, spikes=("SAI", "SAII", "FAI", "FAII"))
    fired = condensed.respond(replace(asked, motion=ff.Ramp(60, 0.3), ask=ask))
    lengths = fired.reference.lengths(stepped.sites.types)
    units = stepped.afferents(family="thesis")
    assert units.state.length == pytest.approx([lengths[kind] for kind in units.types], abs=1e-12)


def test_a_place_that_was_made_once_is_read_again(operators: Path) -> None:
    made = trace(Condensed(FINGER, ff.Flat(24), deepest=0.8))
    kept = set((operators.parent / "patches").iterdir())
    agree(trace(Condensed(FINGER, ff.Flat(24), deepest=0.8)), made)
    assert set((operators.parent / "patches").iterdir()) == kept
    stiffer = replace(FINGER, skin=replace(FINGER.skin, modulus=200.0))
    assert Condensed(stiffer, ff.Flat(24), deepest=0.8).step(0.5, 0).force > made[:, 0].max()


def test_it_repeats_itself_bit_for_bit(finger: Condensed) -> None:
    first = trace(finger)  # the same code on the same arrays: exact
    assert np.array_equal(first, trace(finger), equal_nan=True)
    agree(trace(Condensed(FINGER, ff.Flat(30), deepest=1.2)), first)


def test_single_precision_is_good_to_five_digits(finger: Condensed) -> None:
    single = Condensed(FINGER, ff.Flat(30), deepest=1.2, precision="single")
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
    finger = Condensed(FINGER, ff.Flat(30), deepest=1.2, sites=sites)
    depths = np.linspace(0.3, 0.8, 500).tolist()
    tracemalloc.start()
    for depth in depths:
        finger.step(depth, 1e-3)
    before, _ = tracemalloc.get_traced_memory()
    tracemalloc.reset_peak()
    for depth in depths:
        finger.step(depth, 1e-3)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # An array of strains would add all of its bytes; numbers of Python take up to half as many.
    assert peak - before < 0.9 * finger.now.strain.nbytes


def test_compiled_steps_make_no_array_either(finger: Condensed) -> None:
    """Count what is counted: one record for every array that is passed, and none made inside."""
    leaky = finger.afferents(family="thesis")
    axons = finger.afferents(family="thesis", membrane=HodgkinHuxley())

    def step() -> None:
        finger.step(0.5, 1e-3)
        finger.step_force(0.3, 1e-3)
        finger.step(-0.1, 1e-3)
        for units in (leaky, axons):
            units.step(finger.now.strain, 1e-3)

    once = arrays(finger._state, finger._memory, finger.output)
    each = arrays(leaky.state)
    passed = 3 * once + 2 * (each + 1) + (each + 1) + (each + 3)
    step()
    _nrt_python.memsys_enable_stats()
    before = rtsys.get_allocation_stats().alloc
    step()
    made = rtsys.get_allocation_stats().alloc - before
    _nrt_python.memsys_disable_stats()
    assert made == passed


def arrays(*records: tuple) -> int:
    return sum(isinstance(entry, np.ndarray) for record in records for entry in record)


def test_sites_beyond_the_medial_plane_have_the_mirror_image_of_the_strain() -> None:
    inside = np.array([[0.5, 0.7, 1.5], [0.5, -0.7, 1.5]])
    normals = np.tile([0.0, 0.0, -1.0], (2, 1))
    sites = Sites(inside, normals, np.full(2, 1.5), ("SAI", "SAI"))
    half = Condensed(FINGER, ff.Flat(30), deepest=0.6, sites=sites)
    whole = Condensed(FINGER, ff.Flat(30, 1e-9), deepest=0.6, sites=sites)
    left, right = (each.step(0.5, 0.01).strain for each in (half, whole))
    assert left == pytest.approx(right, abs=1e-7 * np.abs(right).max())
    assert left[0, 3] == pytest.approx(-left[1, 3])


def test_the_energy_of_half_a_model_is_that_of_the_whole_finger() -> None:
    half = Condensed(FINGER, ff.Flat(30), deepest=0.6)
    whole = Condensed(FINGER, ff.Flat(30, 1e-9), deepest=0.6)
    for depth in (0.2, 0.5, 0.3):
        forces = [each.step(depth, 0.01).force for each in (half, whole)]
        assert forces[0] == pytest.approx(forces[1], rel=1e-6)
        assert half.energy() == pytest.approx(whole.energy(), rel=1e-6)


def test_the_reference_is_that_of_the_central_sites_wherever_ones_own_are(
    finger: Condensed,
) -> None:
    inside = np.array([[0.5, 0.7, 1.5], [0.5, 0.3, 2.0], [1.0, 0.0, 1.5]])
    types = ("FAI", "FAI", "SAI")
    sites = Sites(inside, np.tile([0.0, 0.0, -1.0], (3, 1)), np.full(3, 1.5), types)
    central = finger.afferents(family="thesis")
    lengths = dict(zip(central.types, central.state.length, strict=True))
    own = Condensed(FINGER, ff.Flat(30), deepest=1.2, sites=sites).afferents(family="thesis")
    assert own.state.length == pytest.approx([lengths[kind] for kind in types], rel=1e-9)


def test_an_obstacle_of_ones_own(finger: Condensed) -> None:
    sites = finger.sites
    origin = sites.points[0] - sites.depths[0] * direction(ff.Flat(30))
    plate = Obstacle(direction(ff.Flat(30)), origin)
    own = Condensed(FINGER, plate, deepest=1.2)
    own.step(0.5, 1e-3)
    finger.reset()
    assert own.now.force == pytest.approx(finger.step(0.5, 1e-3).force, rel=1e-9)


def test_the_reading_of_the_thesis_is_the_integral_of_g_over_t_times_the_elastic_force() -> None:
    def t(depth: float) -> float:
        return 2.0 * np.expm1(1.5 * depth)

    elastic = Condensed(replace(FINGER, prony=ff.Prony((1.0,), ())), ff.Flat(30), deepest=1.2)
    scaled = Condensed(FINGER, ff.Flat(30), deepest=1.2, stiffening=t)
    time = np.linspace(0, 0.5, 501)
    depth = 1.0 * np.minimum(time / 0.1, 1.0)
    for each in (elastic, scaled):
        each.reset()
    forces = [
        (t(d) * elastic.step(d, 1e-3).force, scaled.step(d, 1e-3).force) for d in depth.tolist()
    ]
    wanted, found = np.array(forces).T
    expected = hereditary_integral(FINGER.prony, time, wanted) / FINGER.prony.long_time
    assert found == pytest.approx(expected, rel=2e-3, abs=2e-3 * expected.max())
    assert scaled.now.strain == pytest.approx(elastic.now.strain, rel=1e-9, abs=1e-12)
    with pytest.raises(InputError, match="expected depth control"):
        scaled.step_force(0.1, 1e-3)
    with pytest.raises(InputError, match="expected t above 0"):
        scaled.step(0.0, 1e-3)


def test_contact_alone_stiffens_as_the_whole_step_does() -> None:
    one, other = (
        Condensed(FINGER, ff.Flat(30), deepest=1.2, stiffening=lambda depth: 1.0 + 2.0 * depth)
        for _ in range(2)
    )
    for k, depth in enumerate((0.2, 0.5, 0.9, 0.9, 0.4)):
        mixed = (one.step_contact if k % 2 == 0 else one.step)(depth, 5e-3)
        wanted = other.step(depth, 5e-3)
        assert mixed.force == pytest.approx(wanted.force, rel=1e-9)
        assert mixed.pressure == pytest.approx(wanted.pressure, rel=1e-9, abs=1e-9)
        assert one.elastic == pytest.approx(other.elastic, rel=1e-9, abs=1e-9)


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
        Condensed(FINGER, **options)


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
        Condensed(replace(FINGER, **changes))
    with pytest.raises(InputError, match=words):
        ff.Rolling(replace(FINGER, **changes), sites=Sites.__new__(Sites))


@pytest.mark.parametrize(
    ("step", "words"),
    [
        (lambda f: f.step(np.nan, 1e-3), "depth: expected a finite number"),
        (lambda f: f.step(0.1, -1e-3), "dt: expected"),
        (lambda f: f.step(0.1, np.inf), "dt: expected a finite"),
        (lambda f: f.step_contact(np.inf, 1e-3), "depth: expected a finite number"),
        (lambda f: f.step_force(-0.1, 1e-3), "force: expected .* at least 0"),
        (lambda f: f.step_force(np.nan, 1e-3), "force: expected a finite number"),
    ],
)
def test_numbers_that_cannot_be_stepped_to_get_a_sentence(
    finger: Condensed, step: Callable, words: str
) -> None:
    finger.reset()
    with pytest.raises(InputError, match=words):
        step(finger)


def test_the_force_asked_for_is_the_force_found(finger: Condensed) -> None:
    finger.reset()
    for force in (0.05, 0.4, 0.4, 0.1, 0.0, 0.2):
        step = finger.step_force(force, 5e-3)
        assert step.force == pytest.approx(force, rel=1e-8, abs=1e-15)
    depth = step.depth
    elastic = Condensed(replace(FINGER, prony=ff.Prony((1.0,), ())), ff.Flat(30), deepest=1.2)
    rested = finger.step_force(0.2, 1e4)
    assert rested.depth > depth
    assert elastic.step(finger.step_force(0.2, 1e4).depth, 0.0).force == pytest.approx(0.2, 1e-6)


def test_forces_are_those_of_their_depths_from_first_touch_on(finger: Condensed) -> None:
    forces = [0.0, 0.0, 1e-4, 0.05, 0.4, 0.1, 0.0, 0.0, 0.2, 0.0]
    finger.reset()
    depths = [finger.step_force(force, 5e-3).depth for force in forces]
    assert depths[:2] == [0.0, 0.0]
    assert depths[2] > 0
    finger.reset()
    again = [finger.step(depth, 5e-3).force for depth in depths]
    assert again == pytest.approx(forces, rel=1e-6, abs=1e-12)


def test_going_deeper_than_said_gets_a_sentence(finger: Condensed) -> None:
    with pytest.raises(InputError, match="contact at their rim"):
        finger.step(3.0, 1e-3)


@pytest.mark.parametrize(
    "indenter", [ff.Bar(2.0, 0.5, roll=20), ff.Bar(2.0, 1.0), ff.Grating(4.0, 2.0, 2.0)]
)
def test_an_edge_is_answered_to_the_depth_that_was_said(indenter: ff.Bar | ff.Grating) -> None:
    """Beside an edge the gap grows within a facet to more than any reach."""
    finger = Condensed(FINGER, indenter, deepest=1.2)
    scene = ff.Scene(
        finger=FINGER, indenter=indenter, motion=ff.Ramp(10.0, 1.2), ask=ff.Ask(fields=False)
    )
    expected = condensed.respond(scene)
    found = along(finger, scene.motion, expected.time)
    assert found["force"] == pytest.approx(expected.force, rel=1e-9, abs=1e-12)


def test_an_edge_along_the_finger_is_answered_to_the_depth_that_was_said() -> None:
    """Its candidates reach the end of the palmar part, beside which they still have to grow."""
    finger = Condensed(FINGER, ff.Bar(2.0, 0.5, roll=90), deepest=2.0)
    force = [finger.step(depth, 1e-3).force for depth in (0.5, 1.0, 1.5, 2.0)]
    assert (np.diff(force) > 0).all()


def test_where_the_indenter_ends_and_where_the_pad_ends_are_told_apart() -> None:
    lines = np.linspace(-2.0, 2.0, 9)
    tile = Condensed(FINGER, ff.Relief.of(lambda x, y: 0 * x * y, lines, lines), deepest=1.2)
    with pytest.raises(InputError, match="beyond which the indenter turns away"):
        tile.step(1.0, 1e-3)
    with pytest.raises(InputError, match=r"deepest: expected a depth .* received 2 mm"):
        Condensed(FINGER, ff.Flat(60), deepest=2.0)

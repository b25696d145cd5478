"""The mechanics `linear` on a coarse finger: balance, symmetry, relaxation, refusals."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

import fefinger as ff
from fefinger.afferents import fire
from fefinger.mechanics import linear
from fefinger.mechanics.evidence.presses import largest_exponents
from fefinger.mechanics.press import problem, small_strain, time_steps
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Response
from fefinger.scene import library
from fefinger.scene.motion import Motion
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony
from fefinger.view import quantities


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
PRESS = ff.RampHold(speed=60, depth=1.0, hold=0.5)
ASK = ff.Ask(fields=False)


def scene(**parts: object) -> ff.Scene:
    given = {"finger": FINGER, "indenter": ff.Flat(angle=30), "motion": PRESS, "ask": ASK}
    return ff.Scene(**(given | parts))


@pytest.fixture(scope="module")
def press() -> Response:
    return linear.respond(scene())


def test_a_whole_finger_made_of_two_halves_equals_the_half(
    press: Response, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ff.Flat, "mirrored", False)
    whole = linear.respond(scene())
    assert (whole.numbers["half"], press.numbers["half"]) == (0, 1)
    assert whole.force == pytest.approx(press.force, rel=1e-8, abs=1e-10)
    assert whole.contact_area == pytest.approx(press.contact_area, rel=1e-8)
    assert whole.strain == pytest.approx(press.strain, rel=1e-7, abs=1e-9)
    assert whole.centroid[1:] == pytest.approx(press.centroid[1:], abs=1e-7, nan_ok=True)


def test_the_mirror_image_of_a_scene_gives_the_mirror_image_of_the_answer() -> None:
    left, right = (
        linear.respond(scene(indenter=ff.Flat(angle=30, tilt=tilt), motion=ff.Ramp(60, 0.6)))
        for tilt in (10.0, -10.0)
    )
    assert left.centroid[-1, 1] > 0.2  # tilted up, it touches on the side of positive y
    assert left.force == pytest.approx(right.force, rel=1e-6, abs=1e-9)
    mirror = np.diag([1.0, -1.0, 1.0])
    assert left.centroid[1:, 1] == pytest.approx(-right.centroid[1:, 1], abs=1e-5, nan_ok=True)
    reflected = mirror @ right.strain @ mirror
    assert left.strain == pytest.approx(reflected, abs=1e-5 * np.abs(right.strain).max())


@pytest.mark.parametrize("tilt", [0.0, 20.0])
def test_the_area_does_not_depend_on_where_the_patch_ends(
    tilt: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = scene(indenter=ff.Flat(30, tilt), ask=ff.Ask(fields=False, strain=False))
    found = []
    for reach in (1.1, 2.0):
        monkeypatch.setattr(problem, "REACH", reach)
        found.append(linear.respond(asked))
    near, far = found
    assert near.numbers["candidates"] < far.numbers["candidates"]
    np.testing.assert_allclose(near.contact_area, far.contact_area, rtol=1e-4)


@pytest.mark.parametrize("bar", [ff.Bar(3.0, 1.0), ff.Bar(2.0, 1.0, roll=30), ff.Bar(2.0, 0.3)])
def test_contact_that_ends_at_an_edge_is_solved(bar: ff.Bar) -> None:
    """Gaps grow beside an edge within a facet to any reach; it was given up after four patches."""
    found = linear.respond(scene(indenter=bar, motion=ff.Ramp(100.0, 0.5, corner=0.0)))
    assert found.force[-1] > 0


def test_the_centroid_is_where_the_moment_puts_the_force() -> None:
    """With pressure at the vertices alone it was .07 mm away."""
    found = linear.respond(scene(indenter=ff.Flat(0), motion=ff.Ramp(60, 0.1, corner=0.0)))
    pressed = found.force > 0.2 * found.force.max()
    lever = found.moment[pressed, 1] / found.force[pressed]
    assert np.abs(lever) == pytest.approx(np.abs(found.centroid[pressed, 0]), abs=2e-3)


def test_strain_is_constant_in_the_hold_and_nothing_pulls(press: Response) -> None:
    holding = press.time >= PRESS.duration - PRESS.hold
    strain = press.strain[holding]
    assert np.ptp(strain, axis=0).max() < 1e-6 * np.abs(strain).max()
    assert press.pressure.min() == 0
    assert press.pressure[holding].max() > 1


def test_force_control_reaches_the_force_and_creeps() -> None:
    pressed = linear.respond(scene(motion=ff.RampHold(loading_rate=5, force=0.3, hold=1.0)))
    assert (pressed.time[0], pressed.force[0], pressed.depth[0]) == (0.0, 0.0, 0.0)
    holding = pressed.time >= pressed.time[-1] - 1.0
    assert pressed.force[holding] == pytest.approx(np.full(holding.sum(), 0.3), rel=1e-8)
    assert (np.diff(pressed.depth[holding]) > -1e-9).all()
    assert pressed.depth[-1] > 1.1 * pressed.depth[holding][0]


def test_spike_counts_survive_halving_the_time_step() -> None:
    asked = replace(ASK, spikes=("SAI", "SAII", "FAI", "FAII"))
    pressed = scene(motion=ff.RampHold(speed=60, depth=1.5, hold=1.0), ask=asked)
    counts = []
    for refine in (1, 2):
        response = small_strain.respond(pressed, mechanics="linear", notes=(), refine=refine)
        counts.append(fire(pressed.ask, response).count().tolist())
    assert counts[0] == counts[1]
    assert min(counts[0]) >= 1


def test_spikes_are_checked_on_the_next_coarser_mesh_if_there_is_one() -> None:
    standard = replace(FINGER, resolution="standard")
    assert linear.coarser(scene(finger=standard)) == FINGER
    assert linear.coarser(scene()) is None


BAD = [
    ({"motion": ff.Ramp(60, 4.9)}, "tissue over the bone"),
    ({"ask": replace(ASK, depths={"FAII": 4.9})}, "expected a point in the soft tissue"),
]


@pytest.mark.parametrize(("parts", "message"), BAD)
def test_what_cannot_be_answered_gets_a_sentence(parts: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        linear.respond(scene(**parts))


def test_what_is_not_asked_is_none() -> None:
    asked = ff.Ask(pressure=False, strain=False, fields=False)
    bare = linear.respond(scene(ask=asked))
    for absent in ("pad", "pressure", "contact_area", "centroid", "sites", "strain", "fields"):
        assert getattr(bare, absent) is None


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"indenter": ff.Sphere(radius=0.3)}, "no press like it was measured"),
        ({"motion": ff.Ramp(60, 2.6)}, "it goes to 0.26 of the finger's thickness"),
    ],
)
def test_where_it_was_not_compared_its_error_is_not_known(parts: dict, words: str) -> None:
    error, source = linear.error(Situation.of(scene(**parts)))
    assert np.isnan(error)
    assert words in source


def test_an_indenter_that_the_mesh_does_not_resolve_is_never_answered_silently() -> None:
    tiny = scene(indenter=ff.Sphere(radius=0.5), motion=ff.Ramp(60, 1.0))
    with pytest.raises(InputError, match="a finer mesh"):
        linear.respond(tiny)


@pytest.fixture(params=["ramp", "hold", "sinusoid"])
def motion(request: pytest.FixtureRequest) -> Iterator[Motion]:
    return {
        "ramp": ff.Ramp(speed=60, depth=1.0),
        "hold": ff.RampHold(speed=60, depth=1.0, hold=5.0),
        "sinusoid": ff.RampSinusoid(20, 1.0, amplitude=0.1, frequency=200, cycles=4),
    }[request.param]


@pytest.mark.parametrize("fast", [True, False])
def test_time_steps_follow_the_motion(motion: Motion, fast: bool) -> None:
    grid = time_steps.time_grid(motion, fast=fast)
    assert grid[0] == 0
    assert grid[-1] == pytest.approx(motion.duration)
    assert (np.diff(grid) > 0).all()
    assert np.diff(grid).max() <= time_steps.RESTING_STEP * 1.001
    middle = (grid[1:] + grid[:-1]) / 2
    limit = time_steps.FAST_STEP if fast else time_steps.MOVING_STEP
    for start, stop in motion.moving:
        moving = (middle > start) & (middle < stop)
        assert np.diff(grid)[moving].max() <= limit * 1.001
    for corner in motion.breakpoints:
        assert np.abs(grid - corner).min() < 1e-9


@pytest.mark.parametrize("fast", [True, False])
def test_a_part_begins_with_short_steps_however_long_it_is(fast: bool) -> None:
    limit = time_steps.FAST_STEP if fast else time_steps.MOVING_STEP
    for long in (2.0, 100.0, 1e6):
        for after in (0.5, 0.5 + 1e-3 * long):  # mm: a rest, and a slow ramp after a fast one
            motion = ff.Sampled((0.0, 0.05, 0.05 + long), (0.0, 0.5, after))
            grid = time_steps.time_grid(motion, fast=fast)
            steps = np.diff(grid[grid > 0.05 - 1e-9])
            assert (steps > 0).all()
            assert steps[0] <= limit * 1.001
            assert (steps[1:] < 1.3 * steps[:-1]).all()
            assert len(steps) < 350 + min(long, time_steps.LONG) / limit


@pytest.mark.parametrize("tissue", sorted(filter(library.fitted_to, library.TISSUE_SETS)))
def test_the_tissue_of_no_subject_is_beyond_what_was_measured_and_a_stiffer_one_is(tissue):
    finger = ff.Finger.subject("a.h.", tissue=tissue)
    assert not list(linear.unmeasured(finger))
    most = largest_exponents()["skin"]
    stiffer = replace(finger, skin=replace(finger.skin, exponent=1.01 * most))
    assert [reason.field for reason in linear.unmeasured(stiffer)] == ["finger.skin"]


@pytest.mark.parametrize(("poisson", "mechanics"), [(0.4999, "linear"), (0.48, "solid")])
def test_the_energy_density_adds_up_to_the_work_on_elastic_tissue(
    poisson: float, mechanics: str
) -> None:
    """The strain at the mesh points times K would be 8 times the work at 0.4999."""
    layers = {k: replace(getattr(FINGER, k), poisson=poisson) for k in ("skin", "subcutaneous")}
    finger = replace(FINGER, prony=Prony((1.0,), ()), **layers)
    ramp = ff.Ramp(speed=20, depth=0.5, corner=0.0)
    result = ff.run(
        scene(finger=finger, motion=ramp, ask=ff.Ask(strain=False)), mechanics=mechanics
    )
    fields = result.fields
    assert fields is not None
    corners = fields.points[fields.cells]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
    for field in ("relaxed strain energy", "elastic strain energy"):
        density = quantities.values(result, field, -1)
        soft = fields.region < 3
        stored = 2e-3 * (volume * density[fields.cells].mean(axis=1))[soft].sum()  # both halves, mJ
        assert stored == pytest.approx(np.trapezoid(result.force, result.depth), rel=5e-3)

"""Mechanics `modal`: limits, bad input, and the planner's use of it."""

import dataclasses
import wave
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from damage import flip
from fefinger.validation.waves import preload
from fefinger.validation.waves.measure import pressed_force
from fefinger.validation.waves.preload import Preloaded
from refusals import refused

import fefinger as ff
from fefinger.fem.modes import Modes
from fefinger.mechanics import condensed, modal, pressed
from fefinger.mechanics.evidence import costs, vibration
from fefinger.mechanics.press import depth_table, modal_body, operator_cache
from fefinger.mechanics.press.modal_press import RINGING, modal_grid
from fefinger.mechanics.press.operator_cache import MODES
from fefinger.mechanics.press.placement import obstacle
from fefinger.mechanics.situation import Situation
from fefinger.mesh.store import load_or_build
from fefinger.scene import builtin
from fefinger.scene.cautions import coarse_samples
from fefinger.studies.tables import dynamic_stiffness
from fefinger.support import cache
from fefinger.support.checks import InputError
from fefinger.support.tensors import tensor_from_voigt


def scene(motion: ff.FrequencySweep | ff.RampHold | ff.Sampled, **ask: object) -> ff.Scene:
    outputs = {"pressure": False, "fields": False, "strain": True, "rel_error": 0.3} | ask
    return ff.Scene(finger=FINGER, motion=motion, ask=ff.Ask(**outputs))


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse")

pytestmark = pytest.mark.usefixtures("module_operators")


@pytest.fixture(scope="module")
def whole() -> ff.Loop:
    return ff.Loop(FINGER, ff.Flat(30), mechanics="modal", deepest=1.2)


@pytest.fixture
def loop(whole: ff.Loop) -> ff.Loop:
    whole.reset()
    return whole


@pytest.fixture(scope="module")
def vibrations(whole: ff.Loop) -> ff.Vibrations:
    return ff.Vibrations.of(whole.prepared, deepest=1.2)


def test_a_slow_press_by_force_is_that_of_condensed() -> None:
    slow = scene(ff.RampHold(loading_rate=1.0, force=0.4, hold=0.5))
    one, other = condensed.respond(slow), modal.respond(slow)
    force = np.interp(one.time, other.time, other.force)
    depth = np.interp(one.time, other.time, other.depth)
    assert force == pytest.approx(one.force, abs=2e-3 * one.force.max())
    assert depth == pytest.approx(one.depth, abs=2e-3 * one.depth.max())
    assert other.strain[-1] == pytest.approx(one.strain[-1], abs=1e-3 * np.abs(one.strain).max())


def test_a_slow_press_of_stiffening_tissue_is_that_of_pressed() -> None:
    slow = builtin.load(
        "flat-press", {"finger.resolution": "coarse", "motion.speed": 5, "motion.hold": 0.2}
    )
    one, other = pressed.respond(slow), modal.respond(slow)
    assert np.interp(one.time, other.time, other.force) == pytest.approx(
        one.force, abs=3e-3 * one.force.max()
    )
    assert other.finite
    assert not dataclasses.replace(other, numbers={}).finite
    assert any("times the moduli" in note for note in other.notes)


def test_stiffening_tissue_about_a_depth_at_which_no_vertex_is_touched_is_refused() -> None:
    light = builtin.load("flat-press", {"finger.resolution": "coarse"})
    motion = ff.Vibration(preload=0.02, amplitude=0.005, frequency=100, seconds=0.02, held=0.01)
    light = dataclasses.replace(light, indenter=ff.Sphere(5.0), motion=motion)
    with pytest.raises(InputError, match="smaller than a facet"):
        modal.respond(light)


@pytest.mark.parametrize(("tissue", "base"), [("maeno1998", condensed), ("calibrated_ah", pressed)])
def test_the_fields_of_a_slow_press_are_those_without_inertia(
    tissue: str, base: ModuleType
) -> None:
    finger = ff.Finger.subject("a.h.", tissue=tissue, resolution="coarse")
    motion = ff.RampHold(2.0, 0.8, hold=0.3)
    slow = ff.Scene(finger=finger, motion=motion, ask=ff.Ask(pressure=False, strain=False))
    one, other = base.respond(slow).fields, modal.respond(slow).fields
    for name in ("displacement", "strain"):
        still, moving = getattr(one, name)[-1], getattr(other, name)[-1]
        np.testing.assert_allclose(moving, still, atol=2e-3 * np.abs(still).max())


def test_damaged_modes_are_computed_again(
    vibrations: ff.Vibrations, monkeypatch: pytest.MonkeyPatch
) -> None:
    identity = operator_cache.identity(FINGER, odd=False)
    used = operator_cache.modes_folder(FINGER, identity)
    computed, stored = [], cache.load(used, modal_body._read)

    def counted(*given: Any) -> Modes:
        computed.append(given)
        return stored

    monkeypatch.setattr(modal_body, "modes_of", counted)
    flip(used / "squares.npy")
    again = ff.Vibrations(vibrations.finger, ff.Flat(30), deepest=1.2)
    assert again.frequencies == pytest.approx(vibrations.frequencies, rel=1e-9)
    assert len(computed) == 1


def test_heavier_tissue_swings_more_slowly_with_the_modes_that_are_there(
    vibrations: ff.Vibrations, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = sorted((kept / "fefinger" / "modes").iterdir())
    heavy = dataclasses.replace(
        vibrations.finger,
        skin=dataclasses.replace(vibrations.finger.skin, density=4400),
        subcutaneous=dataclasses.replace(vibrations.finger.subcutaneous, density=4400),
    )
    slow = ff.Vibrations(heavy, ff.Flat(30), deepest=1.2)
    assert slow.frequencies == pytest.approx(vibrations.frequencies / 2, rel=1e-9)
    assert sorted((kept / "fefinger" / "modes").iterdir()) == before
    monkeypatch.setattr(modal_body, "modes_of", None)
    heavy_skin = dataclasses.replace(heavy, subcutaneous=vibrations.finger.subcutaneous)
    with pytest.raises(TypeError, match="not callable"):  # its modes are not there
        ff.Vibrations(heavy_skin, ff.Flat(30), deepest=1.2)


def test_a_rest_in_the_loop_is_that_of_condensed(loop: ff.Loop) -> None:
    still = ff.Loop(FINGER, ff.Flat(30), mechanics="condensed", deepest=1.2, sites=loop.sites)
    one, other = still.step(2.0, depth=0.7), loop.rest(2.0, depth=0.7)
    assert other.force == pytest.approx(one.force, rel=1e-9)
    for name in ("strain", "pressure"):
        expected = getattr(one, name)
        scale = np.abs(expected).max()
        assert getattr(other, name) == pytest.approx(expected, abs=1e-9 * scale), name


def test_it_is_built_with_progress(loop: ff.Loop) -> None:
    seen: list[tuple[str, float]] = []
    ff.Vibrations(FINGER, deepest=1.2, progress=lambda stage, done: seen.append((stage, done)))
    assert [stage for stage, done in seen if done == 0.0] == ["factor", "modes"]


def test_a_harmonic_answer_is_a_dataset_with_units(vibrations: ff.Vibrations) -> None:
    answer = vibrations.harmonic([20.0, 200.0], depth=0.8)
    table = answer.to_xarray()
    stiffness = table["dynamic_stiffness"]
    assert stiffness.attrs["units"] == "N/mm"
    parts = stiffness.sel(part="real") + 1j * stiffness.sel(part="imaginary")
    assert parts.values == pytest.approx(answer.stiffness)
    assert table["frequency"].values == pytest.approx([20.0, 200.0])
    assert table.attrs["preload_depth_mm"] == 0.8


def test_units_fire_in_the_loop(loop: ff.Loop) -> None:
    units, fired = loop.afferents(), np.zeros(len(loop.sites.types))
    loop.rest(10.0, depth=0.5)
    for k in range(3000):
        step = loop.step(1e-4, depth=0.5 + 0.1 * np.sin(2 * np.pi * 200 * k * 1e-4))
        units.step(step.strain, 1e-4)
        fired[[unit for unit, _ in units.fired()]] += 1
    assert fired[loop.sites.types.index("FAII")] > 20


def test_in_a_loop_and_as_a_scene_it_is_the_same(loop: ff.Loop) -> None:
    motion = ff.RampHold(40.0, 0.8, hold=0.02)
    whole = modal.respond(scene(motion))
    steps = modal_grid(motion, fast=False)
    forces = [0.0]
    for dt, t in zip(np.diff(steps.time), steps.time[1:], strict=True):
        forces.append(loop.step(float(dt), depth=float(motion.value(t))).force)
    assert np.array(forces)[steps.stored] == pytest.approx(whole.force, abs=5e-3)


def test_a_long_step_is_divided_so_that_all_modes_follow(loop: ff.Loop) -> None:
    """A press at 400 mm/s in steps of 1 ms equals one in steps of 0.1 ms, and not statics."""
    whole, still = [], ff.Loop(FINGER, ff.Flat(30), mechanics="condensed", deepest=1.2)
    for dt, finger in ((1e-4, loop), (1e-3, loop), (1e-3, still)):
        finger.reset()
        depths = np.minimum(400.0 * dt * np.arange(1, round(8e-3 / dt) + 1), 0.8)
        whole.append([finger.step(dt, depth=depth).force for depth in depths.tolist()])
    fine, coarse, static = whole
    assert coarse == pytest.approx(fine[9::10], rel=1e-9)
    assert np.abs(np.subtract(coarse, static)).max() > 0.02 * static[-1]
    assert len(loop.prepared.body.oscillators.omega_squared) == len(loop.prepared.modes.frequencies)


def test_a_long_step_that_is_refused_midway_leaves_the_finger_as_it_was(loop: ff.Loop) -> None:
    loop.step(1e-3, depth=0.4)
    before = loop.now.depth, loop.now.force
    with pytest.raises(InputError, match="contact at their rim"):
        loop.step(1e-3, depth=3.0)
    again = loop.restore(loop.state())
    assert (again.depth, again.force) == pytest.approx(before, rel=1e-12)


def test_a_force_is_reached_and_contact_opens_and_closes(loop: ff.Loop) -> None:
    for force in (0.1, 0.3, 0.0, 0.0, 0.2):
        assert loop.step(1e-4, force=force).force == pytest.approx(force, rel=1e-6, abs=1e-12)
    loop.reset()
    forces = [
        loop.step(1e-4, depth=0.2 + 0.5 * np.sin(2 * np.pi * 100 * k * 1e-4)).force
        for k in range(300)
    ]
    assert min(forces) == 0.0 < max(forces)


def test_a_preload_is_the_same_by_depth_and_by_force(vibrations: ff.Vibrations) -> None:
    frequency = [20.0, 200.0]
    by_depth = vibrations.harmonic(frequency, depth=0.8)
    by_force = vibrations.harmonic(frequency, force=by_depth.preload_force)
    assert by_force.preload_depth == pytest.approx(0.8, rel=1e-6)
    assert by_force.stiffness == pytest.approx(by_depth.stiffness, rel=1e-6)
    angle, amplitude = np.linspace(0, 2 * np.pi, 2001)[:, None], 0.02
    force = (by_depth.stiffness * amplitude * np.exp(1j * angle)).imag
    work = np.trapezoid(force, amplitude * np.sin(angle), axis=0)  # mJ
    assert by_depth.dissipated_energy(amplitude) == pytest.approx(1e3 * work, rel=1e-5)
    assert by_depth.impedance.real == pytest.approx(
        1e3 * by_depth.stiffness.imag / (2 * np.pi * by_depth.frequency)
    )


def test_a_slow_oscillation_strains_as_the_relaxed_finger_does_between_two_depths(
    vibrations: ff.Vibrations,
) -> None:
    still = ff.Loop(FINGER, ff.Flat(30), mechanics="condensed", deepest=1.2, sites=vibrations.sites)
    middle, apart, relaxed = 0.8, 1e-5, []  # mm; too close for a vertex to come into contact
    for depth in (middle - apart, middle + apart):
        still.reset()
        relaxed.append(tensor_from_voigt(still.step(1e6, depth=depth).strain))
    slope = (relaxed[1] - relaxed[0]) / (2 * apart)
    strain = vibrations.harmonic([1e-4], depth=middle).strain[0]
    assert strain.real == pytest.approx(slope, abs=2e-3 * np.abs(slope).max())
    assert np.abs(strain.imag).max() < 2e-3 * np.abs(slope).max()


def test_the_skin_under_the_plate_moves_with_it(vibrations: ff.Vibrations) -> None:
    axis = obstacle(ff.Flat(30), vibrations.vibrating.solid).axis
    found = vibrations.harmonic([0.1, 100.0], depth=0.8)
    middle = np.argmin(np.linalg.norm(found.skin_points, axis=1))
    assert found.skin[:, middle] @ axis == pytest.approx([1.0, 1.0], abs=0.02)


def test_a_preload_is_answered_alike_after_any_other(vibrations: ff.Vibrations) -> None:
    vibrations.__dict__.pop("vibrating", None)
    frequency, depths = [20.0, 200.0], (0.4, 1.0, 0.7)  # first, of more nodes, of fewer again
    _, *before = (vibrations.harmonic(frequency, depth=depth) for depth in depths)
    for found, depth in zip(before, depths[1:], strict=True):
        vibrations.__dict__.pop("vibrating")
        alone = vibrations.harmonic(frequency, depth=depth)
        for name in ("stiffness", "strain", "skin", "error"):
            one, other = getattr(found, name), getattr(alone, name)
            assert np.abs(one - other).max() < 1e-9 * np.abs(other).max(), name


@pytest.mark.parametrize(
    "motion",
    [
        ff.RampSinusoid(20, 0.3, amplitude=0.35, frequency=100, cycles=3),
        ff.Sampled((0.0, 0.005, 0.01, 0.02, 0.025, 0.04), (0.0, 0.5, -0.2, -0.2, 0.5, 0.0)),
    ],
    ids=["vibration", "taps"],
)
def test_stiffening_tissue_bears_no_force_without_contact(motion: ff.Sampled) -> None:
    finger = ff.Finger.subject("a.h.", resolution="coarse")
    ask = ff.Ask(strain=False, fields=False)
    answer = modal.respond(ff.Scene(finger=finger, motion=motion, ask=ask))
    borne = 1e-3 * answer.pressure @ answer.pad.areas
    assert borne == pytest.approx(answer.force, abs=1e-9 * answer.force.max())
    assert answer.force.min() == 0
    assert np.array_equal(answer.force > 0, answer.contact_area > 0)
    assert answer.force[answer.depth < 0].max() == 0
    assert any("still touches the object" in note for note in answer.notes)


@pytest.mark.parametrize(
    ("frequency", "preload", "sentence"),
    [
        ([3000.0], {"depth": 0.8}, f"of the frequency of the last of {MODES} modes"),
        ([0.0, 10.0], {"depth": 0.8}, "above 0 Hz"),
        ([10.0], {}, "a depth in mm or a force in N"),
        ([10.0], {"depth": 3.0}, "at most 1.2"),
        ([10.0], {"force": 30.0}, "rim"),
        ("a", {"depth": 0.8}, r"frequency\[0\]: expected a finite number, received 'a'"),
        (1j, {"depth": 0.8}, r"frequency\[0\]: expected a finite number, received 1j"),
        ([20.0, "a"], {"depth": 0.8}, r"frequency\[1\]: expected a finite number, received 'a'"),
    ],
)
def test_a_harmonic_answer_that_cannot_be_given_is_a_sentence(
    vibrations: ff.Vibrations, frequency: Any, preload: dict[str, float], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        vibrations.harmonic(frequency, **preload)


def test_a_mode_is_one_cycle_of_its_frequency_on_the_mesh(
    vibrations: ff.Vibrations, tmp_path: Path
) -> None:
    fields = vibrations.shape(2, frames=8)
    assert fields.times[-1] == pytest.approx(7 / 8 / vibrations.frequencies[2])
    assert np.linalg.norm(fields.displacement[0], axis=1).max() <= 1.0
    np.testing.assert_allclose(fields.displacement[4], -fields.displacement[0], atol=1e-12)
    vibrations.save_shape(tmp_path / "mode.vtkhdf", 0)
    assert (tmp_path / "mode.vtkhdf").stat().st_size > 1000
    with pytest.raises(InputError, match=f"expected a number from 0 to {MODES - 1}"):
        vibrations.shape(MODES)


def test_delays_are_those_of_the_phase(vibrations: ff.Vibrations) -> None:
    found = vibrations.harmonic(np.geomspace(1.0, 100.0, 60), depth=0.8)
    for site, delay in enumerate(found.site_delay().T):
        strain = found.strain[:, site].reshape(60, 9)
        largest = strain[:, np.abs(strain).sum(axis=0).argmax()]
        turned = largest * np.exp(2j * np.pi * found.frequency * delay)
        assert np.abs(np.angle(turned * np.sign(largest[0].real))).max() < 1e-9
    moved = found.skin[:, np.argmin(np.abs(found.skin_points[:, 0])), :]
    delay = found.skin_delay()[:, np.argmin(np.abs(found.skin_points[:, 0]))]
    largest = np.abs(moved).sum(axis=0).argmax()
    turned = moved[:, largest] * np.exp(2j * np.pi * found.frequency * delay)
    assert np.abs(np.angle(turned * np.sign(moved[0, largest].real))).max() < 1e-9


def test_delays_do_not_depend_on_the_order_of_the_frequencies(vibrations: ff.Vibrations) -> None:
    rising = np.geomspace(5.0, 800.0, 60)
    up, down = (vibrations.harmonic(each, depth=0.5) for each in (rising, rising[::-1]))
    for one, other in ((up.site_delay, down.site_delay), (up.skin_delay, down.skin_delay)):
        assert other()[::-1] == pytest.approx(one(), abs=1e-9)


def test_a_sweep_has_its_harmonic_answer_and_says_where_contact_opens() -> None:
    calm, wild = (
        scene(ff.FrequencySweep(0.3, amplitude=a, start=20, stop=200, seconds=0.1, settle=0.05))
        for a in (0.001, 0.2)
    )
    one, other = modal.respond(calm), modal.respond(wild)
    assert len(one.harmonic.frequency) == 200
    still = ff.run(calm, mechanics="condensed")
    assert still.harmonic is None
    assert any("No harmonic response" in note for note in still.notes)
    assert one.harmonic.preload_depth == pytest.approx(0.3)
    assert not any("mid-cycle" in note for note in one.notes)
    assert any("mid-cycle" in note for note in other.notes)
    assert any("Contact is lost" in note for note in other.notes)


def test_a_pin_has_its_harmonic_answer_of_a_loop_and_of_a_sweep() -> None:
    """Its edge leaves no gap around it that a larger reach would bridge."""
    sweep = ff.FrequencySweep(0.4, amplitude=0.001, start=20, stop=200, seconds=0.1, settle=0.05)
    scanned = dataclasses.replace(scene(sweep), indenter=ff.Pin(2.0))
    vibrations = ff.Vibrations(scanned.finger, scanned.indenter, deepest=0.5)
    found = vibrations.harmonic([1e-6, 20.0], depth=0.4)
    assert modal.respond(scanned).harmonic.stiffness[0] == pytest.approx(found.stiffness[1])
    still = ff.Loop(FINGER, scanned.indenter, mechanics="condensed", deepest=0.5)
    for _ in range(2):  # at rest
        less, more = (still.step(1e9, depth=depth).force for depth in (0.399, 0.401))
    assert found.stiffness[0].real == pytest.approx((more - less) / 0.002, rel=1e-3)


def test_a_sweep_stays_in_contact_by_its_fields() -> None:
    with refused("motion.amplitude"):
        ff.FrequencySweep(0.3, amplitude=0.3, start=20, stop=200)


@pytest.mark.parametrize(
    ("name", "changes", "chosen"),
    [
        ("vibration-200Hz", {}, "modal"),
        ("vibration-200Hz", {"motion.frequency": 2}, "pressed"),
        ("flat-press", {}, "pressed"),
        ("flat-press", {"finger.relaxation": "deviatoric", "motion.speed": 1000}, "solid"),
    ],
)
def test_it_is_taken_where_inertia_matters_and_not_otherwise(
    name: str, changes: dict[str, object], chosen: str
) -> None:
    assert ff.choose(builtin.load(name, changes)).mechanics == chosen


def test_it_neither_slides_nor_rubs() -> None:
    rough = dataclasses.replace(
        scene(ff.RampHold(20, 0.5, hold=0.1)), indenter=ff.Flat(30, friction=0.5)
    )
    assert any(refusal.about == "ability" for refusal in modal.refuse(Situation.of(rough)))


def test_the_error_of_statics_grows_with_frequency_and_speed() -> None:
    errors = []
    for frequency in (2.0, 20.0, 60.0, 200.0):
        case = Situation.of(builtin.load("vibration-200Hz", {"motion.frequency": frequency}))
        errors.append(vibration.statics_error(case)[0])
    assert errors == sorted(errors)
    assert errors[0] < 0.01 < errors[-1]


@pytest.mark.parametrize(
    ("speed", "corner", "part"),
    [(100.0, 0.0, 0.1), (50.0, 0.01, 50 * 1e-3**2 / (8 * 0.01)), (1e9, 0.0, 8.0)],
    ids=["sharp", "rounded", "jump"],
)
def test_suddenness_is_the_change_of_speed_in_an_eighth_of_a_cycle(
    speed: float, corner: float, part: float
) -> None:
    motion = ff.RampHold(speed, 1.0, hold=0.2, corner=corner)
    assert vibration.suddenness(motion, 1e-3) == pytest.approx(part, rel=1e-9)
    ringing = ff.RampSinusoid(
        speed, 1.0, amplitude=0.1, frequency=100, cycles=20, settle=0.2, corner=corner
    )
    assert vibration.suddenness(ringing, 1e-3) == pytest.approx(part / 1.1, rel=1e-9)


@pytest.mark.parametrize("corner", [0.0, 0.001], ids=["sharp", "rounded"])
def test_the_error_of_a_press_by_few_modes_is_within_what_is_stated(
    loop: ff.Loop, corner: float
) -> None:
    ball = ff.Sphere(4)  # no measured object
    made = ff.Loop(loop.finger, ball, mechanics="modal", deepest=0.9, substep=2e-5)
    all_modes = made.prepared.body
    few = all_modes.only(np.arange(60))
    motion = ff.RampHold(120.0, 0.8, hold=0.01, corner=corner)
    whole, rough = (pressed_force(body, motion, 2e-5) for body in (all_modes, few))
    sudden = vibration.suddenness(
        motion, float(2 * np.pi / few.oscillators.omega_squared[-1] ** 0.5)
    )
    error = np.abs(rough - whole).max() / whole.max()
    assert 0.005 < error < vibration.left_out_by_modes(sudden)


@pytest.mark.parametrize(
    ("motion", "field"),
    [
        (ff.RampHold(1e9, 1.0, hold=0.1), "motion.speed"),
        (ff.RampHold(loading_rate=1e9, force=0.5, hold=0.1), "motion.loading_rate"),
    ],
    ids=["depth", "force"],
)
def test_a_press_that_the_modes_cannot_follow_is_refused(motion: ff.RampHold, field: str) -> None:
    refused = {each.field: each.reason for each in modal.refuse(Situation.of(scene(motion)))}
    assert "the modes do not follow it" in refused[field]


def test_the_ramp_before_a_vibration_counts_in_the_error_of_statics() -> None:
    slow, fast = (
        Situation.of(
            builtin.load("vibration-200Hz", {"motion.frequency": 2, "motion.speed": speed})
        )
        for speed in (20, 2000)
    )
    assert vibration.statics_error(slow)[0] < 0.01
    assert vibration.statics_error(fast)[0] > 0.5


def test_samples_too_coarse_for_their_band_are_refused() -> None:
    time = np.arange(400) / 1000.0
    depth = 0.5 + 0.05 * np.sin(2 * np.pi * 180.0 * time)
    coarse = scene(ff.Sampled(tuple(time.tolist()), tuple(depth.tolist())))
    reasons = [refusal.reason for refusal in modal.refuse(Situation.of(coarse))]
    assert any("sample the motion more finely" in reason for reason in reasons)
    (warning,) = coarse_samples(coarse.motion)
    assert "5.4 samples per cycle of 185 Hz" in warning
    assert coarse_samples(ff.Sampled(tuple(time.tolist()), tuple(np.full(400, 0.5)))) == ()


def test_steps_are_short_while_the_finger_moves_and_rings_and_long_in_a_rest() -> None:
    motion = ff.RampHold(50.0, 1.0, hold=5.0)
    grid = modal_grid(motion, fast=False)
    lengths, starts = np.diff(grid.time), grid.time[:-1]
    quick = starts < 0.03 + RINGING
    assert lengths[quick].max() <= grid.longest
    assert lengths[~quick].max() > 0.01
    assert (np.diff(grid.time[grid.stored]) > 0).all()
    assert grid.time[grid.stored][-1] == pytest.approx(motion.duration)


def test_a_wave_file_is_a_vibration_about_a_preload(tmp_path: Path) -> None:
    samples = (20000 * np.sin(2 * np.pi * 250 * np.arange(800) / 8000)).astype("<i2")
    for name, data in (("hum", samples.tobytes()), ("silent", bytes(2 * len(samples)))):
        with wave.open(str(tmp_path / f"{name}.wav"), "wb") as file:
            file.setparams((1, 2, 8000, 0, "NONE", "not compressed"))
            file.writeframes(data)
    text = (
        '[finger]\nsubject = "a.h."\n[motion]\nkind = "sampled"\nfile = "hum.wav"\n'
        "amplitude = 0.02\npreload = 0.8\nsettle = 0.1\n"
    )
    (tmp_path / "hum.toml").write_text(text, encoding="utf-8")
    motion = ff.Scene.from_toml(tmp_path / "hum.toml").motion
    assert motion.value(0.0) == 0.0
    assert motion.value(0.15) == pytest.approx(0.8)
    assert motion.steady_level == pytest.approx(0.8, rel=0.01)
    assert motion.oscillation_amplitude == pytest.approx(0.02 * 20000 / 32768, rel=0.2)
    assert motion.peak == pytest.approx(0.8 + 0.02 * 20000 / 32768, rel=1e-3)
    assert 250.0 <= motion.highest_frequency < 350.0  # it starts and ends abruptly
    (tmp_path / "no.wav").write_bytes(b"hello")
    with pytest.raises(InputError, match="expected a WAV file"):
        ff.Sampled.from_file(tmp_path / "no.wav", amplitude=0.1, preload=1.0)
    with refused("motion.amplitude"):
        ff.Sampled.from_file(tmp_path / "hum.wav", preload=1.0)
    with pytest.raises(InputError, match="which is silent"):
        ff.Sampled.from_file(tmp_path / "silent.wav", amplitude=0.1, preload=1.0)


@pytest.mark.parametrize(
    ("relaxation", "damped"), [("", False), ("_viscous", True)], ids=["published", "viscous"]
)
def test_the_error_of_a_sweep_is_stated_and_says_what_damps(relaxation: str, damped: bool) -> None:
    finger = ff.Finger.subject("a.h.", tissue=f"calibrated_ah{relaxation}")
    motion = ff.FrequencySweep(1.0, amplitude=0.02, start=10, stop=600)
    case = Situation.of(ff.Scene(finger=finger, motion=motion))
    error, source = modal.error(case)
    base = pressed.error(case)[0]
    assert base < error < 1.0
    assert ("hardly damp" in source) is not damped
    below = Situation.of(ff.Scene(finger=finger, motion=dataclasses.replace(motion, stop=100)))
    assert vibration.vibration_error(below) < vibration.vibration_error(case)
    assert not any(refusal.field == "motion.frequency" for refusal in modal.refuse(case))


def test_a_frequency_beyond_the_measured_ones_is_a_sentence() -> None:
    motion = ff.FrequencySweep(1.0, amplitude=0.02, start=10, stop=2500)
    reasons = [
        refusal.reason
        for refusal in modal.refuse(Situation.of(scene(motion)))
        if refusal.field == "motion.frequency"
    ]
    assert len(reasons) == 1
    assert "stay below" in reasons[0]


def stress_share(finger: ff.Finger, depth: float) -> float:
    """Share of the stress at rest in the stiffness, by the work ratios of the table at a depth."""
    table = depth_table.available(finger, ff.Flat(30), load_or_build(finger, half=True))
    assert table is not None
    at = int(np.searchsorted(table.nodes, depth))
    soft, hard = table.force_at_nodes[[at - 3, at + 3]]
    return float(soft * (1 - table.work_at_nodes[at - 3, at + 3]) / (hard - soft))


def test_stiffening_tissue_vibrates_as_solid_linearized_about_its_preload(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(preload, "STEPS", 6)
    finger = ff.Finger.subject("a.h.", tissue="calibrated_ah_viscous", resolution="coarse")
    prepared = Preloaded.of(finger, 1.0)
    frequency = np.array([150.0])
    share = vibration.geometric_share(1.0 / finger.thickness)
    (exact,), (still,) = prepared.exact(finger, frequency), prepared.still(finger, frequency)
    assert prepared.linear(finger, frequency, share) == pytest.approx(exact, rel=0.05)
    assert sum(prepared.statics) == pytest.approx(prepared.secant(1e-3), rel=1e-4)
    # By two programs: the slope of the work of a stress, and the tangent of a preload.
    material = prepared.statics[0] / sum(prepared.statics)
    assert stress_share(finger, 1.0) == pytest.approx(material - 1, rel=0.3)
    # Smaller and larger than the distance of the depths between which the press is tabulated.
    for amplitude in (0.001, 0.03):
        motion = ff.RampSinusoid(20, 1.0, amplitude=amplitude, frequency=150, cycles=8, settle=100)
        ask = ff.Ask(pressure=False, strain=False, fields=False)
        vibrating = ff.Scene(finger=finger, motion=motion, ask=ask)
        errors = {}
        for mechanics in (modal, pressed):
            answer = mechanics.respond(vibrating)
            found = dynamic_stiffness(motion, answer.time, answer.depth, answer.force)
            errors[mechanics] = abs((found - exact) / still)
        stated = vibration.vibration_error(Situation.of(vibrating))
        assert errors[modal] < stated < errors[pressed]


def test_the_expected_time_of_stiffening_tissue_holds_the_modes_of_its_mesh(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On the fine mesh inertia is that of the standard one, not of the one below that."""
    monkeypatch.setattr(costs, "available", lambda finger, **_: False)
    finger = ff.Finger.subject("a.h.", resolution="fine")
    case = Situation.of(ff.Scene(finger=finger, motion=ff.Ramp(60.0, 1.0)))
    assert costs.modal_seconds(case) > costs.modal_once(case)

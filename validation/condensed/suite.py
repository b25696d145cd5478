"""Suite `condensed`: the condensed finger against `linear`, theory, energy and chance."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from fefinger.validation.case import Case, Expected, Row, tabled
from fefinger.validation.condensed import drawings
from fefinger.validation.oracles.layer import Sheet
from fefinger.validation.problems import published
from fefinger.validation.problems.half_space import HalfSpaceQuarter

from fefinger.contact import active_set
from fefinger.contact.frictionless import FrictionlessContact
from fefinger.mechanics import condensed, linear
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press import small_strain
from fefinger.results.records import Response
from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold, RampSinusoid, Trapezoid
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.contact.indentation import paraboloid
from fefinger.theory.contact.ting import press_by_depth, radius_nodes
from fefinger.theory.relaxation import Prony


SAME_MESH = replace(small_strain.WHOLE_MESH, touch=lambda indenter: None)
"""`linear` on the mesh of the operator, where its own would follow the touch."""

INCOMPRESSIBLE = "plate, Poisson's ratio 0.5"
PRESSES: dict[str, tuple[Indenter, Motion]] = {
    "plate, ramp and hold": (Flat(30), RampHold(60, 1.2, hold=1)),
    "tilted plate, in and out of contact": (
        Flat(15, 20),
        RampSinusoid(20, 0.5, amplitude=0.7, frequency=8, cycles=3),
    ),
    "sphere, off center, by force": (
        Sphere(5, at=(1, 1)),
        Trapezoid(loading_rate=2, force=0.3, hold=0.5),
    ),
    "sphere, in and out": (Sphere(5), Trapezoid(20, 0.8, hold=0.2)),
    INCOMPRESSIBLE: (Flat(30), RampHold(60, 1.2, hold=1)),
}
ELASTIC = Prony((1.0,), ())
STEPS, DT = 10_000, 1e-3
TRAJECTORIES, LENGTH = 1000, 40
BLOCK = {"radius": 100.0, "contact": 1.0, "modulus": 100.0}


@cache
def finger(resolution: str) -> Finger:
    """Return the finger of flat-press on a mesh."""
    return replace(published.load("flat-press").finger, resolution=resolution)


def pressed_finger(resolution: str, name: str) -> Finger:
    """Return the finger of one of the presses."""
    chosen = finger(resolution)
    if name != INCOMPRESSIBLE:
        return chosen
    skin, under = (replace(each, poisson=0.5) for each in (chosen.skin, chosen.subcutaneous))
    return replace(chosen, skin=skin, subcutaneous=under)


@cache
def stepped(resolution: str, prony: Prony | None = None, tilt: float = 0.0) -> Loop:
    """Return that finger under a plate, ready to be stepped."""
    chosen = finger(resolution)
    chosen = chosen if prony is None else replace(chosen, prony=prony)
    return Loop(chosen, Flat(30, tilt), mechanics="condensed", deepest=1.5)


def frictionless(pressed: Loop) -> FrictionlessContact:
    """Return the contact of a finger that is only pressed."""
    contact = pressed.prepared.contact
    assert isinstance(contact, FrictionlessContact)
    return contact


def roughly(tolerance: float) -> Loop:
    """Return the standard finger, with a tolerance of the contact."""
    rough = Loop(finger("standard"), Flat(30, 10.0), mechanics="condensed", deepest=1.5)
    frictionless(rough).tolerance = tolerance
    return rough


@cache
def answers(resolution: str, name: str) -> tuple[Response, Response]:
    """Responses of `linear` and `condensed` on one mesh."""
    indenter, motion = PRESSES[name]
    chosen = pressed_finger(resolution, name)
    scene = Scene(finger=chosen, indenter=indenter, motion=motion, ask=Ask(fields=False))
    exact = small_strain.respond(scene, mechanics=linear.name, notes=linear.NOTES, method=SAME_MESH)
    return exact, condensed.respond(scene)


def difference(resolution: str, name: str, quantity: str) -> float:
    """Return the largest difference in any step, over the largest value in that step."""
    exact, computed = (
        np.asarray(getattr(each, quantity)).reshape(len(each.time), -1)
        for each in answers(resolution, name)
    )
    scale = np.abs(exact).max(axis=1)
    significant = scale > 1e-6 * scale.max()
    return float((np.abs(computed - exact).max(axis=1)[significant] / scale[significant]).max())


@cache
def quarter(poisson: float, cells: int, thickness: float | None = None) -> HalfSpaceQuarter:
    """Return the block of this suite."""
    return HalfSpaceQuarter(**BLOCK, poisson=poisson, cells=cells, thickness=thickness)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure: in and out of a half-space, and ten thousand steps of a finger."""
    poisson, cells = 0.49, 4
    yield (
        "A ball pressed into a half-space within 0.1 s, held, and withdrawn within 0.15 s: the "
        f"condensed block (line; {cells} cells per contact radius, nu {poisson:g}) and Hertz's "
        "force with Ting's history (dots). The contact is lost before the ball is back.",
        drawings.half_space(*half_space(poisson, cells)),
    )
    tilt, time, depth = 10.0, np.arange(STEPS, dtype=np.float64) * DT, sweep()
    yield (
        f"{STEPS} steps of {1e3 * DT:g} ms by the condensed finger of a.h. (coarse mesh, a plate "
        f"at 30 degrees tilted by {tilt:g}): pressed, held, shaken at 8 Hz, left and touched "
        "again. The force relaxes and never pulls.",
        drawings.steps(time, depth, forces(stepped("coarse", tilt=tilt))),
    )


@cache
def half_space(poisson: float, cells: int) -> tuple[Array, Array, Array, Array]:
    """Return time in s, depth in mm, the force in mN of a press in and out, and the exact one.

    That is Hertz's elastic force with the solution of Ting for its history.
    """
    block, prony = quarter(poisson, cells), library.relaxation()["a.h."]
    deepest = block.contact**2 / block.radius
    time = np.concatenate([np.linspace(0, 0.1, 101), 0.1 + np.linspace(0.01, 0.4, 40)])
    time = np.concatenate([time, 0.5 + np.linspace(0.001, 0.15, 150)])
    depth = deepest * np.interp(time, [0, 0.1, 0.5, 0.6, 0.65], [0, 1, 1, 0, -0.5])
    nodes = radius_nodes(deepest)
    instant = np.array(
        [Hertz(block.radius, d, block.modulus, poisson).force if d > 0 else 0.0 for d in nodes]
    )
    exact = press_by_depth(prony, time, depth, nodes).stress(instant / prony.long_time)
    return time, depth, block.forces(prony, time, depth), exact


def hertz_error(poisson: float, cells: int, part: str) -> float:
    """Return the largest error of a press in and out of a half-space in %, over the peak."""
    time, _, computed, exact = half_space(poisson, cells)
    error = 100 * np.abs(computed - exact) / exact.max()
    chosen = time <= 0.5 if part == "loading" else time > 0.5
    return float(error[chosen].max())


def layer_error(poisson: float, cells: int) -> float:
    """Return the error in % of the force on a layer as thick as the contact radius."""
    block = quarter(poisson, cells, thickness=BLOCK["contact"])
    sheet = Sheet(block.contact, block.modulus, poisson)
    exact = paraboloid(sheet, block.radius, contact_radius=block.contact)
    (force,) = block.forces(ELASTIC, np.zeros(1), np.array([exact.depth]))
    return 100 * (float(force) / exact.force - 1)


def sweep() -> Array:
    """Return STEPS depths in mm: ramp, hold, 8 Hz sinusoid, retraction, and another touch."""
    times = np.arange(STEPS) * DT
    depth = np.interp(times, [0, 0.05, 8, 8.06, 8.5, 10], [0, 1, 1, -0.2, -0.2, 0.8])
    waving = (times >= 2) & (times < 8)
    depth[waving] += 0.4 * np.sin(2 * np.pi * 8 * (times[waving] - 2))
    return np.asarray(depth)


@cache
def swept(resolution: str) -> tuple[float, float, float]:
    """Return the lowest pressure in kPa, the deepest penetration over the depth, and a repeat.

    The penetration is that of the weighted gaps, made from the pressures anew. The repeat is the
    largest difference of the pressures in a second run.
    """
    pressed = stepped(resolution, tilt=10.0)
    on_pad, depths = pressed.prepared.on_pad.patch, sweep()
    lowest = deepest = 0.0
    runs: list[Array] = []
    for _ in range(2):
        pressed.reset()
        pressures = np.empty((STEPS, len(on_pad.vertices)))
        for k, depth in enumerate(depths.tolist()):
            pressures[k] = pressed.step(DT, depth=depth, strain=False).pressure
            if not runs:
                free = on_pad.gap - depth * on_pad.projected
                gaps = free + pressed.prepared.on_pad.flexibility @ pressed.prepared.contact.elastic
                deepest = max(deepest, float(-gaps.min() / np.abs(free).max()))
        runs.append(pressures)
    lowest = float(min(run.min() for run in runs))
    return lowest, deepest, float(np.abs(runs[0] - runs[1]).max())


def forces(pressed: Loop) -> Array:
    """Return the forces (STEPS,) of the sweep."""
    pressed.reset()
    return np.array(
        [pressed.step(DT, depth=depth, strain=False).force for depth in sweep().tolist()]
    )


@cache
def exact_forces() -> Array:
    """Return the forces of the sweep on the standard mesh."""
    return forces(stepped("standard", tilt=10.0))


def traded(rough: Loop) -> float:
    """Return the largest error of the force of something cheaper in %, over the peak."""
    exact = exact_forces()
    return float(100 * np.abs(forces(rough) - exact).max() / exact.max())


def work(resolution: str, prony: Prony | None) -> float:
    """Return the work on the whole finger that energy does not account for, over all of it.

    With s_k the pressure of Prony term k and w_k its weight over the long-time one, the work is
    the elastic energy q F q / 2, that of the terms s_k F s_k / 2 w_k, and what their dampers took:
    the integral of v_k s_k F s_k / w_k.
    """
    pressed = stepped(resolution, prony)
    contact = frictionless(pressed)
    time = np.linspace(0, 0.2, 4001)
    depth = 0.5 * (1 - np.cos(2 * np.pi * 12.5 * time)) * np.exp(-2 * time)
    force, stored, lost = np.empty_like(time), np.empty_like(time), np.empty_like(time)
    pressed.reset()
    for k, value in enumerate(depth.tolist()):
        step = float(time[k] - time[k - 1]) if k else 0.0
        force[k] = pressed.step(step, depth=value, strain=False).force / NEWTON_PER_MILLINEWTON
        stored[k], lost[k] = (pressed.solid.sides * each for each in contact.energy())
    done = float(np.sum((force[1:] + force[:-1]) / 2 * np.diff(depth)))
    turned = float(np.sum(np.abs(np.diff(depth)) * (force[1:] + force[:-1]) / 2))
    taken = float(np.sum((lost[1:] + lost[:-1]) / 2 * np.diff(time)))
    return (done - taken - (stored[-1] - stored[0])) / turned


@cache
def chance(resolution: str) -> tuple[float, float, float]:
    """Count failing random trajectories; also mean and largest rounds of exchange per step.

    Depths jump anywhere from off the finger to 1.2 mm, over 0.1 ms to 10 s.
    """
    pressed, rng = stepped(resolution), np.random.default_rng(6)
    counts = frictionless(pressed).lcp.counts
    failed, most, rounds = 0, 0, 0
    for _ in range(TRAJECTORIES):
        pressed.reset()
        depths, steps = rng.uniform(-0.3, 1.2, LENGTH), 10 ** rng.uniform(-4, 1, LENGTH)
        for depth, dt in zip(depths.tolist(), steps.tolist(), strict=True):
            before = int(counts[active_set.ROUNDS])
            try:
                pressed.step(dt, depth=depth, strain=False)
            except ConvergenceError:
                failed += 1
            taken = int(counts[active_set.ROUNDS]) - before
            most, rounds = max(most, taken), rounds + taken
    return float(failed), rounds / (TRAJECTORIES * LENGTH), float(most)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield agreement, theory, signs, repetition, energy and chance."""
    yield from _agreement("coarse" if quick else "standard")
    yield from _theory(quick=quick)
    yield from tabled(_physics("coarse" if quick else "standard"))
    if not quick:
        yield from _trades()


def _agreement(resolution: str) -> Iterator[Case]:
    for name, (_, motion) in PRESSES.items():
        # A depth that is prescribed is the same in both; a force is what each found a depth for.
        controlled = ("depth",) if motion.by_force else ()
        for quantity in (*controlled, "force", "pressure", "strain"):
            title = f"{quantity} in every step, {name}"
            measure = partial(difference, resolution, name, quantity)
            yield Case(title, measure, Expected(0.0, 1e-10), "linear on the same mesh")


def _theory(*, quick: bool) -> Iterator[Case]:
    source = "Hertz 1881; Ting 1966, J. Appl. Mech. 33:845, by springs that relax and only push"
    reason = "the mesh, over the peak force"
    for cells, limit in ((4, 1.5),) if quick else ((4, 1.5), (6, 0.8)):
        for nu in (0.49,) if quick else (0.3, 0.49):
            for part in ("loading", "unloading"):
                name = f"half-space, {part}, nu {nu:g}, a / h = {cells}"
                error = partial(hertz_error, nu, cells, part)
                yield Case(name, error, Expected(0.0, limit, "%"), source, reason=reason)
    for nu in () if quick else (0.3, 0.49):
        name = f"bonded layer as thick as the contact radius, nu {nu:g}"
        error, exact = partial(layer_error, nu, 6), "exact layer, theory/indentation"
        yield Case(name, error, Expected(0.0, 0.2, "%"), exact, reason="the mesh")


def _trades() -> Iterator[Case]:
    steps, source = f"over {STEPS} steps, whole finger", "the standard mesh, a tolerance of 1e-10"
    name = f"force on the coarse mesh {steps}"
    limits = Expected(0.0, 3.0, "%")
    reason = "what a step that is several times cheaper costs"
    yield Case(name, lambda: traded(stepped("coarse", tilt=10.0)), limits, source, reason=reason)
    for tolerance in (1e-6, 1e-4):
        title = f"force with a contact tolerance of {tolerance:g} {steps}"
        measure = partial(lambda tolerance: traded(roughly(tolerance)), tolerance)
        why = "penetration over the largest gap that counts as none"
        yield Case(title, measure, Expected(0.0, 1e3 * tolerance, "%"), source, reason=why)


def _physics(resolution: str) -> dict[str, Row]:
    steps = f"over {STEPS} steps, whole finger"
    counts = f"{TRAJECTORIES} random trajectories of {LENGTH} steps"
    pivoting = "block principal pivoting from the last active set"
    return {
        f"lowest pressure {steps}": Row(
            lambda: swept(resolution)[0], Expected(0.0, 0.0, "kPa"), "no adhesion"
        ),
        f"deepest penetration {steps}, over the largest gap": Row(
            lambda: swept(resolution)[1],
            Expected(0.0, 2e-10),
            "the weighted gaps of the contact conditions",
        ),
        f"difference of two runs {steps}": Row(
            lambda: swept(resolution)[2], Expected(0.0, 0.0, "kPa"), "the first run, bit for bit"
        ),
        **{
            f"work that the energy does not account for, {name}": Row(
                partial(work, "coarse", prony),
                Expected(0.0, 1e-4),
                "balance of work, stored energy and dampers",
                "the trapezoidal rule in 4000 steps",
            )
            for name, prony in (("elastic", ELASTIC), ("relaxing", None))
        },
        f"failed steps in {counts}": Row(
            lambda: chance("coarse")[0],
            Expected(0.0, 0.0, "steps"),
            "a solution exists for every depth",
        ),
        f"mean rounds of exchange per step, {counts}": Row(
            lambda: chance("coarse")[1],
            Expected(0.0, 10.0, "rounds"),
            pivoting,
            "jumps of any size; the limit is 500 in one step",
        ),
        f"most rounds of exchange in a step, {counts}": Row(
            lambda: chance("coarse")[2], Expected(0.0, 50.0, "rounds"), pivoting, "the limit is 500"
        ),
    }

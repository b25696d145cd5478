"""Speed of a condensed finger: its operator, a step of contact, a step with 1000 end organs.

A whole finger under a tilted plate, so that neither symmetry nor half a mesh helps: ramp, hold, 8
Hz sinusoid and retraction in 10 000 steps of 1 ms. A step is timed in processor time of its thread
and in wall time, which counts what else the machine did. Baselines: SuperLU for the operator, a
factor in the same order and a solution for every unknown of the pad; the steps of `linear` for
contact, and its answer for agreement.
"""

import resource
import time
from dataclasses import replace
from functools import partial
from typing import Any, Literal

import numpy as np
from fefinger.validation.bench import superlu
from fefinger.validation.bench.suites import Figure, Progress
from fefinger.validation.bench.timing import load, of_each, quantiles, timed
from fefinger.validation.oracles.march import march as plain
from fefinger.validation.problems import published

from fefinger.contact import active_set
from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.prony_history import Relaxation
from fefinger.contact.stepper import History, Prescribed, march
from fefinger.fem.body import body
from fefinger.fem.condensation import Compliance, palmar
from fefinger.geometry import finger_mesh
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press import operator, operator_cache, problem
from fefinger.mesh.store import load_or_build
from fefinger.neural.membranes import HodgkinHuxley, IntegrateAndFire
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array
from fefinger.support.processes import one_thread


Precision = Literal["double", "single"]

PLATE = Flat(30.0, tilt=10.0)
DEPTH, AMPLITUDE, SPEED = 1.15, 0.3, 20.0  # mm, mm, mm/s
STEPS, DT = 10_000, 1e-3
TYPES = {"FAI": 0.6, "SAI": 0.8, "SAII": 1.8, "FAII": 2.5}  # end organs and their depths in mm
EACH = 250
COMPARED = 600
TOLERANCES = (1e-8, 1e-6, 1e-4)
LOADS = 128  # of those that SuperLU would have to solve, timed
ANGLES, TURNS = (10.0, 40.0), 2000  # degrees, steps of 0.03 degrees


@one_thread
def figures(progress: Progress) -> list[Figure]:
    """Measure the operator of a standard finger, and steps on it."""
    busy = load()
    finger = replace(published.load("flat-press").finger, resolution="standard")
    rows = [*_building(finger), *_loading(finger)]
    progress("condensed", 0.4)
    sites = end_organs(pressed(finger))
    placing = partial(timed, partial(placed, finger, sites, "double"), time.perf_counter)
    (_, first), (double, again) = placing(), placing()
    rows.append(Figure("1000 end organs under a plate: wall, kept", again, "s", first))
    single = placed(finger, sites, "single")
    rows += [*_stepping("strains in double precision", double), *_contact(double)]
    progress("condensed", 0.7)
    rows += [*_stepping("strains in single precision", single), *_strain_error(single, double)]
    for membrane in (IntegrateAndFire(), HodgkinHuxley()):
        rows += spiking(single, type(membrane).__name__, family="thesis", membrane=membrane)
    rows += _rolling(finger, sites)
    rows += [*_agreement(double), *_tolerances(finger, double), *_coarser(finger)]
    return [*rows, busy]


def motion() -> Array:
    """Return the depths (STEPS,) in mm of ramp, hold, sinusoid and retraction."""
    times = np.arange(STEPS) * DT
    down = DEPTH / SPEED
    depth = np.interp(times, [0, down, 9, 9 + down + 0.01], [0, DEPTH, DEPTH, -0.2])
    waving = (times >= 3) & (times < 9)
    depth[waving] += AMPLITUDE * np.sin(2 * np.pi * 8 * (times[waving] - 3))
    return np.asarray(depth)


def pressed(finger: Finger, **options: Any) -> Loop:
    """Return a finger under PLATE, ready to be stepped."""
    return Loop(finger, PLATE, mechanics="condensed", deepest=DEPTH + AMPLITUDE, **options)


def frictionless(finger: Loop) -> FrictionlessContact:
    """Return the contact of a finger that is only pressed."""
    contact = finger.prepared.contact
    assert isinstance(contact, FrictionlessContact)
    return contact


def end_organs(finger: Loop) -> Sites:
    """Return EACH sites of every type, under the vertices of the pad nearest to the plate."""
    on_pad = finger.prepared.on_pad.patch
    near = on_pad.vertices[np.argsort(on_pad.gap / on_pad.projected)[:EACH]]
    points, normals = finger.solid.space.points[near], finger.solid.normals[near]
    depths = np.repeat(list(TYPES.values()), EACH)
    outward = np.tile(normals, (len(TYPES), 1))
    places = np.tile(points, (len(TYPES), 1)) - depths[:, None] * outward
    return Sites(places, outward, depths, tuple(np.repeat(list(TYPES), EACH).tolist()))


def _building(finger: Finger) -> list[Figure]:
    """Build both parities, one thread, and keep them."""
    mesh, seconds, processor = load_or_build(finger, half=True), 0.0, time.process_time()
    for odd in (False, True):
        started = time.perf_counter()
        built = operator.build(finger, mesh, odd=odd)
        identity = operator_cache.identity(finger, odd=odd, mesh=mesh)
        assert identity is not None
        operator.write(built, operator_cache.folder(identity), "operator of the benchmark")
        seconds += time.perf_counter() - started
    processor = time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    unknowns = len(built.matrix)
    name = "operator, whole finger"
    return [
        Figure(f"{name}: wall, built and written", seconds, "s"),
        Figure(f"{name}: processor, built and written", processor, "s", _superlu(finger, mesh)),
        Figure("operator: memory at the peak", peak, "MB"),
        Figure("operator: unknowns on the half of the pad", unknowns, "1"),
        Figure("operator: entries kept", 2 * (built.matrix.size + _entries(built)), "1"),
    ]


def _superlu(finger: Finger, mesh: FingerMesh) -> float:
    """Return the CPU seconds of SuperLU for both parities: a factor and all loads of the pad.

    The factor and LOADS of the loads are timed, on the even half.
    """
    solid = body(mesh, problem.tissues(finger), problem.fixed_facets(finger))
    system, space = solid.system, solid.space
    superlu_system, factoring = timed(lambda: superlu.factor(space, system.matrix, system.fixed))
    count = 3 * len(palmar(solid))
    loads = np.zeros((len(system.free), LOADS))
    loads[np.arange(LOADS), np.arange(LOADS)] = 1.0
    _, solving = timed(lambda: superlu_system.solver.solve(loads))
    return 2 * (factoring + solving * count / LOADS)


def _entries(built: Compliance) -> int:
    return sum(front.lower.size + front.below.size for front in built.fronts)


def _loading(finger: Finger) -> list[Figure]:
    load_one = partial(operator.operator, finger, half=False)
    (_, seconds), processor = timed(lambda: timed(load_one, time.perf_counter))
    return [
        Figure("operator, whole finger: wall, loaded with its mesh", seconds, "s"),
        Figure("operator, whole finger: processor, loaded with its mesh", processor, "s"),
    ]


def placed(finger: Finger, sites: Sites, precision: Precision) -> Loop:
    """Return the finger under PLATE with these end organs."""
    return pressed(finger, sites=sites, precision=precision)


def _stepping(name: str, finger: Loop) -> list[Figure]:
    """Time the steps of the motion with everything that a step gives."""
    processor, wall, vertices = np.empty(STEPS), np.empty(STEPS), np.empty(STEPS)
    _warm(finger)
    counts = frictionless(finger).lcp.counts
    for k, depth in enumerate(motion().tolist()):
        begun, started = time.thread_time(), time.perf_counter()
        finger.step(DT, depth=depth)
        processor[k], wall[k] = time.thread_time() - begun, time.perf_counter() - started
        vertices[k] = counts[active_set.K]
    return [
        Figure(f"{name}: vertices in contact, median", float(np.median(vertices)), "1"),
        *quantiles(name, 1e3 * processor),
        *quantiles(name, 1e3 * wall, "wall"),
    ]


def spiking(finger: Loop, label: str, **options: Any) -> list[Figure]:
    """Time the steps with a unit behind every end organ; options as `Loop.afferents`."""
    units, fired = finger.afferents(**options), 0
    _warm(finger)
    units.step(finger.step(DT, depth=DEPTH / 2).strain, DT)
    finger.reset()
    units.reset()

    def step(depth: float) -> None:
        nonlocal fired
        fired += units.step(finger.step(DT, depth=depth).strain, DT)

    spent, name = of_each(step, motion().tolist()), f"with {len(units.types)} {label} units"
    return [*quantiles(name, spent), Figure(f"{name}: spikes", fired, "1")]


def _rolling(finger: Finger, sites: Sites) -> list[Figure]:
    """Time the steps of a plate that turns from one of ANGLES to the other and back."""
    folded = replace(sites, points=finger_mesh.to_half(sites.points))
    rolling = Loop(finger, mechanics="condensed", angles=ANGLES, deepest=1.1, sites=folded)
    angles = np.interp(np.arange(TURNS), [0, TURNS / 2, TURNS], [*ANGLES, ANGLES[0]]).tolist()
    for _ in range(2):  # compiles
        rolling.reset()
        spent = of_each(lambda angle: rolling.step(DT, depth=1.0, angle=angle), angles)
    vertices = float(np.count_nonzero(rolling.now.pressure))
    name = f"a plate that turns, half a finger, {len(sites.points)} end organs"
    return [
        Figure(f"{name}: vertices in contact at the end", vertices, "1"),
        *quantiles(name, spent),
    ]


def _contact(finger: Loop) -> list[Figure]:
    _warm(finger)
    counts = frictionless(finger).lcp.counts
    spent = of_each(lambda depth: finger.step(DT, depth=depth, strain=False), motion().tolist())
    exchanged = float(counts[active_set.EXCHANGED])
    return [
        Figure("contact only: candidate vertices", len(finger.now.pressure), "1"),
        *quantiles("contact only", spent),
        Figure("contact only: vertices exchanged per step", exchanged / STEPS, "1"),
        Figure("contact only: inverses made anew", float(counts[active_set.REBUILT]), "1"),
    ]


def _agreement(finger: Loop) -> list[Figure]:
    """Compare pressures and seconds with a plain loop over a short motion."""
    on_pad, prony = finger.prepared.on_pad.patch, finger.finger.prony
    depth = np.concatenate([motion()[:100], motion()[3000 : 3000 + COMPARED], motion()[9000:9100]])
    prescribed = Prescribed("depth", np.linspace(0, (len(depth) - 1) * DT, len(depth)), depth)
    answers, seconds = [], []
    few = Prescribed("depth", prescribed.time[:2], depth[:2])
    contact = finger.prepared.on_pad.flexibility, on_pad.gap, on_pad.projected

    def compiled(prescribed: Prescribed) -> History:
        return march(FrictionlessContact(*contact, prony.branches), prescribed)

    def by_factors(prescribed: Prescribed) -> History:
        memory = Relaxation(np.array(prony.weights), np.array(prony.v), len(on_pad.vertices))
        return plain(*contact, memory, prescribed)

    compiled(few)
    for method in (compiled, by_factors):
        step = partial(method, prescribed)
        history, spent = timed(step, time.thread_time)
        seconds.append(spent / len(depth))
        answers.append(history.pressure)
    error = np.abs(answers[0] - answers[1]).max(axis=1)
    scale = np.abs(answers[1]).max(axis=1)
    worst = float((error[scale > 0] / scale[scale > 0]).max())
    name = "contact only: step, mean, processor, against a plain loop"
    return [
        Figure("pressure against a plain loop, worst step", worst, "1"),
        Figure(name, 1e3 * seconds[0], "ms", 1e3 * seconds[1]),
    ]


def _strain_error(single: Loop, double: Loop) -> list[Figure]:
    """Compare the strains of both precisions over a tenth of the motion."""
    worst = largest = 0.0
    for each in (single, double):
        each.reset()
    for depth in motion()[::10].tolist():
        exact = double.step(DT, depth=depth).strain
        worst = max(worst, float(np.abs(single.step(DT, depth=depth).strain - exact).max()))
        largest = max(largest, float(np.abs(exact).max()))
    return [Figure("strain in single precision: error over the largest", worst / largest, "1")]


def _tolerances(finger: Finger, exact: Loop) -> list[Figure]:
    """Trade the tolerance of the contact against its error."""
    rows = []
    forces = _forces(exact)
    for tolerance in TOLERANCES:
        rough = pressed(finger, sites=exact.sites)
        frictionless(rough).tolerance = tolerance
        name = f"contact tolerance {tolerance:g}"
        found, seconds = timed(partial(_forces, rough), time.thread_time)
        error = float(np.abs(found - forces).max() / forces.max())
        rows += [
            Figure(f"{name}: step, mean, processor", 1e3 * seconds / STEPS, "ms"),
            Figure(f"{name}: error of the force", error, "1"),
        ]
    return rows


def _coarser(finger: Finger) -> list[Figure]:
    """Trade the mesh against the error: the coarse one against the standard one."""
    exact = pressed(finger)
    coarse = replace(finger, resolution="coarse")
    rough = pressed(coarse, sites=exact.sites)
    forces, seconds = timed(lambda: _forces(rough), time.thread_time)
    error = float(np.abs(forces - _forces(exact)).max() / forces.max())
    strains = [each.step(DT, depth=DEPTH).strain for each in (rough, exact)]
    worst = float(np.abs(strains[0] - strains[1]).max() / np.abs(strains[1]).max())
    name = "coarse mesh, against the standard one"
    return [
        Figure("coarse mesh: step, mean, processor", 1e3 * seconds / STEPS, "ms"),
        Figure(f"{name}: error of the force", error, "1"),
        Figure(f"{name}: error of the strains under first touch, over the largest", worst, "1"),
    ]


def _forces(finger: Loop) -> Array:
    """Return the forces (STEPS,) of the motion in N, contact only."""
    finger.reset()
    return np.array(
        [finger.step(DT, depth=depth, strain=False).force for depth in motion().tolist()]
    )


def _warm(finger: Loop) -> None:
    finger.step(DT, depth=DEPTH / 2)
    finger.step(DT, depth=DEPTH / 2, strain=False)
    finger.reset()

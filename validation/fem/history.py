"""Part of the suite `fem`: viscoelastic contact on a bonded layer, loading, unloading and again.

The layer's far field does not depend on history, so the exact elastic contact of the layer and
`theory/contact/ting.py`, which shares no code with the march, say what force and detachment should
be.
"""

from collections.abc import Callable, Iterator
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.fem.hertz import bowl
from fefinger.validation.oracles.layer import Sheet
from fefinger.validation.problems.grids import quarter
from fefinger.validation.problems.quarter import Quarter, outer

from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.stepper import History, Prescribed, march
from fefinger.fem.elements.assembly import Elastic
from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.theory.contact import indentation
from fefinger.theory.contact.ting import (
    ContactHistory,
    ElasticForce,
    press_by_depth,
    press_by_force,
)
from fefinger.theory.relaxation import Prony, hereditary_integral


RADIUS, THICKNESS, MODULUS, NU = 20.0, 1.0, 100.0, 0.49
WIDEST = 1.0  # mm, the largest contact radius
EDGE = 0.13  # mm, longest edge under the contact
NODES = 96  # elastic contacts that the theory is given
STEPS = 1000
COUNTS = (50, 100, 200, 400)
BRISK = 0.1  # s
ELASTIC = Prony((1.0,), ())
ROUND, MESH = "rounding", "what the mesh leaves, a = 8 edges"
CREEP = "theory of creep on the exact layer; Lee and Radok 1960"
TING = "Ting 1966 for the exact layer (Lebedev and Ufliand 1958)"


def prony() -> Prony:
    """Return the relaxation of the means of Table 3.1."""
    return library.relaxation()["means"]


@cache
def body() -> Quarter:
    """Return the layer: even cells wherever the contact may end."""

    def size(r: Array, z: Array) -> Array:
        return EDGE + 0.8 * np.hypot(np.maximum(r - 1.1 * WIDEST, 0), 0.6 * z)

    r = np.array([0.0, 0.6, 1.2, 1.8, 2.5, 3.4, 4.5, 5.5, 7.0])
    space = quarter(r, np.array([0.0, 0.5, 1.0]), size, 5)
    held = np.repeat(np.any(outer(space), axis=0)[:, None], 3, axis=1)
    reach = (1.15 * WIDEST) ** 2 / (2 * RADIUS)
    still = np.zeros((space.n_nodes, 3))
    return Quarter(space, {1: Elastic(MODULUS, NU)}, held, still, bowl(RADIUS), reach)


def pressed(relaxing: Prony, control: str, time: Array, value: Array) -> History:
    """Return the finite elements' history under a depth in mm or a force in mN."""
    layer = body()
    patch = layer.patch
    share = 1.0 if control == "depth" else 0.25  # of the whole body's force
    prescribed = Prescribed(control, time, share * value)
    pad = layer.flexibility, patch.gap, patch.projected, relaxing.branches
    return march(FrictionlessContact(*pad), prescribed)


def force(history: History) -> Array:
    """Return the force (n_t,) on the whole layer in mN."""
    return np.asarray(4 * history.pressure @ body().patch.projected)


@cache
def layer_contacts() -> tuple[Array, Array, Array]:
    """Return depth mm, force mN and radius mm (n,) of exact contacts of the relaxed layer."""
    sheet = Sheet(THICKNESS, MODULUS, NU)
    radii = np.linspace(0, 1.1 * WIDEST, NODES + 1)[1:]
    contacts = [indentation.paraboloid(sheet, RADIUS, contact_radius=float(a)) for a in radii]
    values = np.array([[one.depth, one.force, one.contact_radius] for one in contacts])
    return tuple(np.vstack([np.zeros(3), values]).T)


def deepest() -> float:
    """Return the depth in mm whose contact is as wide as WIDEST."""
    depth, _, radius = layer_contacts()
    return float(np.interp(WIDEST, radius, depth))


def theory(control: str, time: Array, value: Array) -> ContactHistory:
    """Return the exact history of the layer."""
    depth, relaxed, _ = layer_contacts()
    instant = relaxed / prony().long_time
    if control == "depth":
        return press_by_depth(prony(), time, value, depth)
    return press_by_force(prony(), time, value, ElasticForce(depth, instant))


MOTIONS: dict[str, Callable[[Array], Array]] = {
    "ramp and hold": lambda x: np.minimum(5 * x, 1.0),
    "half sine": lambda x: np.sin(np.pi * x),
    "slow up, fast down": lambda x: np.minimum(x / 0.8, (1 - x) / 0.2),
    "sinusoid in contact": lambda x: 0.75 - 0.25 * np.cos(6 * np.pi * x),
    "sinusoid that loses contact": lambda x: 0.45 + 0.55 * np.sin(6 * np.pi * x - np.pi / 2),
}
"""Depth over the deepest, at the part of the cycle that is over."""

PERIODS = {"ramp and hold": 2.0, "half sine": 0.5, "slow up, fast down": 2.0}
PERIOD = 3.0  # s of the others
UNLOADED = ("half sine", "slow up, fast down", "sinusoid that loses contact")


def motion(name: str, steps: int, period: float = 0.0) -> tuple[Array, Array]:
    """Return time s and depth mm of one of MOTIONS in equal steps."""
    part = np.linspace(0, 1, steps + 1)
    return (period or PERIODS.get(name, PERIOD)) * part, deepest() * MOTIONS[name](part)


@cache
def cycle(name: str, steps: int) -> tuple[Array, Array, Array]:
    """Return time, the finite elements' force and the exact force (n_t,) of one of MOTIONS."""
    time, depth = motion(name, steps)
    computed = force(pressed(prony(), "depth", time, depth))
    exact = theory("depth", time, depth).stress(layer_contacts()[1] / prony().long_time)
    return time, computed, exact


def force_error(name: str, steps: int = STEPS) -> float:
    """Return the largest error of the force over its peak in %."""
    _, computed, exact = cycle(name, steps)
    return 100 * float(np.abs(computed - exact).max() / exact.max())


def detachment_error(name: str, steps: int = STEPS) -> float:
    """Return the largest error of the moments of detachment and re-contact in % of the cycle."""
    time, computed, exact = cycle(name, steps)
    ours, theirs = (_changes(time, one) for one in (computed, exact))
    if len(ours) != len(theirs):
        return float("inf")
    return 100 * float(np.abs(ours - theirs).max() / time[-1])


def _changes(time: Array, force: Array) -> Array:
    """Return the times at which contact begins or ends, to half a step."""
    touching = force > 1e-9 * force.max()
    changes = np.flatnonzero(np.diff(touching.astype(int)))
    return np.asarray((time[changes] + time[changes + 1]) / 2)


def identity_error(steps: int) -> float:
    """Return the largest departure of loading from the integral of G dT, over the peak.

    T is the finite elements' own elastic force at the same times.
    """
    time, depth = motion("ramp and hold", steps)
    elastic = force(pressed(ELASTIC, "depth", time, depth))
    expected = hereditary_integral(prony(), time, elastic) / prony().long_time
    computed = force(pressed(prony(), "depth", time, depth))
    return float(np.abs(computed - expected).max() / expected.max())


@cache
def step_error() -> float:
    """Return the largest error of the force after a step of depth against G(t), over G(0)."""
    time = np.concatenate([[0.0], np.geomspace(1e-6, 1e3, 80)])
    computed = force(pressed(prony(), "depth", time, np.full_like(time, deepest() / 2)))
    return float(np.abs(computed / computed[0] - prony().relaxation(time)).max())


@cache
def creep_error() -> float:
    """Return the largest error in % of the depth after a step of force."""
    time = np.concatenate([[0.0], np.geomspace(1e-4, 30.0, 200)])
    load = np.full_like(time, 0.8 * float(np.interp(deepest(), *layer_contacts()[:2])))
    computed, exact = pressed(prony(), "force", time, load), theory("force", time, load)
    return 100 * float(np.abs(computed.depth / exact.depth - 1).max())


@cache
def pull(name: str) -> float:
    """Return the lowest pressure over the highest of a motion in %."""
    pressure = pressed(prony(), "depth", *motion(name, STEPS)).pressure
    return 100 * float(pressure.min() / pressure.max())


@cache
def step_order(name: str) -> float:
    """Return the fitted order of the RMS error in the time step, against eight times finer.

    The motion takes BRISK seconds, so that the steps resolve the fastest term of the relaxation.
    """
    fine = force(pressed(prony(), "depth", *motion(name, 8 * COUNTS[-1], BRISK)))
    errors = []
    for steps in COUNTS:
        coarse = force(pressed(prony(), "depth", *motion(name, steps, BRISK)))
        errors.append(np.sqrt(np.mean((coarse - fine[:: 8 * COUNTS[-1] // steps]) ** 2)))
    return float(-np.polyfit(np.log(COUNTS), np.log(errors), 1)[0])


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield step, loading, every motion, creep and the order in the time step."""
    yield _case("force after a step of depth against G(t)", step_error, 1e-9, "1", "Eq. 2.2", ROUND)
    yield _case(
        "ramp and hold against the integral of G dT",
        lambda: identity_error(STEPS),
        1e-9,
        "1",
        "Eq. 2.3; Lee and Radok 1960",
        "the same T at the same times: an identity, to rounding",
    )
    yield from _motions()
    yield _case("depth in creep under a held force", creep_error, 1.0, "%", CREEP, MESH)
    for name in () if quick else UNLOADED:
        title = f"bonded layer, {name}: order in the time step"
        source = "exponentials exact for a pressure linear in each step"
        reason = "contact that begins or ends inside a step is of second order too"
        yield Case(title, partial(step_order, name), Expected(2.0, 0.3), source, reason=reason)


def _motions() -> Iterator[Case]:
    for name in MOTIONS:
        error, lowest = partial(force_error, name), partial(pull, name)
        yield _case(f"{name}, force over its peak", error, 1.0, "%", TING)
        pulling = f"{name}, lowest pressure over the highest"
        yield _case(pulling, lowest, 0.0, "%", "no adhesion", "a pressure is never negative")
    for name in UNLOADED:
        yield _case(
            f"{name}, moments of detachment and touch, of the cycle",
            partial(detachment_error, name),
            1.0,
            "%",
            TING,
            "within 1 % of the cycle; steps are 0.1 % of it",
        )


def _case(
    name: str,
    measure: Callable[[], float],
    limit: float,
    unit: str,
    source: str,
    reason: str = MESH,
) -> Case:
    return Case(f"bonded layer, {name}", measure, Expected(0.0, limit, unit), source, reason=reason)

"""A block that a plate drags on a spring: static and kinetic friction in closed form.

One vertex under a constant force P whose displacement along the plate is linear in its traction: a
spring of stiffness k. It sticks until the spring pulls with the static coefficient times P, slips
with the kinetic one as long as the plate moves on, and after a turn sticks until the static one is
reached the other way. A spring that relaxes lets go later.

Also the limits of the coefficient of friction, and the same contact by another method.
"""

from dataclasses import dataclass

import numpy as np
from fefinger.validation.friction.sheared import CONTACT, RADIUS, contact, limit
from fefinger.validation.oracles.coulomb import projected
from scipy.optimize import brentq

from fefinger.contact.active_set import DONE
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.coulomb import CoulombSolver
from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.stepper import History, Prescribed, march
from fefinger.support.arrays import Array, Flags
from fefinger.support.tolerances import COMPLEMENTARITY
from fefinger.theory.relaxation import Prony, hereditary_integral


STATIC, KINETIC = 0.6, 0.35
FORCE, STIFFNESS, AREA = 41.3, 25.0, 1.0  # mN, mN/mm of the relaxed spring, mm²
SPEED, FAR = 2.0, 3.0  # mm/s, and mm of a pass, of which less than a third ends stick
STEPS = 3000  # in a pass
ELASTIC = Prony((1.0,), ())
RELAXING = Prony((0.4, 0.35, 0.25), (20.0, 1.5))


@dataclass(frozen=True)
class Plate:
    """A plane over the vertex, as `Gaps`."""

    def gap(self, shift: Array, incline: Array | None) -> tuple[Array, Flags]:
        """Return the weighted gap (1,) at any place, and no rim."""
        return np.zeros(1), np.zeros(1, dtype=bool)

    def push(self, shift: Array, pressure: Array, incline: Array | None) -> Array:
        """Return no force (2,): nothing is inclined."""
        return np.zeros(2)


def dragged(prony: Prony, passes: int) -> tuple[Array, Array, History]:
    """Return times in s, the path in mm and the contact of a block that is dragged to and fro."""
    lap = np.linspace(0.0, FAR, STEPS + 1)[1:]
    legs = [lap if k % 2 == 0 else FAR - lap for k in range(passes)]
    path = np.concatenate([[0.0], *legs])
    time = np.arange(len(path)) * FAR / SPEED / STEPS
    shift = np.stack([path, np.zeros_like(path)], axis=1)
    spring = np.diag([AREA**2 / 100.0, AREA**2 / STIFFNESS, AREA**2 / STIFFNESS])
    block = FrictionalContact(spring, (STATIC, KINETIC), Plate(), np.array([AREA]), prony.branches)
    history = march(block, Prescribed("force", time, np.full(len(time), FORCE), shift))
    return time, path, history


def pull(history: History) -> Array:
    """Return the force (n_t,) mN with which the plate pulls the block."""
    assert history.sliding is not None
    assert history.sliding.traction is not None
    return np.asarray(history.sliding.traction[:, 0, 0] * AREA)


def loop_error() -> float:
    """Return the largest error of the force along a loop, over that at which it lets go.

    In the step in which the block lets go it still has the static coefficient.
    """
    _, path, history = dragged(ELASTIC, 3)
    exact, slips = np.zeros(len(path)), False
    for k in range(1, len(path)):
        moved = path[k] - path[k - 1]
        turned = k > 1 and moved * (path[k - 1] - path[k - 2]) < 0
        slips = slips and not turned
        held = exact[k - 1] + STIFFNESS * moved
        if slips:
            exact[k] = np.sign(moved) * KINETIC * FORCE
        else:
            slips = abs(held) > STATIC * FORCE
            exact[k] = np.clip(held, -STATIC * FORCE, STATIC * FORCE)
    return float(np.abs(pull(history) - exact).max() / (STATIC * FORCE))


def work_ratio() -> float:
    """Return the work of friction in a closed cycle over 4 mu_k P (A - mu_k P / k).

    A is a pass. The block slips by A - (mu_s + mu_k) P / k in it, and by (mu_s - mu_k) P / k where
    it lets go; what the spring gives off then beyond friction is kinetic energy, which is lost.
    """
    _, path, history = dragged(ELASTIC, 4)
    assert history.sliding is not None
    lost = history.sliding.lost
    assert lost is not None
    cycle = float(lost[-1] - lost[2 * STEPS])
    assert path[-1] == path[2 * STEPS]
    return cycle / (2 * KINETIC * FORCE * (FAR - 2 * KINETIC * FORCE / STIFFNESS))


def release_ratio() -> float:
    """Return the time at which a relaxing spring lets go over that of its hereditary integral."""
    time, _, history = dragged(RELAXING, 1)
    first = int(np.argmax(pull(history) >= STATIC * FORCE * (1 - 1e-6)))

    def short(moment: float) -> float:
        ramp = np.array([0.0, moment])
        pulled = hereditary_integral(RELAXING, ramp, STIFFNESS / RELAXING.weights[0] * SPEED * ramp)
        return float(pulled[-1]) - STATIC * FORCE

    return float(time[first] / brentq(short, 1e-9, float(time[-1])))


SQUARES = 10
HUGE = 1e9


def solved(flexibility: Array, offset: Array, mu: float) -> Array:
    """Return pressures and tractions (3n,) of one contact without a past."""
    state = CoulombSolver(flexibility, mu)
    outcome = state.solve(offset, COMPLEMENTARITY)
    if outcome != DONE:
        message = f"friction: no solution, outcome {outcome}"
        raise ArithmeticError(message)
    return state.x.copy()


def offset(moved: float) -> tuple[Array, Array]:
    """Return F and what is to be overcome (3n,) where the sphere is pressed and sheared at once.

    The body has nu < 1/2, so that pressure and traction do move each other's contact.
    """
    on = contact("squares", SQUARES, 0.3)
    depth = CONTACT**2 / RADIUS
    rest = np.concatenate([on.gap - depth * on.areas, -moved * on.areas, 0.3 * moved * on.areas])
    return on.flexibility, rest


def against_gradients(mu: float, part: float) -> float:
    """Return the largest difference from projected gradients, over the largest pressure.

    Sheared by a part of the displacement at which all slides.
    """
    matrix, rest = offset(part * limit())
    x = solved(matrix, rest, mu)
    return float(np.abs(x - projected(matrix, rest, mu)).max() / x.max())


def turned(angle: float = 37.0) -> float:
    """Return the largest difference of the solution in axes turned in the plane, by degrees.

    Over the largest pressure: Coulomb's law knows no direction.
    """
    matrix, rest = offset(0.7 * limit())
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.kron([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]], np.eye(len(rest) // 3))
    x = solved(matrix, rest, 0.5)
    turned = solved(axes @ matrix @ axes.T, axes @ rest, 0.5)
    return float(np.abs(turned - axes @ x).max() / x.max())


def against_frictionless() -> float:
    """Return the largest difference of mu = 0 from contact without friction."""
    matrix, rest = offset(limit())
    n = len(rest) // 3
    x = solved(matrix, rest, 0.0)
    pressure = Complementarity(matrix[:n, :n]).solve(rest[:n])
    return float(max(np.abs(x[:n] - pressure).max(), np.abs(x[n:]).max()) / pressure.max())


def against_bonded() -> float:
    """Return the largest difference of a huge mu from one system of the vertices in contact."""
    matrix, rest = offset(0.2 * limit())
    n = len(rest) // 3
    x = solved(matrix, rest, HUGE)
    chosen = np.flatnonzero(np.tile(x[:n] > 0, 3))
    bonded = np.zeros(3 * n)
    bonded[chosen] = np.linalg.solve(matrix[np.ix_(chosen, chosen)], -rest[chosen])
    return float(np.abs(x - bonded).max() / np.abs(bonded).max())

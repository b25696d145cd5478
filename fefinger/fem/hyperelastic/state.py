"""State of a hyperelastic body in contact, and the target of one load step."""

from dataclasses import dataclass, field

import numpy as np

from fefinger.fem.hyperelastic.continuum import HistoryStress
from fefinger.support.arrays import Array
from fefinger.support.tolerances import LEAST_FORCE, SMALL_FORCE


@dataclass(frozen=True)
class State:
    """Displacements, hydrostatic pressures and contact pressure of a body at one indentation.

    values (n_unknowns,): displacements in mm, then hydrostatic pressures in units of the body's
    `scale`; pressure (n,) kPa: coefficients p of the candidates (see `deformed_gap`); depth mm;
    shift (3,) mm: the place of the obstacle across its axis; traction (2, n) kPa: coefficients of
    friction on the skin, in the directions of `DeformedGap.tangential`, (2, 0) without friction.
    """

    values: Array
    pressure: Array
    depth: float
    shift: Array = field(default_factory=lambda: np.zeros(3))
    traction: Array = field(default_factory=lambda: np.zeros((2, 0)))

    @property
    def contact(self) -> Array:
        """Pressures and then, with friction, tractions (n,) or (3n,) kPa of the candidates."""
        return np.concatenate([self.pressure, self.traction.ravel()])

    def toward(self, other: "State", part: float) -> "State":
        """Interpolate linearly between this state (`part` = 0) and another (`part` = 1)."""
        return State(
            self.values + part * (other.values - self.values),
            self.pressure + part * (other.pressure - self.pressure),
            self.depth + part * (other.depth - self.depth),
            self.shift + part * (other.shift - self.shift),
            self.traction + part * (other.traction - self.traction),
        )


@dataclass(frozen=True)
class Friction:
    """Coulomb friction in a load step: the coefficients, and where the slip of the step begins.

    coefficient (n,) of every candidate; before: the equilibrium at the start of the step.
    """

    coefficient: Array
    before: State


@dataclass(frozen=True)
class Target:
    """Target of one load step: prescribed depth (mm) or force (mN), and the history stress.

    control: "depth" or "force"; value: the prescribed depth or force; peak: the largest of them
    on the load path; shift (3,) mm: the place of the obstacle across its axis; friction: none
    where the contact is frictionless.
    """

    control: str
    value: float
    history: HistoryStress
    peak: float = 0.0
    shift: Array = field(default_factory=lambda: np.zeros(3))
    friction: Friction | None = None

    @property
    def by_force(self) -> bool:
        """Whether the force is prescribed, and not the depth."""
        return self.control == "force"

    @property
    def force_floor(self) -> float:
        """Floor in mN of the force in the denominator of the relative force error.

        0 under depth control.
        """
        return max(SMALL_FORCE * self.peak, LEAST_FORCE) if self.by_force else 0.0

    @property
    def depth_floor(self) -> float:
        """Floor in mm of the depth in the denominator of the relative gap error.

        0 under force control.
        """
        return 0.0 if self.by_force else SMALL_FORCE * self.peak

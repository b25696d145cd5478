"""The modulus t(u) of Pawluk (1997) as a factor on a linear finger, fitted to that finger.

t depends on the depth of the whole indenter, so it is no material. As a factor on a linear body it
reads p = integral of G(t - s) d(t q)(s), q the elastic pressure. The values of Table 3.2 are those
of a half-space and hold the stiffening by the bone already: on a finger with a bone t is fitted
anew, and little of the stiffening is left for it.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from fefinger.mechanics.loop import Loop
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError, number
from fefinger.theory.lumped.spring import LARGEST
from fefinger.theory.relaxation import Prony, exprel


@dataclass(frozen=True)
class Stiffening:
    """t(u) = (b / m) [exp(m u) - 1] (Pawluk 1997, Eq. 3.11) over the finger's own modulus.

    b in 1/mm above 0; m in 1/mm, where 0 is t = b u; misfit: the largest error of the forces that
    it was fitted to, over the largest of them.
    """

    b: float
    m: float
    misfit: float = 0.0

    def __post_init__(self) -> None:
        number("stiffening.b", self.b, above=0, unit="1/mm")
        number("stiffening.m", self.m, at_least=0, unit="1/mm")
        number("stiffening.misfit", self.misfit, at_least=0)

    def __call__(self, depth: float) -> float:
        """Return t at a depth in mm; 0 out of contact."""
        into = max(number("depth", depth, unit="mm"), 0.0)
        if self.m * into > LARGEST:
            raise InputError(
                f"stiffening: expected m times depth of at most {LARGEST:g}, received "
                f"{self.m:g} 1/mm times {into:g} mm; press less deep"
            )
        return self.b * into * float(exprel(self.m * into))

    @classmethod
    def fitted(
        cls, finger: Finger, depth: ArrayLike, force: ArrayLike, indenter: Indenter = STANDARD
    ) -> Self:
        """Return the t with which the linear finger has forces nearest to the relaxed ones (n,) N.

        Least squares over the depths (n,) mm. InputError for fewer than two depths above 0 or no
        force above 0, ConvergenceError for a search that is cut short.
        """
        from scipy.optimize import least_squares

        depth, force = np.asarray(depth, float), np.asarray(force, float)
        _check(depth, force)
        elastic = Loop(
            replace(finger, prony=Prony((1.0,), ())),
            indenter,
            mechanics="condensed",
            deepest=float(depth.max()),
        )
        steps = (elastic.step(0.0, depth=d, strain=False) for d in depth.tolist())
        linear = np.array([step.force for step in steps])
        into, largest = np.maximum(depth, 0.0), float(force.max())
        unit = largest / float((into * linear).max())

        def missed(numbers: Array) -> Array:
            t = unit * np.exp(numbers[0]) * into * exprel(numbers[1] * into)
            return np.asarray((t * linear - force) / largest)

        fit = least_squares(
            missed, [0.0, 1.0], bounds=([-20.0, 0.0], [20.0, 20.0]), xtol=1e-12, ftol=1e-12
        )
        misfit = float(np.abs(fit.fun).max())
        b, m = unit * float(np.exp(fit.x[0])), float(fit.x[1])
        if not fit.success:
            raise ConvergenceError(
                f"stiffening: the search for t had not settled after {fit.nfev} evaluations, "
                f"at b = {b:.3g} 1/mm, m = {m:.3g} 1/mm and a misfit of {misfit:.2g}; "
                "check the forces"
            )
        return cls(b, m, misfit)


def _check(depth: Array, force: Array) -> None:
    if depth.ndim != 1 or depth.shape != force.shape or (depth > 0).sum() < 2:
        raise InputError(
            "stiffening: expected as many forces as depths, two or more of them above 0, "
            f"received depths of shape {depth.shape} and forces of shape {force.shape}"
        )
    if not (np.isfinite(depth).all() and np.isfinite(force).all() and force.max() > 0):
        raise InputError(
            "stiffening: expected finite depths, and finite forces of which the largest is above "
            f"0 N, received depths up to {depth.max():g} mm and forces up to {force.max():g} N"
        )

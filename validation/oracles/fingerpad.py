"""Pressure of the fingerpad: Hertz contact with a modulus t(u) that depends on depth, relaxing.

p(r, x) = t(x) c(r, x), with t(u) = (b/m) [exp(m u) - 1] and c = 4 sqrt(R x - r²) / (pi R), so that
2 G_shear = t, E* = 2 t and E = 1.5 t. Lengths in mm, pressures and t in kPa, forces in mN.
t depends on the depth of the indenter: it describes a press, not a material.
Source: Pawluk (1997), chapter 3, Eq. 3.7 to 3.17.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array
from fefinger.theory.contact.ting import ContactHistory, press_by_depth, radius_nodes
from fefinger.theory.lumped.spring import LARGEST
from fefinger.theory.relaxation import Prony, exprel


Reading = Literal["relaxed", "instantaneous"]


@dataclass(frozen=True)
class Fingerpad:
    """Parameters of the fingerpad: a row of Table 3.2 and one of Table 3.1.

    Parameters
    ----------
    radius, m, b
        Effective radius R in mm, m in 1/mm, b in kPa/mm as printed.
    prony
        Relaxation G.
    reading
        Interpretation of the printed b: "relaxed" (c0 b, as the text says that c0 b was fitted;
        only then does the lumped response agree), or "instantaneous" (as the table calls it).

    Raises
    ------
    ValueError
        A parameter that is not above 0, or another reading.
    """

    radius: float
    m: float
    b: float
    prony: Prony
    reading: Reading = "relaxed"

    def __post_init__(self) -> None:
        elastic.require_positive("fingerpad", radius=self.radius, m=self.m, b=self.b)
        if self.reading not in ("relaxed", "instantaneous"):
            msg = f"reading: expected 'relaxed' or 'instantaneous', received {self.reading!r}"
            raise ValueError(msg)

    @property
    def instantaneous_b(self) -> float:
        """Parameter b of the instantaneous response in kPa/mm."""
        return self.b / self.prony.long_time if self.reading == "relaxed" else self.b

    def stiffness(self, depth: ArrayLike) -> Array:
        """Return t (...,) (Eq. 3.11) in kPa at depths u (...,) >= 0 in mm; 0 out of contact."""
        reach = np.maximum(elastic.numbers("fingerpad", "depth", depth), 0.0)
        exponent = self.m * float(reach.max())
        if exponent > LARGEST:
            raise ValueError(
                f"fingerpad: expected m times depth of at most {LARGEST:g}, received {exponent:.3g}"
            )
        return np.asarray(self.instantaneous_b * reach * exprel(self.m * reach))

    def modulus(self, depth: ArrayLike) -> Array:
        """Return Young's modulus 1.5 t (...,) in kPa of incompressible tissue at depths (...,)."""
        return 1.5 * self.stiffness(depth)

    def contact_radius(self, depth: ArrayLike) -> Array:
        """Return a = sqrt(R x) (...,) (Eq. 3.8) in mm at depths x (...,) in mm."""
        reach = np.maximum(elastic.numbers("fingerpad", "depth", depth), 0.0)
        return np.sqrt(self.radius * reach)

    def pressure(self, r: ArrayLike, depth: ArrayLike) -> Array:
        """Return the instantaneous p(r, x) (Eq. 3.10) in kPa, of the broadcast shape."""
        r = elastic.numbers("fingerpad", "r", r)
        depth = elastic.numbers("fingerpad", "depth", depth)
        inside = np.maximum(self.radius * depth - r**2, 0.0)
        return self.stiffness(depth) * 4 / (np.pi * self.radius) * np.sqrt(inside)

    def relaxed_pressure(self, r: ArrayLike, depth: ArrayLike) -> Array:
        """Return the steady pressure p_ss = c0 p (Eq. 3.17) in kPa."""
        return self.prony.long_time * self.pressure(r, depth)

    def force(self, depth: ArrayLike) -> Array:
        """Return T(x) of Eq. 3.16 in mN: (8/3) sqrt(R) x^(3/2) t(x) in closed form."""
        reach = np.maximum(elastic.numbers("fingerpad", "depth", depth), 0.0)
        return 8 / 3 * np.sqrt(self.radius) * reach**1.5 * self.stiffness(reach)

    def depth_at(self, force: ArrayLike, *, relaxed: bool = False) -> Array:
        """Return the depth in mm at which T, or c0 T if `relaxed`, is the force in mN."""
        force = elastic.numbers("fingerpad", "force", force, least=0.0)
        force = force / (self.prony.long_time if relaxed else 1.0)
        deepest = LARGEST / self.m * (1 - 1e-12)  # within the limit after rounding
        if (self.force(deepest) < force).any():
            msg = f"fingerpad: expected a force below that at {deepest:.3g} mm, received more"
            raise ValueError(msg)
        # exp(m x) - 1 >= m x gives an upper bound, close for small depths; doubling reaches others.
        soft = (force / (8 / 3 * np.sqrt(self.radius) * self.instantaneous_b)) ** 0.4
        low, high = np.zeros_like(force), np.minimum(soft, 1 / self.m)
        while (short := self.force(high) < force * (1 - 1e-12)).any():
            high = np.where(short, np.minimum(2 * high, deepest), high)
        for _ in range(60):
            middle = (low + high) / 2
            short = self.force(middle) < force
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return np.asarray((low + high) / 2)

    def press(self, time: ArrayLike, depth: ArrayLike, *, count: int = 256) -> ContactHistory:
        """Compute the contact history for depths (n_t,) mm, valid on unloading (see `ting`).

        `history.stress(pressure(r, nodes[:, None]))` and `history.stress(force(nodes))` are
        pressure and force. As t is not a material, a shrinking contact is that of a body with the
        curve T.
        """
        deepest = float(elastic.numbers("fingerpad", "depth", depth).max())
        return press_by_depth(self.prony, time, depth, radius_nodes(deepest, count))


def series_modulus(*solids: tuple[float, float]) -> float:
    """Contact modulus E* in kPa with 1/E* = sum of (1 - nu²) / E over (E, nu) (Eq. 3.21 and A.3).

    A rigid solid has an infinite E.
    """
    if not solids or not all(e > 0 and 0 <= nu <= 0.5 for e, nu in solids):
        raise ValueError(f"solids: expected pairs (E > 0 kPa, nu in 0 to 0.5), received {solids}")
    compliance = math.fsum((1 - poisson**2) / modulus for modulus, poisson in solids)
    if compliance == 0:
        raise ValueError("solids: expected at least one that deforms, received rigid ones only")
    return 1 / compliance

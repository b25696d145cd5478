"""Hyperelastic laws of soft tissue at finite strain.

All are one family in the isochoric invariants I1 = J^(-2/3) tr C and I2 = J^(-4/3) (tr(C)² -
tr C²) / 2 of C = F'F,

    W = mu / 2 [share (exp(b (I1 - 3)) - 1) / b + (1 - share) (I2 - 3)] + p (J - 1) - p² / 2K,

with the pressure p = K (J - 1) as an unknown of its own, so that K may be infinite. mu is the shear
modulus at small strain for every share and exponent b.
"""

from dataclasses import dataclass

from fefinger.fem.elements.forms import Elastic
from fefinger.support.checks import InputError, number
from fefinger.support.vocabulary import SHARES


@dataclass(frozen=True)
class Law:
    """One hyperelastic material.

    shear: mu in kPa; compressibility: 1 / K in 1/kPa; share: the part of mu that I1 carries;
    exponent: b, 0 for a polynomial in I1.
    """

    shear: float
    compressibility: float
    share: float = 1.0
    exponent: float = 0.0

    def __post_init__(self) -> None:
        number("law.shear", self.shear, above=0, unit="kPa")
        number("law.compressibility", self.compressibility, at_least=0, unit="1/kPa")
        number("law.share", self.share, at_least=0, at_most=2)
        number("law.exponent", self.exponent, at_least=0)
        if self.share > 1 and self.exponent == 0:
            message = (
                f"law.share: expected at most 1 for a law without exponent, received {self.share:g}"
                "; it would lose its stiffness in compression"
            )
            raise InputError(message)


def neo_hookean(elastic: Elastic) -> Law:
    """Return W = mu/2 (I1 - 3): the stiffness of Gaussian chains, with no stiffening."""
    return Law(elastic.shear, elastic.compressibility, SHARES["neo-hookean"])


def law(
    name: str, elastic: Elastic, exponent: float | None = None, share: float | None = None
) -> Law:
    """Return the law called `name` (of `SHARES`), with the small-strain behavior `elastic`.

    "neo-hookean": no stiffening; "mooney-rivlin" (Mooney 1940, Rivlin 1948): I1 and I2 without
    exponent; "demiray" (J. Biomech. 5:309, 1972): I1 alone, with an exponent; "veronda-westmann"
    (J. Biomech. 3:111, 1970): a share of 2, so that mu (1 - share) (I2 - 3) / 2 is taken off.
    """
    carried = SHARES[name] if share is None else share
    return Law(elastic.shear, elastic.compressibility, carried, exponent or 0.0)

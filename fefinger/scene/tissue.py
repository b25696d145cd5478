"""Material parameters of the finger: soft layers, and elastic bone and nail."""

from dataclasses import dataclass
from typing import Any

from fefinger.support.checks import InputError, choice, set_number
from fefinger.support.vocabulary import EXPONENTIAL, SHARES
from fefinger.theory.relaxation import Prony


DENSITY = 1100.0
"""Mass of skin and subcutaneous tissue in kg/m³; published ones lie between 1000 and 1150."""


@dataclass(frozen=True)
class Tissue:
    """Material of an isotropic soft layer.

    Parameters
    ----------
    modulus
        Relaxed (long-time) Young's modulus in kPa; the instantaneous one is modulus / c0.
    poisson
        Poisson's ratio, 0 to 0.5; 0.5 is incompressible and allowed.
    thickness
        Thickness of the skin in mm; None for the tissue that fills the rest of the pulp.
    law
        Hyperelastic law at finite strain (`solid`); at small strain all are the same.
    exponent
        b of the exponential laws, which stiffen as exp(b (I1 - 3)).
    prony
        Relaxation of this layer, where it differs from that of the finger (`solid` only).
    share
        Fraction of the shear modulus that I1 carries in "mooney-rivlin"; by default 0.5.
    density
        Mass in kg/m³, which `modal` alone has a use for.

    Raises
    ------
    InputError
        A value that is not a finite number in its range, or a parameter of another law.
    """

    modulus: float
    poisson: float
    thickness: float | None = None
    law: str = "neo-hookean"
    exponent: float | None = None
    share: float | None = None
    prony: Prony | None = None
    density: float = DENSITY

    def __post_init__(self) -> None:
        set_number(self, "tissue.modulus", above=0, unit="kPa")
        set_number(self, "tissue.poisson", at_least=0, at_most=0.5)
        set_number(self, "tissue.density", above=0, unit="kg/m³")
        if self.thickness is not None:
            set_number(self, "tissue.thickness", above=0, unit="mm")
        prony: Any = self.prony
        if prony is not None and not isinstance(prony, Prony):
            raise InputError(f"tissue.prony: expected a Prony, received {prony!r}")
        choice("tissue.law", self.law, SHARES)
        exponential, mixed = self.law in EXPONENTIAL, self.law == "mooney-rivlin"
        if exponential and self.exponent is None:
            msg = f"tissue.exponent: missing; expected a number for the law {self.law!r}"
            raise InputError(msg)
        for name, value, fits in (
            ("exponent", self.exponent, exponential),
            ("share", self.share, mixed),
        ):
            if value is not None and not fits:
                msg = f"tissue.{name}: expected none for the law {self.law!r}, received {value!r}"
                raise InputError(msg)
        if self.exponent is not None:
            set_number(self, "tissue.exponent", above=0)
        if self.share is not None:
            set_number(self, "tissue.share", at_least=0, at_most=1)


@dataclass(frozen=True)
class Hard:
    """Material of bone or nail: isotropic, elastic, without relaxation.

    Parameters
    ----------
    modulus
        Young's modulus in kPa.
    poisson
        Poisson's ratio, 0 to 0.5.

    Raises
    ------
    InputError
        A value that is not a finite number in its range.
    """

    modulus: float
    poisson: float = 0.3

    def __post_init__(self) -> None:
        set_number(self, "hard.modulus", above=0, unit="kPa")
        set_number(self, "hard.poisson", at_least=0, at_most=0.5)

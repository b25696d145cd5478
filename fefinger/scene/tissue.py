"""Material parameters of the finger: soft layers, and elastic bone and nail."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from fefinger.scene.key import Key, check
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import EXPONENTIAL, SHARES
from fefinger.theory.relaxation import Prony


DENSITY = 1100.0
"""Mass of skin and subcutaneous tissue in kg/m³; published ones lie between 1000 and 1150."""

Modulus = Annotated[float, Key(unit="kPa", above=0)]
Poisson = Annotated[float, Key(at_least=0, at_most=0.5)]


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

    table: ClassVar[str] = "tissue"

    modulus: Modulus
    poisson: Poisson
    thickness: Annotated[float | None, Key(unit="mm", above=0)] = None
    law: Annotated[str, Key(words=tuple(SHARES))] = "neo-hookean"
    exponent: Annotated[float | None, Key(above=0)] = None
    share: Annotated[float | None, Key(at_least=0, at_most=1)] = None
    prony: Prony | None = None
    density: Annotated[float, Key(unit="kg/m³", above=0)] = DENSITY

    def __post_init__(self) -> None:
        check(self)
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

    table: ClassVar[str] = "hard"

    modulus: Modulus
    poisson: Poisson = 0.3

    def __post_init__(self) -> None:
        check(self)

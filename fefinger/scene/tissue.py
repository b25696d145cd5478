"""Material parameters of the finger, of soft layers, bone and nail, and the ridges of the skin."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from fefinger.laws import LAWS
from fefinger.scene.key import Key, check
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


DENSITY = 1100.0
"""Mass of skin and subcutaneous tissue in kg/m³; published ones lie between 1000 and 1150."""

Modulus = Annotated[float, Key(unit="kPa", above=0)]
Poisson = Annotated[float, Key(at_least=0, at_most=0.5)]


OF_LAWS = ("exponent", "share")
"""Fields of a tissue that are parameters of the laws of the package."""


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
        Relaxation of this layer, where it differs from the finger's (`solid` only).
    share
        Fraction of the shear modulus that I1 carries in "mooney-rivlin"; by default 0.5.
    parameters
        Parameters of a law of your own, by name.
    density
        Mass in kg/m³, which `modal` alone has a use for.

    Raises
    ------
    InputError
        A value that is not a finite number in its range, a parameter of another law, or a law whose
        derivatives do not fit its energy.
    """

    table: ClassVar[str] = "tissue"

    modulus: Modulus
    poisson: Poisson
    thickness: Annotated[float | None, Key(unit="mm", above=0)] = None
    law: Annotated[str, Key(words=LAWS)] = "neo-hookean"
    exponent: Annotated[float | None, Key(above=0)] = None
    share: Annotated[float | None, Key(at_least=0, at_most=1)] = None
    prony: Prony | None = None
    density: Annotated[float, Key(unit="kg/m³", above=0)] = DENSITY
    parameters: Annotated[Mapping[str, float], Key(free=True)] = field(
        default_factory=dict, hash=False
    )

    def __post_init__(self) -> None:
        check(self)
        try:
            LAWS[self.law].check(self.law_values)
        except InputError as error:
            if str(error).startswith("tissue."):
                raise
            raise InputError(f"tissue.{error}") from error

    @property
    def law_values(self) -> tuple[float, ...]:
        """Parameters of the law, in its order."""
        own = {name: getattr(self, name) for name in OF_LAWS if getattr(self, name) is not None}
        try:
            return LAWS[self.law].values(own | dict(self.parameters))
        except InputError as error:
            table = "tissue" if str(error).partition(":")[0] in OF_LAWS else "tissue.parameters"
            raise InputError(f"{table}.{error}") from None

    @property
    def stiffens(self) -> bool:
        """Whether its law stiffens or softens with strain."""
        return LAWS[self.law].stiffens(self.law_values)


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


@dataclass(frozen=True)
class Ridges:
    """Ridges of the pad, of a sinusoidal profile: heights on the skin, which do not bend aside.

    Parameters
    ----------
    pitch
        Distance of the ridges in mm. Of people it is about 0.5 mm (Maltoni et al., Handbook of
        Fingerprint Recognition, 2009, chapter 3); of macaques no measurement was at hand.
    height
        Height in mm of the crests over the valleys. The default is a convention, as no measured
        mean was at hand: vary it.
    direction
        Degrees from across the finger (y) to the direction that straight ridges run in; at 0 they
        are crossed by what moves along the finger.
    shape
        "straight" ridges, or "concentric" about the first touch, as in a whorl.

    Raises
    ------
    InputError
        A value out of its limits.
    """

    table: ClassVar[str] = "ridges"

    pitch: Annotated[float, Key(unit="mm", at_least=0.1, at_most=2.0)] = 0.45
    height: Annotated[float, Key(unit="mm", at_least=0.0, at_most=0.5)] = 0.1
    direction: Annotated[float, Key(unit="degrees", at_least=-180, at_most=180)] = 0.0
    shape: Annotated[str, Key(words=("straight", "concentric"))] = "straight"

    def __post_init__(self) -> None:
        check(self)

    def valleys(self, places: Array) -> Array:
        """Return the depth (...,) mm of the skin below its crests, at places (..., 2) mm.

        They count from the first touch, where there is a crest, along the finger and across.
        """
        x, y = np.moveaxis(places, -1, 0)
        turn = np.radians(self.direction)
        along = np.cos(turn) * x + np.sin(turn) * y
        across = along if self.shape == "straight" else np.hypot(x, y)
        return np.asarray(self.height / 2 * (1 - np.cos(2 * np.pi * across / self.pitch)))

"""One soft layer of the finger."""

from dataclasses import dataclass

from fefinger.checks import number


@dataclass(frozen=True)
class Tissue:
    """An isotropic soft layer.

    Parameters
    ----------
    modulus
        Relaxed (long-time) Young's modulus in kPa; the instantaneous one is modulus / c0.
    poisson
        Poisson's ratio, 0 to 0.5; 0.5 is incompressible and allowed.
    thickness
        Thickness of the skin in mm; None for the tissue that fills the rest of the pulp.

    Raises
    ------
    InputError
        A value that is not a finite number in its range.
    """

    modulus: float
    poisson: float
    thickness: float | None = None

    def __post_init__(self) -> None:
        """Check every field."""
        checked = {
            "modulus": number("tissue.modulus", self.modulus, above=0, unit="kPa"),
            "poisson": number("tissue.poisson", self.poisson, at_least=0, at_most=0.5),
        }
        if self.thickness is not None:
            checked["thickness"] = number("tissue.thickness", self.thickness, above=0, unit="mm")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

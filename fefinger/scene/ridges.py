"""Fingerprint ridges of the skin: heights of the pad that meets an object."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from fefinger.scene.key import Key, check
from fefinger.support.arrays import Array


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

"""Cautions on numbers of a scene that are a thousand times too small or too large for a finger.

Each may be meant, and is answered; all of one kind together are likely in another unit.
"""

from collections.abc import Iterator
from typing import Protocol

import numpy as np

from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.support.units import LOADED, MODULUS, PRESS, SLOW, SLOWEST


class Touch(Protocol):
    """Anything with a finger and a motion, as a scene."""

    @property
    def finger(self) -> Finger:
        """The finger."""

    @property
    def motion(self) -> Motion:
        """The motion."""


def unusual(scene: Touch) -> list[str]:
    """Return sentences on moduli, depth, force and times that are likely in another unit."""
    return [*_moduli(scene), *_size(scene.motion), *_slow(scene.motion)]


def _moduli(scene: Touch) -> Iterator[str]:
    """Yield a sentence if every modulus of soft tissue suggests the same other unit."""
    layers = scene.finger.skin.modulus, scene.finger.subcutaneous.modulus
    hints = {MODULUS.hint(each) for each in layers}
    if len(hints) == 1 and (hint := hints.pop()):
        yield (
            f"the moduli of skin and subcutaneous tissue, {layers[0]:.3g} and {layers[1]:.3g} kPa, "
            f"are none of a finger{hint}; moduli are in kPa"
        )


def _size(motion: Motion) -> Iterator[str]:
    for likely, most in ((PRESS, motion.deepest), (LOADED, motion.hardest)):
        if most is not None and (hint := likely.hint(most)):
            yield (
                f"the largest {likely.what} is {most:.3g} {likely.unit}{hint}; it is in "
                f"{likely.unit}"
            )


def _slow(motion: Motion) -> Iterator[str]:
    """Yield a sentence on samples far apart of a slow press, which may have their times in ms."""
    if motion.sample_rate is None or motion.sample_rate * SLOW > 1:
        return
    time = np.array(motion.breakpoints)
    fastest = float(np.abs(np.diff(motion.value(time)) / np.diff(time)).max())
    if fastest < SLOWEST:
        yield (
            f"the samples of the motion are {1 / motion.sample_rate:.3g} s apart and it moves with "
            f"at most {fastest:.2g} {motion.unit}/s, as if its times were in ms; they are in s"
        )

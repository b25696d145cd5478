"""The rig between a finger and its record: what it does to both channels, with priors.

The force is late, passes a low-pass, and has an offset and a drift; the position includes the give
of the rig. What is loose is fitted with the finger; what is given with a deviation of 0 is taken as
it is.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any, Self

import numpy as np

from fefinger.calibration.inverse import Unknown, Values
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number, reject_unknown, shown
from fefinger.support.inputs import parse_toml, read_text
from fefinger.theory.relaxation import Prony, hereditary_integral


Prior = tuple[float, float]

UNITS = {"delay": "ms", "lag": "ms", "compliance": "mm/N", "offset": "mN", "drift": "mN/s"}
"""Units of what a rig does."""

SHARED = ("delay", "lag", "compliance")
"""What is the same in all presses of a rig; offset and drift are of a press."""

LEAST = {"lag": 0.0, "compliance": 0.0}

MOST = {"delay": 1e4, "lag": 1e4, "compliance": 100.0, "offset": 1e6, "drift": 1e6}
"""Largest size of a mean and of a deviation, in UNITS: ten seconds, a newton that moves a rig by
100 mm, a kilonewton."""

NOISE = {"force_noise": ("mN", 1e6), "position_noise": ("mm", 100.0)}
"""Units and largest sizes of the noise."""

SURE = 1e-9
"""Part of these sizes below which a deviation is none, and which a noise is at least."""

USUAL = "usual rigs: a prior of fefinger"
GIVEN = "given for the rig"


@dataclass(frozen=True)
class Rig:
    """What lies between a finger and its record, each as a mean and a standard deviation.

    Parameters
    ----------
    delay
        Time in ms by which the force is late behind the position.
    lag
        Time constant in ms of a low-pass of first order in the force that the position lacks.
    compliance
        Travel in mm/N of the rig itself, where the position is a motor's instead of the skin's.
    offset, drift
        Reading of the force in mN at first touch without load, and its change in mN/s.
    force_noise, position_noise
        Standard deviations in mN and mm of one sample; None: estimated from the record.

    Raises
    ------
    InputError
        For a deviation below 0, or a number that is not finite or beyond MOST.
    """

    delay: Prior = (0.0, 2.0)
    lag: Prior = (0.0, 0.0)
    compliance: Prior = (0.0, 0.0)
    offset: Prior = (0.0, 50.0)
    drift: Prior = (0.0, 5.0)
    force_noise: float | None = None
    position_noise: float | None = None

    def __post_init__(self) -> None:
        for name, unit in UNITS.items():
            value: Any = getattr(self, name)
            pair = tuple(value) if isinstance(value, list | tuple) else (value, 0.0)
            if len(pair) != 2:
                raise InputError(
                    f"rig.{name}: expected a mean and a standard deviation in {unit}, or the value "
                    f"alone, received {shown(value)}"
                )
            most = MOST[name]
            low = LEAST.get(name, -most)
            mean = number(f"rig.{name}", pair[0], unit=unit, at_least=low, at_most=most)
            sd = number(f"rig.{name}: deviation", pair[1], unit=unit, at_least=0, at_most=most)
            if 0 < sd < SURE * most:
                sd = 0.0  # so well known that it is given
            object.__setattr__(self, name, (mean, sd))
        for name, (unit, most) in NOISE.items():
            if getattr(self, name) is not None:
                value = getattr(self, name)
                number(f"rig.{name}", value, unit=unit, at_least=SURE * most, at_most=most)

    @classmethod
    def from_toml(cls, file: str | Path) -> Self:
        """Read a rig from a TOML file with these names, such as `delay = [0.4, 0.1]`.

        InputError for a file that cannot be read, or other names.
        """
        import tomllib

        text = read_text("--rig", file, "a TOML file of a rig")
        try:
            values = parse_toml("--rig", text)
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"--rig: expected TOML in {str(file)!r}: {error}") from None
        reject_unknown("rig", values, [each.name for each in fields(cls)])
        return cls(**values)

    def unknowns(self, press: str = "", seen: Values | None = None) -> tuple[Unknown, ...]:
        """Unknowns of the fit; press: ending of the names of what is a press's own.

        seen: what a record shows at first sight, by name, from which the search starts.
        """
        near = seen or {}
        return tuple(
            self._unknown(name, press, near.get(name)) for name in UNITS if self.is_loose(name)
        )

    def is_loose(self, name: str) -> bool:
        """Whether something is fitted: its prior has a width."""
        return bool(getattr(self, name)[1] > 0)

    def _unknown(self, name: str, press: str, seen: float | None) -> Unknown:
        mean, sd = getattr(self, name)
        start = mean if seen is None else seen
        wide = 8.0  # standard deviations of a prior to the bounds of a search
        low, high = min(mean, start) - wide * sd, max(mean, start) + wide * sd
        low = max(low, LEAST.get(name, low))
        source = USUAL if getattr(self, name) == getattr(type(self), name) else GIVEN
        own = name if name in SHARED else name + press
        prior = (mean, sd)
        return Unknown(own, start, low, high, UNITS[name], source, log=False, prior=prior)

    def at(self, values: Values, press: str = "") -> dict[str, float]:
        """Return the parameters of the rig by name, in UNITS, at the values of a fit."""
        own = {name: name if name in SHARED else name + press for name in UNITS}
        return {name: values.get(own[name], getattr(self, name)[0]) for name in UNITS}

    def record(self) -> Mapping[str, Any]:
        """Convert the rig to plain values."""
        return asdict(self)


def lagged(time: Array, force: Array, lag: float) -> Array:
    """Return a force (n_t,) behind a low-pass of first order, with its time constant `lag` in s."""
    if lag <= 0:
        return force
    # Half of this integral is the force, the other the exponential, by which the low-pass is late.
    mixed = hereditary_integral(Prony((0.5, 0.5), (1 / lag,)), time, force)
    return np.asarray(2 * (force - mixed))

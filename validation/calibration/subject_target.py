"""Subjects of Pawluk (1997) as targets of a calibration: the lumped finger and R that are printed.

There is no record of them. Stiffness and relaxation come from Table 2.1, with the scatter that the
printed VAF leave, and the pad radius from R of Table 3.2.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fefinger.calibration import targets
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Unknown, Values
from fefinger.calibration.outcome import line
from fefinger.calibration.pad_radius import PadFit
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration
from fefinger.calibration.search import Search
from fefinger.calibration.targets import LumpedLaw, errors
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.motions import RampSinusoid
from fefinger.support.arrays import Array
from fefinger.support.checks import choice
from fefinger.support.progress import Progress
from fefinger.theory.lumped.spring import Spring, constant_velocity, contact_force
from fefinger.theory.relaxation import Prony


SPEED = 60.0
"""mm/s of the ramps of Pawluk (1997)."""

PEAK = 2.5
"""N at the end of these ramps (2 to 3 N, section 2.2.2)."""

FORCES = 40
"""Number of forces at which the stiffness of a subject is compared: a ramp of 30 ms, sampled at 13
kHz and averaged over 9 samples, has about as many independent values."""

HOLD = 6.0
"""Length of the holds of Pawluk (1997) in s (5 to 7 s)."""

FREQUENCIES = (2, 4, 8, 16)
"""Hz of the sinusoids of the thesis (section 2.2.2), which are predicted and not fitted."""

OPERATING = 2.0
"""Instantaneous force in N about which they oscillate; in the thesis 0 to 2 N."""

SWING = 0.5
"""Their amplitude times m: the stiffness varies by a factor e over a cycle."""


@dataclass(frozen=True)
class SubjectTarget:
    """Target of a subject of Table 2.1: elastic stiffness against force, and relaxation.

    force (n,) N of the instantaneous response; stiffness (n,) N/mm and stiffness_sd N/mm, the
    scatter that VAF_k leaves; time (k,) s after a step, relaxation (k,) and relaxation_sd likewise.
    """

    name: str
    spring: Spring
    prony: Prony
    force: Array
    stiffness: Array
    stiffness_sd: float
    time: Array
    relaxation: Array
    relaxation_sd: float

    unknowns: tuple[Unknown, ...] = ()
    shows_ratio: bool = False
    advice: str = ""

    @property
    def lumped_law(self) -> LumpedLaw:
        """The lumped model of the subject."""
        return LumpedLaw(self.spring, self.prony, float(self.force[-1]))

    def residual(self, law: ForceLaw, values: Values) -> Array:
        """Residuals (n + k,) of a force law, in standard deviations."""
        stiffnesses = law.stiffness(self.force) - self.stiffness
        relaxation = law.prony.relaxation(self.time) - self.relaxation
        return np.concatenate([stiffnesses / self.stiffness_sd, relaxation / self.relaxation_sd])

    def weighed(
        self, law: Callable[[Values], ForceLaw], unknowns: Sequence[Unknown], values: Values
    ) -> Self:
        """Return the same target: the printed scatter is not known better from a fit."""
        return self

    def reach(self, law: ForceLaw, values: Values) -> float:
        """Depth in mm at the largest force."""
        return float(law.depth(self.force[-1]))

    def misfits(self, law: ForceLaw, values: Values) -> dict[str, float]:
        """Line of stiffness against force, beside the printed one, and the distance from it."""
        fitted = law.stiffness(self.force)
        m, b = line(self.force, fitted)
        rms = float(np.sqrt(np.mean((fitted - self.stiffness) ** 2)) / self.stiffness.mean())
        wanted = {"m": m, "m, wanted": self.spring.m, "b": b, "b, wanted": self.spring.b}
        return wanted | {"stiffness rms over its mean": rms}

    def remarks(self, values: Values, *, finite: bool, with_frames: bool) -> tuple[str, ...]:
        """Return none."""
        return ()

    def quality(self, residuals: dict[str, float]) -> str:
        """Say how close the line is."""
        return (
            f"m {residuals['m']:.3g} of {residuals['m, wanted']:.3g} 1/mm, b {residuals['b']:.2g} "
            f"of {residuals['b, wanted']:.2g} N/mm"
        )

    def checks(self, law: ForceLaw) -> dict[str, dict[str, float]]:
        """Errors of the prediction of the subject's sinusoids, by frequency.

        The subject is represented by the lumped model, which can lose contact. Its touch is set for
        equal elastic force at the operating point, as the thesis shifts its x0 by up to 80 um.
        """
        spring, deep = self.spring, float(self.spring.position(OPERATING))
        offset, found = float(law.depth(OPERATING)) - deep, {}
        for frequency in FREQUENCIES:
            swing = SWING / spring.m
            motion = RampSinusoid(
                20.0, deep, amplitude=swing, frequency=frequency, cycles=5, corner=0.0
            )
            time = np.linspace(0.0, motion.duration, 1201)
            depth = motion.value(time)
            measured = contact_force(spring, self.prony, time, depth)
            found[f"{frequency} Hz"] = errors(measured, law.predicted(time, depth + offset))
        return found


def target_of(name: str) -> SubjectTarget:
    """Make the target of a subject of Table 2.1, or of its means, from the lumped model.

    InputError for a name that Table 2.1 does not have.
    """
    rows = library.lumped()
    choice("subject", name, rows)
    row = rows[name]
    stiffness_vaf, hold_vaf = row.vaf
    spring = Spring(row.b, row.m)
    deepest = float(spring.position(PEAK / row.prony.long_time))
    depth = np.linspace(0.0, deepest, 2000)
    ramp = constant_velocity(spring, row.prony, depth, SPEED)
    top = float(spring.force(np.interp(PEAK, ramp, depth)))
    force = np.linspace(0.0, top, FORCES + 1)[1:]
    time = np.geomspace(1e-3, HOLD, 100)
    even = row.prony.relaxation(np.linspace(1e-3, HOLD, 10000))
    stiffness = spring.stiffness(force)
    return SubjectTarget(
        name=name,
        spring=spring,
        prony=row.prony,
        force=force,
        stiffness=stiffness,
        stiffness_sd=math.sqrt(1 / stiffness_vaf - 1) * float(np.std(stiffness)),
        time=time,
        relaxation=row.prony.relaxation(time),
        relaxation_sd=math.sqrt(1 / hold_vaf - 1) * float(np.std(even)),
    )


def printed(name: str) -> PadFit:
    """Return the row of Table 3.2 of a subject."""
    row = library.quasistatic()[name]
    return PadFit(row.radius, row.m, row.b, float("nan"))


def calibrate_subject(
    name: str,
    *,
    finger: Finger | None = None,
    mechanics: str = "solid",
    resolution: str = "standard",
    progress: Progress | None = None,
) -> Calibration:
    """Fit a finger to a subject, by default one of the subject's size and published tissue.

    Other arguments and errors as `fefinger.calibrate`.
    """
    start = finger or targets.finger_of(name)
    work = Work(replace(start, resolution=resolution), progress)
    return Search(work, target_of(name), None, printed(name)).calibration(mechanics)

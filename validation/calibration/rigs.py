"""Records as rigs give them: a true press, seen through delay, offset, drift and noise."""

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
from fefinger.validation.calibration.twin import PRONY, written

from fefinger.calibration import targets
from fefinger.calibration.outcome import stiffening
from fefinger.calibration.slow_press import PLATE
from fefinger.mechanics import solid
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.theory.relaxation import Prony


MODULUS, EXPONENT, TOUCH = 9.0, 4.2, 0.75  # kPa, 1, mm
DEPTH, HOLD = 1.5, 6.0  # mm, s
RATE, REST = 2500.0, 0.2
"""Samples per s, and s of rest before the motion, 0.75 mm off the skin."""

COLORS = ("white", "low-pass", "1 / f")
LOW_PASS = 30.0
"""Hz of the filter of second order through which noise has passed."""

TRUTH = {
    **{"modulus": MODULUS, "exponent": EXPONENT, "x0": TOUCH},
    **{f"c{i}": c for i, c in enumerate(PRONY.weights)},
    **{f"v{i}": v for i, v in enumerate(PRONY.v, start=1)},
}


@dataclass(frozen=True)
class Faults:
    """What a rig does to a press.

    force_noise N and position_noise mm: standard deviations; late s: of the force; offset N;
    drift: N that the force gains over the record; compliance mm/N between position and skin;
    color: of the noise of the force, one of COLORS.
    """

    force_noise: float = 3e-3
    position_noise: float = 1e-3
    late: float = 0.0
    offset: float = 0.0
    drift: float = 0.0
    compliance: float = 0.0
    color: str = "white"


@dataclass(frozen=True)
class Record:
    """A record: time s, position mm and force N (n_t,)."""

    time: Array
    position: Array
    force: Array

    def save(self, file: Path) -> Path:
        """Write the record as CSV."""
        return written(file, "time,position,force", self.time, self.position, self.force)


@dataclass(frozen=True)
class Press:
    """A press without noise: time s and position mm (n_t,); pressed N at the times `grid` s (m,).

    The force is finer in time than the samples, so that one that is late has its corner where it
    belongs.
    """

    time: Array
    position: Array
    grid: Array
    pressed: Array

    def force(self, late: float = 0.0) -> Array:
        """Return the force (n_t,) N, `late` s behind."""
        return np.interp(self.time - late, self.grid, self.pressed)

    def measured(self, faults: Faults, seed: int) -> Record:
        """Return what a rig records of it."""
        rng, time = np.random.default_rng(seed), self.time
        force = self.force(faults.late) + faults.offset + faults.drift * time / time[-1]
        position = self.position + faults.compliance * self.force()
        return Record(
            time,
            position + rng.normal(0.0, faults.position_noise, len(time)),
            force + faults.force_noise * colored(faults.color, time, rng),
        )


def colored(color: str, time: Array, rng: np.random.Generator) -> Array:
    """Draw noise (n_t,) of one of COLORS, of variance 1, at even times s."""
    white = rng.normal(size=len(time))
    if color == "white":
        return white
    if color == "1 / f":
        # From the lowest frequency of the record on: nothing is slower.
        waves = np.fft.rfft(white)
        waves[1:] /= np.sqrt(np.arange(1, len(waves)))
        waves[0] = 0.0
        off = np.fft.irfft(waves, len(time))
        return np.asarray(off / off.std())
    from scipy.signal import butter, sosfilt

    rate = (len(time) - 1) / (time[-1] - time[0])
    passing = butter(2, LOW_PASS, fs=rate, output="sos")
    begun = np.concatenate([rng.normal(size=int(rate / LOW_PASS) * 3), white])
    off = sosfilt(passing, begun)[-len(time) :]
    return np.asarray(off / off.std())


def start() -> Finger:
    """Return the finger that is fitted, of published tissue, on the coarse mesh."""
    return targets.finger_of(None, width=15.0, thickness=11.0, resolution="coarse")


@cache
def solid_press(
    speed: float,
    depth: float = DEPTH,
    hold: float = HOLD,
    modulus: float = MODULUS,
    exponent: float = EXPONENT,
    prony: Prony = PRONY,
    touch: float = TOUCH,
    rate: float = RATE,
) -> Press:
    """Return a press by `solid`, in which the stress of every element relaxes."""
    base = start()
    finger = replace(stiffening(base, exponent, modulus / base.subcutaneous.modulus), prony=prony)
    scene = Scene(
        finger=finger,
        indenter=PLATE,
        motion=RampHold(speed, depth, hold=hold, corner=0.0),
        ask=Ask(strain=False, fields=False, pressure=False),
    )
    response = solid.respond(scene)
    begins = REST + touch / speed
    time = np.arange(0.0, begins + response.time[-1], 1 / rate)
    position = np.clip(speed * (time - REST), 0.0, touch + depth)
    grid = np.concatenate([[0.0], begins + response.time])
    return Press(time, position, grid, np.concatenate([[0.0], response.force]))

"""Fingers, rigs and protocols drawn from stated distributions, and their calibration.

The force of a finger is that of presses by `solid` between the exponents that were solved, with the
errors of the mesh and of one G that a fit counts with; some are stepped by `solid` itself, whose
stress relaxes in every element. What is drawn is what the priors of the fit say, where it has any.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fefinger.validation.calibration.rigs import REST, Faults, Press, solid_press, start

from fefinger.calibration.calibrate import calibrate
from fefinger.calibration.curve import Family, ForceLaw, family
from fefinger.calibration.press_store import Work
from fefinger.calibration.record import Calibration
from fefinger.calibration.record_target import LENGTH, MESH
from fefinger.calibration.rig import Rig
from fefinger.calibration.search import (
    AGAINST,
    EXPONENTS,
    MIDDLE,
    ONE_G_BIAS,
    STIFFENING_BIAS,
)
from fefinger.calibration.targets import RATE_SD, RATIO_SD, SHAPE, SHARE_SD
from fefinger.scene import library
from fefinger.support.arrays import Array
from fefinger.theory.relaxation import Prony


APART = 3.0
"""Least ratio of rates of G that are drawn: closer ones are one term."""

NODES = 1500
"""Samples of the ramp by which the force between them is exact to 1e-4."""


@dataclass(frozen=True)
class Drawn:
    """A finger, a rig and a protocol: parameters by name, faults, speed mm/s, depth mm, hold s."""

    truth: dict[str, float]
    ratio: float
    faults: Faults
    speed: float
    depth: float
    hold: float
    rate: float

    @property
    def prony(self) -> Prony:
        """G."""
        c = tuple(self.truth[f"c{i}"] for i in range(4))
        return Prony(c, tuple(self.truth[f"v{i}"] for i in range(1, 4)))


def drawn(seed: int, *, by_solid: bool, color: str = "white") -> Drawn:
    """Draw one; by_solid: with the ratio of moduli that the fit has, and no relaxation below.

    color: of the noise of the force.
    """
    rng = np.random.default_rng([seed, by_solid])
    table = library.relaxation()["means"]
    c, v = np.array(table.weights), np.array(table.v)
    while True:
        rates = v * np.exp(RATE_SD * rng.normal(size=3))
        if (rates[:-1] > APART * rates[1:]).all():
            break
    shares = np.append(c[0], c[1:] * np.exp(SHARE_SD * rng.normal(size=3)))
    shares /= shares.sum()
    rig, hold = Rig(), float(rng.uniform(2, 8))
    truth = {
        "modulus": 9.0 * math.exp(0.5 * rng.normal()),
        "exponent": float(rng.uniform(1.5, 5.5)),
        "x0": float(rng.uniform(0.3, 1.0)),
        "delay": float(rig.delay[1] * rng.normal()),
        "offset": float(rig.offset[1] * rng.normal()),
        "drift": float(rig.drift[1] * rng.normal()),
        **{f"c{i}": float(each) for i, each in enumerate(shares)},
        **{f"v{i}": float(each) for i, each in enumerate(rates, start=1)},
    }
    faults = Faults(
        force_noise=math.exp(rng.uniform(math.log(2e-3), math.log(3e-2))),
        position_noise=math.exp(rng.uniform(math.log(1e-3), math.log(1e-2))),
        late=1e-3 * truth["delay"],
        color=color,
    )
    speed = math.exp(rng.uniform(math.log(20), math.log(100)))
    depth, rate = float(rng.uniform(1.1, 1.7)), float(rng.choice([2e3, 5e3, 1e4]))
    ratio = 1.0 if by_solid else math.exp(RATIO_SD * rng.normal())
    return Drawn(truth, ratio, faults, speed, depth, hold, rate)


@cache
def curves() -> Family:
    """Return the presses by `solid` of the finger at EXPONENTS, and with another skin."""
    work, radius = Work(start(), None), start().pad_radius
    found = family(EXPONENTS, radius, lambda each: work.press("solid", "coarse", radius, each))
    stiff = work.press("solid", "coarse", radius, MIDDLE, AGAINST)
    return found.with_ratio(stiff, MIDDLE, AGAINST)


def press_of(draw: Drawn, seed: int, *, by_solid: bool) -> Press:
    """Return the press of a finger, without its rig."""
    truth = draw.truth
    if by_solid:
        return solid_press(
            draw.speed,
            draw.depth,
            draw.hold,
            truth["modulus"],
            truth["exponent"],
            draw.prony,
            truth["x0"],
            draw.rate,
        )
    off = _of_one_g(np.random.default_rng([seed, 8]))
    finger = curves().at(off[SHAPE] * truth["exponent"], start().pad_radius, draw.ratio)
    law = ForceLaw(finger, _bent(draw.prony, off), truth["modulus"] / start().subcutaneous.modulus)
    ends = draw.depth / draw.speed
    grid = np.concatenate(
        [np.linspace(0, ends, NODES), ends + np.geomspace(1e-5, draw.hold, NODES)]
    )
    deep = draw.speed * np.minimum(grid, ends)
    error = 1 + MESH["coarse"] * _walk(deep, np.random.default_rng([seed, 7]))
    force = law.loading(grid, deep) * error
    begins = REST + truth["x0"] / draw.speed
    time = np.arange(0.0, begins + ends + draw.hold, 1 / draw.rate)
    position = np.clip(draw.speed * (time - REST), 0.0, truth["x0"] + draw.depth)
    return Press(time, position, np.append(0.0, begins + grid), np.append(0.0, force))


def _of_one_g(rng: np.random.Generator) -> dict[str, float]:
    """Draw the factors on exponent and relaxation by which a law of one G is off, by name."""
    deviations = ONE_G_BIAS | {SHAPE: STIFFENING_BIAS}
    return {name: math.exp(sd * rng.normal()) for name, sd in deviations.items()}


def _bent(prony: Prony, off: Mapping[str, float]) -> Prony:
    """Return G with factors on rates, and on weights over the relaxed one."""
    c = [prony.weights[0]]
    c += [each * off[f"c{i}/c0"] for i, each in enumerate(prony.weights[1:], start=1)]
    rates = (v * off.get(f"v{i}", 1.0) for i, v in enumerate(prony.v, start=1))
    return Prony(tuple(each / sum(c) for each in c), tuple(rates))


def _walk(depth: Array, rng: np.random.Generator) -> Array:
    """Draw an error (n,) of variance 1 that is alike over LENGTH of depth."""
    kept = np.exp(-np.abs(np.diff(depth)) / LENGTH)
    off = np.empty(len(depth))
    off[0] = rng.normal()
    for i, (keep, new) in enumerate(zip(kept, rng.normal(size=len(kept)), strict=True)):
        off[i + 1] = keep * off[i] + np.sqrt(1 - keep**2) * new
    return off


def calibrated(draw: Drawn, seed: int, *, by_solid: bool) -> Calibration:
    """Return the calibration of the record that the rig gives of a finger."""
    press = press_of(draw, seed, by_solid=by_solid).measured(draw.faults, seed)
    touch = REST + draw.truth["x0"] / draw.speed
    added = 1e-3 * (draw.truth["offset"] + draw.truth["drift"] * (press.time - touch))
    record = replace(press, force=press.force + added)
    with TemporaryDirectory() as folder:
        file = record.save(Path(folder) / "press.csv")
        return calibrate(file, finger=start(), resolution="coarse")


def missed(draw: Drawn, found: Calibration) -> dict[str, float]:
    """Return by how many deviations every parameter misses the truth."""
    return {name: found[name].score(true) for name, true in draw.truth.items()}


def row(seed: int, *, by_solid: bool) -> dict[str, Any]:
    """Return one drawn record as plain values: what it was, and what was missed."""
    draw = drawn(seed, by_solid=by_solid)
    told = {"seed": seed, "solid": by_solid, "speed": round(draw.speed, 1)}
    try:
        found = calibrated(draw, seed, by_solid=by_solid)
    except (ValueError, RuntimeError) as error:
        return told | {"refused": str(error).partition(": ")[2][:200]}
    sizes = [found.residuals[f"model error of the {name}"] for name in ("force", "relaxation")]
    return told | {
        "scores": {name: round(each, 3) for name, each in missed(draw, found).items()},
        "model_errors": [float(f"{size:.2g}") for size in sizes],
        "cpu_s": round(sum(stage.cpu for stage in found.stages), 1),
    }

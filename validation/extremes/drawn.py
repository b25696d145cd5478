"""Scenes drawn by seed over the ranges of every number at once, for each mechanics in turn."""

from collections.abc import Iterator
from functools import cache, partial
from typing import Any

import numpy as np
from fefinger.validation.extremes.scenes import PULP, pressed
from fefinger.validation.extremes.trial import Findings, Trial

from fefinger.results.candidate import MECHANICS
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Ellipsoid, Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold, RampSinusoid, Trapezoid
from fefinger.scene.tissue import Tissue
from fefinger.theory.relaxation import Prony


SEED = 8

COUNTS = {"lumped": 12, "hertz": 36, "layered": 24, "linear": 9, "condensed": 6, "solid": 2}
"""Scenes for each mechanics; those on meshes share a few tissues, which cost a factor each."""


@cache
def trials() -> tuple[Trial, ...]:
    """Return the drawn scenes."""
    return tuple(_drawn())


def _drawn() -> Iterator[Trial]:
    for number, (mechanics, count) in enumerate(COUNTS.items()):
        for scene in range(count):
            ask = partial(drawn, mechanics, (SEED, number, scene))
            yield Trial(mechanics, "drawn", f"seed {SEED}, scene {scene + 1}", ask)


def drawn(mechanics: str, seed: tuple[int, ...]) -> Findings:
    """Return the invariants of a scene drawn by a seed; what it cannot be is refused."""
    rng = np.random.default_rng(seed)
    meshed = MECHANICS[mechanics].meshed
    rough = np.random.default_rng((*seed[:2], seed[2] % 3)) if meshed else rng
    settings: dict[str, Any] = {
        "indenter": _indenter(rng),
        "motion": _motion(rng, meshed=meshed),
        "prony": _prony(rng),
    }
    return pressed(mechanics, settings | _tissues(rough))


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10 ** rng.uniform(np.log10(low), np.log10(high)))


def _indenter(rng: np.random.Generator) -> Indenter:
    """Return a plate of 0 to 80 degrees, or a ball or ellipsoid of 0.1 mm to 1 m."""
    kind = rng.integers(4)
    if kind < 2:
        return Flat(float(rng.uniform(0, 80)), float(rng.choice([0.0, 0.0, 10.0])))
    if kind == 2:
        at = None if rng.integers(2) else tuple(rng.uniform(-3, 3, 2).tolist())
        return Sphere(_log(rng, 0.1, 1e3), at)
    a, b = _log(rng, 1, 1e3), _log(rng, 1, 1e3)
    return Ellipsoid((a, b, max(a, b)))


def _motion(rng: np.random.Generator, *, meshed: bool) -> Motion:
    """Return a motion to 1e-6 mm to 60 % of the tissue at 1e-4 to 1e4 mm/s, or a force."""
    depth = _log(rng, 0.01 if meshed else 1e-6, 0.6 * PULP)
    speed = _log(rng, 1e-4, 1e4)
    corner = min(0.01, 0.3 * depth / speed) * float(rng.integers(2))
    kind = rng.integers(5)
    if kind == 0:
        return Ramp(speed, depth, corner=corner)
    if kind == 1:
        return RampHold(speed, depth, hold=_log(rng, 1e-3, 1e3), corner=corner)
    if kind == 2:
        return Trapezoid(speed, depth, hold=0.0, corner=corner)
    if kind == 3:
        force = _log(rng, 1e-3 if meshed else 1e-9, 10)
        return RampHold(
            loading_rate=force / _log(rng, 1e-3, 1e3), force=force, hold=1.0, corner=0.0
        )
    amplitude, frequency = depth * float(rng.uniform(0.1, 0.6)), _log(rng, 1e-2, 1e3)
    return RampSinusoid(speed, 0.6 * depth, amplitude=amplitude, frequency=frequency, cycles=3,
                        corner=min(corner, 1 / frequency))  # fmt: skip


def _prony(rng: np.random.Generator) -> Prony:
    """Return one to ten terms at 1e-6 to 1e6 1/s, G(infinity) from 1e-4 to 0.9999."""
    count = int(rng.integers(1, 11))
    near = _log(rng, 1e-4, 0.5)
    left = near if rng.integers(2) else 1 - near
    shares = rng.dirichlet(np.ones(count)) * (1 - left)
    return Prony((left, *shares.tolist()), tuple(_log(rng, 1e-6, 1e6) for _ in range(count)))


def _tissues(rng: np.random.Generator) -> dict[str, Tissue]:
    """Return skin and pulp with moduli up to 1e9 apart and any Poisson's ratio."""
    modulus, contrast = _log(rng, 1e-3, 1e6), _log(rng, 1e-9, 1e9) ** float(rng.uniform(0, 1))
    below, above = (float(rng.choice([0.0, 0.3, 0.45, 0.499, 0.5])) for _ in range(2))
    return {
        "skin": Tissue(modulus * contrast, above, 1.0),
        "subcutaneous": Tissue(modulus, below),
    }

"""Suite `relaxation`: the finite elements' history against the hereditary integral."""

from collections.abc import Iterator
from functools import cache

import numpy as np
from fefinger.validation.case import Case
from numpy.typing import NDArray

from fefinger.fem.march import Prescribed, Relaxation, march
from fefinger.library import pawluk_bulk, pawluk_relaxation
from fefinger.theory.relaxation import Prony, hereditary_integral


Array = NDArray[np.float64]

NONE = Prony((1.0,), ())
INVERSION = (
    ("Table 3.1 means", (0.4929, 7.3702, 116.941)),
    ("Table 2.1 a.h.", (0.3805, 9.5188, 136.370)),
)
SPEEDS = ((0.1, 0.294), (1.0, 0.403), (16.0, 0.596), (60.0, 0.727), (1000.0, 0.962))


def pressed(prony: Prony, time: Array, depth: Array) -> Array:
    """Return the force in mN of a small pad with known flexibility under a given depth."""
    x = np.linspace(-1, 1, 21)
    flexibility = 0.02 * np.exp(-np.abs(x[:, None] - x) / 0.4) + 0.005 * np.eye(21)
    weights = np.full(21, 0.1)
    memory = Relaxation(np.array(prony.weights), np.array(prony.v), 21)
    history = march(
        flexibility, weights * x**2 / 2, weights, memory, Prescribed("depth", time, depth)
    )
    return np.asarray(history.pressure @ weights)


@cache
def step_error(subject: str) -> float:
    """Return the largest error of the force after a step against G(t), relative to the step."""
    prony = pawluk_relaxation()[subject]
    time = np.concatenate([[0.0], np.geomspace(1e-6, 1e3, 80)])
    force = pressed(prony, time, np.full_like(time, 0.3))
    return float(np.abs(force / force[0] - prony.relaxation(time)).max())


@cache
def ramp_error(subject: str) -> float:
    """Return the largest error of ramp and hold against the integral of G dT, over the peak."""
    prony = pawluk_relaxation()[subject]
    time = np.concatenate([np.linspace(0, 0.025, 400), 0.025 + np.geomspace(1e-4, 5, 60)])
    depth = 0.4 * np.minimum(time / 0.025, 1.0)
    expected = hereditary_integral(prony, time, pressed(NONE, time, depth)) / prony.long_time
    return float(np.abs(pressed(prony, time, depth) - expected).max() / expected.max())


def ratio(speed: float) -> float:
    """Return P / T for an exponential T at constant speed, a.h., by the hereditary integral."""
    lumped = pawluk_bulk()["a.h."]
    time = np.linspace(0, 2.0 / speed, 20001)
    elastic = lumped.b / lumped.m * np.expm1(lumped.m * speed * time)
    return float(hereditary_integral(lumped.prony, time, elastic)[-1] / elastic[-1])


def rate(source: str, index: int) -> float:
    """Return a creep rate in 1/s by the inversion of a Prony series."""
    prony = pawluk_relaxation()["means"] if "3.1" in source else pawluk_bulk()["a.h."].prony
    return float(np.sort(prony.creep()[2])[index])


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield step, ramp, constant speed and inversion."""
    for subject in ("a.h.",) if quick else tuple(pawluk_relaxation()):
        yield Case(
            "relaxation",
            f"step against G(t), {subject}",
            lambda s=subject: step_error(s),
            0.0,
            1e-9,
            "1",
            "Eq. 2.2",
        )
        yield Case(
            "relaxation",
            f"ramp and hold against the integral of G dT, {subject}",
            lambda s=subject: ramp_error(s),
            0.0,
            1e-3,
            "1",
            "Eq. 2.3",
        )
    for speed, expected in SPEEDS:
        yield Case(
            "relaxation",
            f"P / T at {speed:g} mm/s, a.h., x = 2 mm",
            lambda v=speed: ratio(v),
            expected,
            6e-4,
            "1",
            "recomputed A5-3: sum of ci m v / (m v + vi)",
        )
    for source, rates in INVERSION:
        for index, expected in enumerate(rates):
            yield Case(
                "relaxation",
                f"creep rate {index + 1}, {source}",
                lambda s=source, i=index: rate(s, i),
                expected,
                1e-4 * expected,
                "1/s",
                "recomputed B5: roots of c0 + sum ci s / (s + vi)",
            )

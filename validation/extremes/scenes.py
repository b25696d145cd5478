"""Named scenes at the edges of the parameters, for every mechanics that can respond to them."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from fefinger.validation.extremes.invariants import invariants, off
from fefinger.validation.extremes.trial import ANSWERED, REFUSED, Findings, Kind, Trial
from fefinger.validation.problems import published

from fefinger.mechanics import get
from fefinger.pipeline import run
from fefinger.plan import choose
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Ellipsoid, Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold, RampSinusoid, Sinusoid, Trapezoid
from fefinger.scene.samples import Sampled
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Tissue
from fefinger.theory.relaxation import Prony


SIMPLE = ("lumped", "hertz", "layered")
MESHED = ("linear", "condensed")
ALL = (*SIMPLE, *MESHED)

SUBJECT = "a.h."
PULP = 5.0
"""mm of soft tissue of that subject, of which depths are parts."""


def ramp(speed: float, depth: float) -> Ramp:
    """Return a ramp with corners of 10 ms, or half its length where that is shorter."""
    return Ramp(speed, depth, corner=min(0.01, 0.5 * depth / speed))


RAMP = ramp(60, 0.6)

SERIES: dict[str, Prony] = {
    "G(inf) = 1e-6": Prony((1e-6, 1 - 1e-6), (5.0,)),
    "G(inf) = 1 - 1e-9": Prony((1 - 1e-9, 1e-9), (5.0,)),
    "no terms": Prony((1.0,), ()),
    "10 terms, 1e-6 to 1e6 1/s": Prony((0.1, *(10 * (0.09,))), tuple(np.logspace(-6, 6, 10))),
    "rate 1e-6 1/s": Prony((0.3, 0.7), (1e-6,)),
    "rate 1e6 1/s": Prony((0.3, 0.7), (1e6,)),
    "ten equal rates": Prony((0.1, *(10 * (0.09,))), 10 * (3.0,)),
}


def scene(
    mechanics: str,
    *,
    indenter: Indenter | None = None,
    motion: Motion = RAMP,
    ask: dict[str, Any] | None = None,
    **finger: Any,
) -> Scene:
    """Return a scene that asks for all that a mechanics has, on the coarse mesh."""
    more = mechanics != "lumped"
    ask_of_scene = Ask(fields=False, pressure=more, strain=more)
    return Scene(
        name=f"{mechanics} at an edge",
        finger=published.subject(SUBJECT, **({"resolution": "coarse"} | finger)),
        indenter=indenter or Flat(30),
        motion=motion,
        ask=replace(ask_of_scene, **(ask or {})),
    )


def answered(mechanics: str, settings: dict[str, Any]) -> tuple[Scene, Response]:
    """Return the scene and the response of the mechanics, in spite of refusals about accuracy."""
    made = scene(mechanics, **settings)
    choose(made, mechanics)  # tells what it is not able to do
    return made, get(mechanics).respond(made)


def pressed(mechanics: str, settings: dict[str, Any]) -> Findings:
    """Return the invariants of a scene."""
    return invariants(*answered(mechanics, settings))


@cache
def trials() -> tuple[Trial, ...]:
    """Return the named scenes."""
    return (
        *_depths(),
        *_radii(),
        *_angles(),
        *_speeds(),
        *_tissues(),
        *_series(),
        *_motions(),
        *_solid(),
        *_twins(),
    )


def _each(
    mechanics: tuple[str, ...],
    edge: str,
    name: str,
    wants: Kind | None = ANSWERED,
    **settings: Any,
) -> Iterator[Trial]:
    for one in mechanics:
        yield Trial(one, edge, name, partial(pressed, one, settings), wants)


def _depths() -> Iterator[Trial]:
    """Depths from 1e-6 mm to 60 % of the tissue, by depth and by force."""
    for depth in (1e-6, 1e-4, 0.02, 0.1):
        wants = REFUSED if depth < 1e-3 else None  # the contact is smaller than a facet
        yield from _each(SIMPLE, "depth", f"{depth:g} mm", motion=ramp(60, depth))
        yield from _each(MESHED, "depth", f"{depth:g} mm", wants, motion=ramp(60, depth))
    for part in (0.3, 0.6):
        motion = ramp(60, part * PULP)
        yield from _each(("lumped", "hertz"), "depth", f"{part:.0%} of the tissue", motion=motion)
        yield from _each(MESHED, "depth", f"{part:.0%} of the tissue", None, motion=motion)
    deep = {"indenter": Sphere(5), "motion": ramp(60, 0.6 * PULP)}
    yield from _each(ALL[1:], "depth", "ball of 5 mm, 60% of the tissue", None, **deep)
    for force in (1e-9, 1e-3, 1.0, 100.0):
        push = RampHold(loading_rate=10 * force, force=force, hold=1.0, corner=0.0)
        wants = ANSWERED if force <= 1 else None
        yield from _each(SIMPLE, "force", f"{force:g} N", wants, motion=push)
        yield from _each(MESHED, "force", f"{force:g} N", None, motion=push)


def _radii() -> Iterator[Trial]:
    """Balls from 0.1 mm to 1 m."""
    for radius, depth in ((0.1, 0.05), (0.1, 0.6), (0.5, 0.3), (1e3, 0.6)):
        settings = {"indenter": Sphere(radius), "motion": ramp(60, depth)}
        wants = ANSWERED if radius == 1e3 else None
        yield from _each(ALL[1:], "radius", f"{radius:g} mm, {depth:g} mm deep", wants, **settings)
    for radii in ((0.1, 100.0, 1.0), (20.0, 20.0, 0.01), (100.0, 100.0, 1e4)):
        settings = {"indenter": Ellipsoid(radii), "motion": ramp(60, 0.2)}
        yield from _each(ALL[1:], "radius", f"half axes {radii} mm", None, **settings)


def _angles() -> Iterator[Trial]:
    """Plates from 0 to 80 degrees, tilted ones, and places off the middle of the pad."""
    for angle in (0.0, 20.0, 30.0, 40.0, 60.0):
        settings = {"indenter": Flat(angle), "motion": ramp(60, 0.4)}
        meshed = MESHED if angle in (20.0, 30.0) else MESHED[1:]  # others build a mesh of their own
        yield from _each((*SIMPLE, *meshed), "angle", f"{angle:g} degrees", None, **settings)
    yield Trial(
        "hertz", "angle", "80 degrees", lambda: pressed("hertz", {"indenter": Flat(80.0)}), REFUSED
    )
    for tilt in (45.0, 1e-9):
        settings = {"indenter": Flat(30, tilt), "motion": ramp(60, 0.4)}
        yield from _each(ALL, "angle", f"30 degrees, tilted by {tilt:g}", None, **settings)
    for at in ((0.0, 0.0), (3.0, 2.0), (-5.0, 0.0), (0.0, 7.0), (20.0, 0.0)):
        settings = {"indenter": Sphere(3, at), "motion": ramp(60, 0.3)}
        yield from _each(("hertz", "condensed"), "place", f"ball at {at} mm", None, **settings)


def _speeds() -> Iterator[Trial]:
    """Ramps at 1e-4 to 1e4 mm/s, steps of 1e-6 to 1e3 s, and sharp corners."""
    for speed in (1e-4, 1e-2, 1e3, 1e4):
        motion = RampHold(speed, 0.6, hold=1.0, corner=min(0.01, 0.3 / speed))
        who = SIMPLE if speed == 1e-2 else ALL
        yield from _each(who, "speed", f"{speed:g} mm/s", motion=motion)
    for speed in (60.0, 1e4):
        name = f"{speed:g} mm/s, and whether inertia is warned of"
        yield Trial("hertz", "speed", name, partial(_warned, speed), ANSWERED)
    for step in (1e-6, 1e3):
        times = step * np.arange(9)
        samples = Sampled(tuple(times), tuple(0.6 * np.minimum(np.arange(9) / 4, 1.0)))
        yield from _each(ALL, "time step", f"samples every {step:g} s", motion=samples)
    jump = Sampled((0.0, 1.0), (0.6, 0.6))
    yield from _each(ALL, "time step", "a jump to 0.6 mm", motion=jump)
    yield from _each(ALL, "time step", "a hold of 1e6 s", motion=RampHold(60, 0.6, hold=1e6))


def _warned(speed: float) -> Findings:
    """Return whether the result warns of waves of a fast ramp, and of no slow one."""
    made = scene("hertz", motion=ramp(speed, 0.6))
    result = run(made, mechanics="hertz")
    warned = any("not quasi-static" in note for note in result.notes)
    return {"warned": (float(warned != (speed > 1e3)), 0.0)}


def _tissues() -> Iterator[Trial]:
    """Poisson's ratios from 0 to 0.5, moduli as far apart as 1e9, and skins thick and thin."""
    for poisson in (0.0, 0.3, 0.49, 0.4999, 0.5):
        both = {"skin": Tissue(136, poisson, 1.0), "subcutaneous": Tissue(80, poisson)}
        three = ("hertz", "layered", "linear")
        yield from _each(three, "poisson", f"{poisson:g}", ANSWERED, **both)
        few: tuple[str, ...] = (
            () if poisson in (0.3, 0.49) else ("condensed",)
        )  # each builds an operator
        yield from _each(few, "poisson", f"{poisson:g}", ANSWERED, **both)
    for contrast in (1e-9, 1e-3, 1e3, 1e9):
        both = {"skin": Tissue(80 * contrast, 0.48, 1.0), "subcutaneous": Tissue(80, 0.48)}
        who = ALL[1:] if contrast in (1e-9, 1e9) else ALL[1:4]
        yield from _each(who, "contrast", f"skin {contrast:g} times the pulp", None, **both)
    for modulus in (1e-6, 1e9):
        both = {"skin": Tissue(1.7 * modulus, 0.48, 1.0), "subcutaneous": Tissue(modulus, 0.48)}
        yield from _each(ALL[1:], "modulus", f"{modulus:g} kPa", ANSWERED, **both)
    for thickness in (1e-3, 0.3, 3.0, 4.69, 4.99):
        layers = {"skin": Tissue(136, 0.48, thickness)}
        yield from _each(("hertz", "layered"), "skin", f"{thickness:g} mm thick", None, **layers)
    for size in (1.0, 1e3):
        whole = _sized(size)
        for strain in (True, False):
            name = f"a finger {size:g} mm thick{', strain' if strain else ''}"
            settings = whole | {"ask": {"strain": strain}}
            wants = ANSWERED if not strain else None
            yield from _each(("hertz", "layered"), "size", name, wants, **settings)
        yield from _each(MESHED, "size", f"a finger {size:g} mm thick", REFUSED, **whole)


def _sized(size: float) -> dict[str, Any]:
    """Return a finger `size` mm thick, and a press to 6 % of that."""
    return {
        "width": 1.6 * size,
        "thickness": size,
        "pad_radius": 1.4 * size,
        "skin": Tissue(136, 0.48, 0.1 * size),
        "motion": ramp(6 * size, 0.06 * size),
    }


def _series() -> Iterator[Trial]:
    """Relaxation of one to ten terms, fast and slow, to nearly nothing and nearly not at all."""
    for name, prony in SERIES.items():
        settings = {"prony": prony, "motion": RampHold(60, 0.6, hold=5.0)}
        yield from _each(ALL[1:], "relaxation", name, ANSWERED, **settings)
    for name, prony in SERIES.items():
        settings = {"prony": prony, "motion": RampHold(loading_rate=20, force=0.5, hold=5.0)}
        wants = ANSWERED if prony.c[0] > 1e-3 else None  # the other creeps a million times deeper
        yield from _each(("hertz", "linear"), "creep", name, wants, **settings)


def _motions() -> Iterator[Trial]:
    """Sinusoids that lose contact, many cycles, and unloading at all speeds."""
    lost = RampSinusoid(20, 0.4, amplitude=1.0, frequency=4, cycles=3)
    yield from _each(ALL, "lost contact", "a sinusoid of 1 mm about 0.4 mm", motion=lost)
    graze = RampSinusoid(20, 0.4, amplitude=0.4, frequency=4, cycles=3)
    yield from _each(ALL, "lost contact", "a sinusoid that just leaves", motion=graze)
    for speed in (1.0, 1e3):
        motion = Trapezoid(speed, 0.6, hold=0.1, corner=min(0.01, 0.3 / speed))
        yield from _each(ALL, "lost contact", f"in and out at {speed:g} mm/s", motion=motion)
    swing = RampSinusoid(loading_rate=5, force=0.5, amplitude=0.4999, frequency=4, cycles=3)
    yield from _each(ALL, "lost contact", "a force that nearly leaves", motion=swing)
    for frequency in (1e-4, 1e4):
        wave = Sinusoid(amplitude=0.3, frequency=frequency, cycles=1)
        yield from _each(ALL, "frequency", f"{frequency:g} Hz", motion=wave)
    many = Sinusoid(amplitude=0.3, frequency=200, cycles=1000)
    yield from _each(SIMPLE, "cycles", "1e3 cycles at 200 Hz", motion=many)
    most = Sinusoid(amplitude=0.3, frequency=200, cycles=100_000)
    yield from _each(("hertz", "layered", *MESHED), "cycles", "1e5 cycles", REFUSED, motion=most)


def _solid() -> Iterator[Trial]:
    """Return the edges of finite strain, few because each takes seconds."""
    answers: dict[str, dict[str, Any]] = {
        "0.1 mm": {"motion": ramp(60, 0.1)},
        "at 1e4 mm/s": {"motion": ramp(1e4, 0.3)},
        "poisson 0": {"skin": Tissue(136, 0, 1.0), "subcutaneous": Tissue(80, 0)},
        "poisson 0.5": {"skin": Tissue(136, 0.5, 1.0), "subcutaneous": Tissue(80, 0.5)},
        "1e-6 kPa": {"skin": Tissue(1.7e-6, 0.48, 1.0), "subcutaneous": Tissue(1e-6, 0.48)},
        "G(inf) = 1e-6": {"prony": SERIES["G(inf) = 1e-6"]},
        "in and out": {"motion": Trapezoid(20, 0.4, hold=0.0)},
    }
    for name, settings in answers.items():
        yield from _each(
            ("solid",), "finite strain", name, **({"motion": ramp(60, 0.3)} | settings)
        )
    either: dict[str, dict[str, Any]] = {
        "1e-6 mm": {"motion": ramp(60, 1e-6)},
        "60% of the tissue": {"motion": ramp(60, 0.6 * PULP)},
        "ball of 0.1 mm": {"indenter": Sphere(0.1)},
        "skin 1e9 times the pulp": {"skin": Tissue(8e10, 0.48, 1.0)},
        "skin 1e-9 of the pulp": {"skin": Tissue(8e-8, 0.48, 1.0)},
        "a law that stiffens by exp(1e3 (I1 - 3))": {
            "skin": Tissue(136, 0.48, 1.0, law="demiray", exponent=1e3)
        },
    }
    for name, settings in either.items():
        motion = {"motion": ramp(60, 0.3)}
        yield from _each(("solid",), "finite strain", name, None, **(motion | settings))


def _twins() -> Iterator[Trial]:
    """Pairs of scenes that must have the same answer: mirrored, in other units, at another pace."""
    for name in ("hertz", "layered", "linear", "condensed"):
        yield Trial(name, "twins", "moduli 1e9 times larger", partial(_stiffer, name), ANSWERED)
    for name in ("hertz", "layered"):
        yield Trial(name, "twins", "lengths 1e3 times larger", partial(_larger, name), ANSWERED)
        yield Trial(name, "twins", "everything 1e6 times faster", partial(_faster, name), ANSWERED)
    for name in MESHED:
        yield Trial(name, "twins", "tilted to the other side", partial(_mirrored, name), ANSWERED)
    pairs: dict[str, dict[str, Any]] = {
        "skin 1e3 times the pulp": {"skin": Tissue(8e4, 0.48, 1.0)},
        "a sinusoid that loses contact": {
            "motion": RampSinusoid(20, 0.4, amplitude=1.0, frequency=4, cycles=3)
        },
        "a ball of 6 mm off the middle": {"indenter": Sphere(6, (2.0, 1.0))},
    }
    for edge, settings in pairs.items():
        ask = partial(_condensed, settings)
        yield Trial("condensed", "twins", f"linear, {edge}", ask, ANSWERED)


def _forces(name: str, one: dict[str, Any], two: dict[str, Any], scale: float) -> Findings:
    """Return the invariants of two scenes, and that the force of the second is `scale` times."""
    first, second = answered(name, one), answered(name, two)
    expected = first[1].force * scale
    same = off(np.interp(_part(second[1]), _part(first[1]), expected), second[1].force, 1e-6)
    return invariants(*first) | invariants(*second) | {"same force": same}


def _part(response: Response) -> Any:
    return response.time / response.time[-1]


def _stiffer(name: str) -> Findings:
    soft = {"skin": Tissue(136, 0.48, 1.0), "subcutaneous": Tissue(80, 0.48)}
    hard = {"skin": Tissue(136e9, 0.48, 1.0), "subcutaneous": Tissue(80e9, 0.48)}
    return _forces(name, soft, hard, 1e9)


def _larger(name: str) -> Findings:
    force = {"ask": {"strain": False}}
    return _forces(name, _sized(10.0) | force, _sized(1e4) | force, 1e6)


def _faster(name: str) -> Findings:
    slow = {"prony": Prony((0.3, 0.7), (1e-3,)), "motion": RampHold(1e-2, 0.6, hold=60, corner=1.0)}
    fast = {
        "prony": Prony((0.3, 0.7), (1e3,)),
        "motion": RampHold(1e4, 0.6, hold=60e-6, corner=1e-6),
    }
    first, second = answered(name, slow), answered(name, fast)
    at = np.linspace(0, 1, 50)
    forces = [np.interp(at, _part(each), each.force) for _, each in (first, second)]
    same = off(forces[1], forces[0], 5e-3)
    return invariants(*first) | invariants(*second) | {"same force": same}


def _mirrored(name: str) -> Findings:
    left, right = ({"indenter": Flat(30, tilt)} for tilt in (12.0, -12.0))
    return _forces(name, left, right, 1.0)


def _condensed(settings: dict[str, Any]) -> Findings:
    made, response = answered("condensed", settings)
    _, exact = answered("linear", settings)
    findings = dict(invariants(made, response))
    return findings | {"as linear": off(response.force, exact.force, 1e-6)}

"""Suite `human`: the default finger against measurements on people, nothing tuned to pass.

What needs friction or inertia is not here.
"""

from collections.abc import Iterator
from functools import cache, partial
from typing import Any, Literal

import numpy as np
from fefinger.validation.case import Case, Expected, Noted
from fefinger.validation.human import drawings
from fefinger.validation.human.preload import skin_speeds
from fefinger.validation.human.presses import DEFAULT, PROFILES, REPORT, SUBJECTS, finger, ramp

from fefinger.mechanics.evidence.presses import read
from fefinger.results.records import Response
from fefinger.scene import library
from fefinger.scene.cautions import DENSITY
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring, contact_force


SERINA = "Serina, Mote & Rempel (1997), J Biomech 30:1035, as cited"
CHAPTER = "a book chapter of 2013, as cited: 0.60, where Hertz has 0.215"
MANFREDI = "Manfredi et al. (2012), J Neurophysiol 108:243: a plateau of about 7 m/s"
STIFFNESS = f"Table 2.1 and Figure 2-2 ({library.SOURCE}), ramp at 60 mm/s"
RELAXATION = f"Table 2.1 ({library.SOURCE}), ramp at 60 mm/s and 5 s of hold"
FIGURES = f"Figures 3-3 and 3-4 ({library.SOURCE}), held forces, the means"

DEPTH = {"d.p.": 1.5, "d.s.": 2.0, "a.h.": 1.8, "p.w.": 2.1}
"""Depths in mm at which the ramps of the subjects end, at some 2.5 to 3 N."""

FORCES = (0.1, 0.5, 1.0, 1.5)
"""Forces in N at which stiffness is compared."""

FIRST = 0.05
"""Force in N of first touch, as Table 2.1 is fitted from there."""

WORDS = {"depth": "depth", "radius": "contact radius", "highest": "highest pressure"}

TENTH, FIFTH = 0.1, 0.2
"""Relative differences that pass: of stiffness and ratios, and of pressures, areas and depths."""


@cache
def pressed(subject: str) -> Response:
    """Press the finger of a subject at 60 mm/s and hold it."""
    return ramp(subject, DEPTH[subject])


def law(subject: str) -> tuple[Array, Array]:
    """Return depth (n,) mm and force (n,) N of Table 2.1 in the same motion."""
    row, response = library.lumped()[subject], pressed(subject)
    force = contact_force(Spring(row.b, row.m), row.prony, response.time, response.depth)
    return response.depth, np.asarray(force)


def loading(values: Array) -> slice:
    """Return the steps to the largest value."""
    return slice(0, int(np.argmax(values)) + 1)


def stiffness(depth: Array, force: Array, at: float) -> float:
    """Return dP/dx in N/mm where a loading reaches a force in N: over a tenth on either side."""
    up = loading(force)
    low, high = np.interp([0.9 * at, 1.1 * at], force[up], depth[up])
    return float(0.2 * at / (high - low))


def stiffness_ratio(subject: str, at: float) -> Noted:
    """Return the stiffness of the finger over the subject's at a force."""
    ours = stiffness(pressed(subject).depth, pressed(subject).force, at)
    theirs = stiffness(*law(subject), at)
    return Noted(ours / theirs, f"{ours:.3g} N/mm; the subject {theirs:.3g} N/mm")


def force_ratio(subject: str) -> Noted:
    """Return the largest force of the finger over the subject's at the same depth."""
    ours, theirs = float(pressed(subject).force.max()), float(law(subject)[1].max())
    return Noted(ours / theirs, f"{ours:.3g} N; the subject {theirs:.3g} N")


def held_share(subject: str) -> Noted:
    """Return the force after 5 s of hold over its peak, minus the ratio of Table 2.1."""
    ours, theirs = pressed(subject).force, law(subject)[1]
    shares = float(ours[-1] / ours.max()), float(theirs[-1] / theirs.max())
    return Noted(shares[0] - shares[1], f"{shares[0]:.3f}; the subject {shares[1]:.3f}")


def fast_share(subject: str) -> Noted:
    """Return the share of the force lost 20 ms after its peak, minus the share of Table 2.1."""
    response, shares = pressed(subject), []
    for force in (response.force, law(subject)[1]):
        top = int(np.argmax(force))
        after = float(np.interp(response.time[top] + 0.02, response.time, force))
        shares.append(1 - after / float(force[top]))
    return Noted(shares[0] - shares[1], f"{shares[0]:.3f}; the subject {shares[1]:.3f}")


def ratio(name: str, key: str, low: float, high: float) -> Noted:
    """Return a quantity of the deep press of a finger at one force over that at another."""
    row = read(REPORT)["deep"][name]
    force, values = np.array(row["force_N"]), np.array(row[key])
    if force[-1] < high:
        text = f"the press ends at {force[-1]:.3g} N of {high:g} N: {row['halt']}"
        return Noted(float(np.interp(low, force, values) / values[-1]), text)
    small, large = np.interp([low, high], force, values)
    return Noted(float(small / large), f"{small:.3g} over {large:.3g}")


RAYLEIGH = 0.9553
"""Speed of Rayleigh waves over that of shear waves, incompressible."""

PRELOADS = (0.5, 1.0)
"""Relaxed forces in N under which waves in the skin are compared."""


def preloaded_speed(name: str, force: float) -> Noted:
    """Return the speed in m/s of surface waves in skin under a force in N, instantaneous moduli."""
    loaded, rest = skin_speeds(name, force)
    text = f"{loaded / rest:.3g} times that at rest"
    return Noted(RAYLEIGH * loaded, text)


def wave_speed(name: str, layer: str, *, instantaneous: bool) -> float:
    """Return the speed in m/s of Rayleigh waves in the bulk of a layer, incompressible."""
    published = Finger.subject(DEFAULT, tissue=library.PUBLISHED)
    tissue = published if name == library.PUBLISHED else finger(name)
    modulus = getattr(tissue, layer).modulus
    shear = modulus / 3 / (tissue.prony.long_time if instantaneous else 1.0)
    return float(RAYLEIGH * np.sqrt(shear / DENSITY) / 1e3)


def of_profile(force: str, key: str) -> float:
    """Return a quantity of the held press of the means."""
    row = read(REPORT)["held"][force]
    if key == "radius_mm":
        return float(np.sqrt(row["area_mm2"] / np.pi))
    return float(row[key])


def asymmetry(force: str) -> Noted:
    """Return the proximal reach of the contact over its distal reach."""
    row = read(REPORT)["held"][force]
    text = f"{row['proximal_mm']:g} mm proximal, {row['distal_mm']:g} mm distal of first touch"
    return Noted(row["proximal_mm"] / row["distal_mm"], text)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the cases; quick ones leave three subjects out."""
    subjects = (DEFAULT,) if quick else SUBJECTS
    for subject in subjects:
        yield from _stiffness(subject)
        yield from _relaxation(subject)
    yield from _pulp()
    yield from _waves()
    if not quick:
        yield from _preloaded()
    yield from _pressures()


def _close(value: float, part: float) -> Expected:
    return Expected(value, part * value)


def _stiffness(subject: str) -> Iterator[Case]:
    for at in (FIRST, *FORCES):
        name = f"stiffness at {at:g} N over that of the subject, {subject}"
        measure, expected = partial(stiffness_ratio, subject, at), _close(1.0, TENTH)
        yield _case(name, measure, expected, STIFFNESS)
    name = f"force at {DEPTH[subject]:g} mm over that of the subject, {subject}"
    yield _case(name, partial(force_ratio, subject), _close(1.0, TENTH), STIFFNESS)


def _relaxation(subject: str) -> Iterator[Case]:
    for name, measure in (("held for 5 s", held_share), ("lost within 20 ms", fast_share)):
        yield _case(
            f"share of the peak force {name}, beside that of the subject, {subject}",
            partial(measure, subject),
            Expected(0.0, 0.02),
            RELAXATION,
        )


def _pulp() -> Iterator[Case]:
    for name in (DEFAULT, "means"):
        yield _case(
            f"displacement at 1 N over that at 5.2 N, flat plate, {name}",
            partial(ratio, name, "depth_mm", 1.0, 5.2),
            _close(0.82, TENTH),
            SERINA,
        )
        yield _case(
            f"contact area at 1 N over that at 10 N, flat plate, {name}",
            partial(ratio, name, "area_mm2", 1.0, 10.0),
            _close(0.60, TENTH),
            CHAPTER,
        )


def _waves() -> Iterator[Case]:
    for name in (DEFAULT, "means", library.PUBLISHED):
        for instantaneous in (False, True):
            modulus = "instantaneous" if instantaneous else "relaxed"
            for layer in ("skin", "subcutaneous"):
                yield _case(
                    f"surface wave speed by the {modulus} modulus of {layer} tissue, {name}",
                    partial(wave_speed, name, layer, instantaneous=instantaneous),
                    Expected(7.0, 1.4, "m/s"),
                    MANFREDI,
                )


def _preloaded() -> Iterator[Case]:
    for name in (DEFAULT, "means"):
        for force in PRELOADS:
            yield _case(
                f"surface wave speed in skin under {force:g} N, instantaneous, {name}",
                partial(preloaded_speed, name, force),
                Expected(7.0, 1.4, "m/s"),
                MANFREDI,
            )


def _pressures() -> Iterator[Case]:
    for force, values in PROFILES.items():
        for key, value in zip(("depth_mm", "radius_mm", "highest_kPa"), values, strict=True):
            what, unit = key.split("_")
            yield _case(
                f"{WORDS[what]} of a held {force} N, means",
                partial(of_profile, force, key),
                Expected(value, FIFTH * value, unit),
                FIGURES,
            )
    yield _case(
        "proximal over distal extent of contact at 1.1 N, means",
        partial(asymmetry, "1.1"),
        Expected.between(1.0, 3.0),
        f"isobars reach further to the proximal side ({library.SOURCE}, Figure 3-3)",
    )


def _case(name: str, measure: Any, expected: Expected, source: str) -> Case:
    """Return a case, with the known value and the reason where the finger misses it."""
    if name not in MISSES:
        return Case(name, measure, expected, source)
    value, reason = MISSES[name]
    known = Expected(value, 0.03 * abs(value) + 0.003, expected.unit)
    return Case(name, measure, known, source, wanted=expected.value, shortfall=REASONS[reason])


def figures() -> Iterator[tuple[str, Any]]:
    """Yield the curves over the published points."""
    yield from drawings.figures({name: (pressed(name), law(name)) for name in SUBJECTS})


Reason = Literal["first touch", "pulp", "area", "waves", "preload", "pressure"]

REASONS: dict[Reason, str] = {
    "first touch": (
        "the calibration fits stiffness against force, up to 2.5 N; the scatter that the source "
        "leaves, some 0.03 to 0.5 N/mm at every force, is of the size of the stiffness at 0.05 N, "
        "which so had little weight, and the depth at which a force is reached was not fitted"
    ),
    "pulp": (
        "the law measured on a.h. itself (Table 2.1 of the source) gives 0.65 at this speed: the "
        "two published sources disagree, and the finger was fitted to that one"
    ),
    "area": (
        "the published ratio is from a second source, without the angle of its plate; under ours, "
        "at 30 degrees, contact ends at the fingertip and cannot grow distally"
    ),
    "waves": (
        "waves along a finger run in skin and pulp together. The force at light touch fixes the "
        "modulus of the pulp, where they are too slow; the relaxed moduli are those of slow "
        "presses, and published moduli, taken as relaxed, make skin too fast"
    ),
    "preload": (
        "stiffening under the preload raises the speed in skin by 1.13 at 0.5 N and 1.23 at 1 N; "
        "unloaded it is 7.5 m/s"
    ),
    "pressure": (
        "the source's is the peak of a paraboloid that was fitted to the blurred frames of an "
        "array with elements of 2 mm, ours the mean over 1 mm²"
    ),
}

MISSES: dict[str, tuple[float, Reason]] = {
    "force at 2 mm over that of the subject, d.s.": (0.896, "first touch"),
    "force at 2.1 mm over that of the subject, p.w.": (0.741, "first touch"),
    "stiffness at 0.05 N over that of the subject, d.s.": (0.882, "first touch"),
    "stiffness at 0.05 N over that of the subject, p.w.": (0.774, "first touch"),
    "displacement at 1 N over that at 5.2 N, flat plate, a.h.": (0.659, "pulp"),
    "displacement at 1 N over that at 5.2 N, flat plate, means": (0.672, "pulp"),
    "contact area at 1 N over that at 10 N, flat plate, a.h.": (0.669, "area"),
    "contact area at 1 N over that at 10 N, flat plate, means": (0.713, "area"),
    **{
        f"surface wave speed by the {modulus} modulus of {layer} tissue, {name}": (speed, "waves")
        for (name, modulus, layer), speed in {
            ("a.h.", "relaxed", "skin"): 3.81,
            ("a.h.", "relaxed", "subcutaneous"): 1.2,
            ("a.h.", "instantaneous", "subcutaneous"): 2.38,
            ("means", "relaxed", "skin"): 3.73,
            ("means", "relaxed", "subcutaneous"): 1.18,
            ("means", "instantaneous", "subcutaneous"): 2.29,
            ("maeno1998", "relaxed", "skin"): 5.58,
            ("maeno1998", "relaxed", "subcutaneous"): 3.22,
            ("maeno1998", "instantaneous", "skin"): 10.31,
        }.items()
    },
    "surface wave speed in skin under 0.5 N, instantaneous, a.h.": (8.488, "preload"),
    "surface wave speed in skin under 1 N, instantaneous, a.h.": (9.235, "preload"),
    "surface wave speed in skin under 1 N, instantaneous, means": (8.93, "preload"),
    "highest pressure of a held 1.1 N, means": (26.9, "pressure"),
    "highest pressure of a held 2.3 N, means": (59.96, "pressure"),
}

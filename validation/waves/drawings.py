"""Figures and words of suite `waves`."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.panels import panels
from fefinger.validation.waves import finger, lateral, loops
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers
from fefinger.view.figures import INK, STEEL, figure


FORCES = 0.2, 0.5, 1.0
"""Preloads in N."""

SHADES = "#9fb6c9", STEEL, INK

MARKS = 20.0, 50.0, 100.0, 200.0, 400.0
"""Hz."""

HELD = 1e-9
"""Displacement of the skin over that of the plate up to which it counts as held."""

SHAPES = 4
"""Modes that are drawn."""

TEXTS = (
    "Contact of the harmonic answers is that of the relaxed finger at the preload, and stays. "
    "Modes are those of tissue with its long-time modulus; at 200 Hz the modulus of the published "
    "relaxation is 3.3 times, and the frequencies 1.8 times as high.",
    "Does inertia explain the phase of the impedance above 30 Hz, in which the source thesis "
    "differs from measurements (its Figs 2-8 and 2-9)? Up to 200 Hz it does not: with the "
    "published relaxation the phase falls by 14 degrees from 30 to 200 Hz without mass, and by 13 "
    "with it. A relaxation that goes on to a kHz makes it rise from 30 Hz on; mass makes it rise "
    "above 250 Hz.",
    "Along the skin, a finger with the faster branch has the impedance that was measured on "
    "people, in magnitude and phase, from 50 to 400 Hz; with the published relaxation it hardly "
    "damps. Along the normal the measured magnitude falls as that of a spring to 200 Hz, which the "
    "published relaxation does and the faster branch does not: its confidence is low.",
    "Below some 300 Hz a pad over bone carries no wave along the skin: what lies beyond the "
    "contact moves nearly in phase, and decays by 3 to 9 dB/mm.",
)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure."""
    yield (
        "Dynamic stiffness and phase of the impedance (force over velocity) under the plate at 30 "
        f"degrees, at preloads of {', '.join(f'{f:g}' for f in FORCES)} N (dark: large), with the "
        "published relaxation (solid) and with a faster branch of low confidence (dashed).",
        _impedance(),
    )
    yield (
        "Impedance of a finger that sticks to a plate that vibrates along the skin, at a preload "
        f"of {lateral.SHOWN:g} N: magnitude and phase with the published relaxation (solid), with "
        "the faster branch (dashed), and the published fit (gray, with masses of 110 to 230 mg).",
        _lateral(),
    )
    yield (
        "Displacement of the skin normal to the pad in the medial plane, per displacement of the "
        "plate, at a preload of 0.5 N: amplitude and phase over the distance proximal of first "
        "touch, with the published relaxation (solid) and with the faster branch (dashed).",
        _skin(),
    )
    yield (
        f"The {SHAPES} lowest modes of half the free finger: the medial section at rest (thin) and "
        "displaced, with the frequency of relaxed tissue.",
        _shapes(),
    )


def _impedance() -> Any:
    drawn, (left, right) = panels(8.0, 3.4, 1, 2)
    for tissue, line in ((loops.TISSUE, "-"), (finger.VISCOUS, "--")):
        for force, shade in zip(FORCES, SHADES, strict=True):
            harmonic = finger.answer(tissue, force)
            left.loglog(harmonic.frequency, np.abs(harmonic.stiffness), line, color=shade)
            phase = np.degrees(np.angle(harmonic.impedance))
            right.semilogx(harmonic.frequency, phase, line, color=shade)
    left.set(xlabel="frequency / Hz", ylabel="dynamic stiffness / (N/mm)")
    right.set(xlabel="frequency / Hz", ylabel="phase of the impedance / degrees")
    return drawn


def _lateral() -> Any:
    drawn, (left, right) = panels(8.0, 3.4, 1, 2)
    for tissue, line in ((loops.TISSUE, "-"), (finger.VISCOUS, "--")):
        impedance = lateral.impedance(tissue, lateral.SHOWN)
        left.loglog(lateral.BAND, np.abs(impedance), line, color=STEEL)
        right.semilogx(lateral.BAND, np.degrees(np.angle(impedance)), line, color=STEEL)
    ends = [lateral.measured(lateral.SHOWN, lateral.BAND, mass) for mass in lateral.MASSES]
    left.fill_between(lateral.BAND, *np.abs(ends), color=SHADES[0])
    right.fill_between(lateral.BAND, *np.degrees(np.angle(ends)), color=SHADES[0])
    for axis in (left, right):
        axis.minorticks_off()
        axis.set_xticks(MARKS, [f"{mark:g}" for mark in MARKS])
    left.set(xlabel="frequency / Hz", ylabel="impedance / (N s/m)")
    right.set(xlabel="frequency / Hz", ylabel="phase of the impedance / degrees")
    return drawn


def _skin() -> Any:
    drawn, (left, right) = panels(8.0, 3.4, 1, 2)
    for tissue, line in ((loops.TISSUE, "-"), (finger.VISCOUS, "--")):
        for frequency, shade in zip((50.0, 200.0, 350.0), SHADES, strict=True):
            harmonic = finger.finger(tissue).harmonic([frequency], force=0.5)
            # Not the skin at the proximal cut, which is held.
            free = np.abs(harmonic.skin[0, :, 2]) > HELD
            reach = free & (harmonic.skin_points[:, 0] < 0)
            moved = harmonic.skin[0, reach, 2]
            away = -harmonic.skin_points[reach, 0]
            left.semilogy(away, np.abs(moved), line, color=shade, label=f"{frequency:g} Hz")
            order = np.argsort(away)
            phase = np.degrees(np.unwrap(np.angle(moved[order])))
            right.plot(away[order], phase, line, color=shade)
    handles, labels = left.get_legend_handles_labels()
    left.legend(handles[:3], labels[:3])
    left.set(xlabel="distance / mm", ylabel="amplitude")
    right.set(xlabel="distance / mm", ylabel="phase / degrees")
    return drawn


def _shapes() -> Any:
    loop = finger.finger(loops.TISSUE)
    solid = loop.vibrating.solid
    points = solid.space.points
    edges = _outlines(points, solid.space.cells, solid.space.tissue)
    drawn = figure(8.0, 4.6)
    for number, axis in enumerate(drawn.subplots(2, SHAPES // 2).ravel()):
        one = np.array([number]), np.ones((1, 1))
        moved = loop.modes.combined(3 * len(points), *one).reshape(-1, 3)
        moved = moved * (1.2 / np.abs(moved).max())
        for place, color, width in ((points, "#b0b0b0", 0.6), (points + moved, STEEL, 1.2)):
            lines = place[edges]
            x = np.insert(lines[:, :, 0], 2, np.nan, axis=1).ravel()
            z = np.insert(lines[:, :, 2], 2, np.nan, axis=1).ravel()
            axis.plot(x, z, color=color, lw=width)
        axis.set_aspect("equal")
        axis.set_title(f"{loop.frequencies[number]:.0f} Hz")
        axis.axis("off")
    return drawn


def _outlines(points: Array, cells: Integers, region: NDArray[np.int8]) -> Integers:
    """Return the edges (n, 2) in the medial plane that bound the tissues."""
    inside = np.abs(points[:, 1]) < 1e-6
    faces = cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3)
    medial = inside[faces].all(axis=1)
    owners = np.repeat(region, 4)[medial]
    pairs = faces[medial][:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2)
    edges, place = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    labels, one = np.repeat(owners, 3).astype(np.float64), np.zeros(len(edges))
    one[place.ravel()] = labels
    count = np.bincount(place.ravel())
    uneven = np.bincount(place.ravel(), labels) / count != one
    return np.asarray(edges[(count == 1) | uneven])

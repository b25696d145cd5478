"""Scanned dots on exact layers, finer than any mesh of the finger: rates against their spacing.

The same units and dots as in `dots.py`, under a paraboloid on the layers of the skin
(`afferents/patterns.py`): elastic, on a grid of 0.06 mm. Dots on a grid move by their spacing until
all repeats, and dots moved to one side are the mirror image of those moved to the other: half a
spacing is solved. In between the strain is its Fourier series over the way.
"""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from fefinger.validation.afferents import patterns
from fefinger.validation.friction import dots
from scipy.signal import resample

from fefinger.mechanics.press.sites import of_population, place_units
from fefinger.neural.populations import Surface
from fefinger.results.records import Sites
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.units import NEWTON_PER_MILLINEWTON


POINTS, SPACING = 256, 0.06
"""Grid points on a side and their distance in mm: with 0.08 mm FAII fire 3 impulses/s more."""

STEP = 0.1  # mm of the way between solutions, a seventh of a dot

EVERY = 2e-4  # s between the samples that units are given

SKIN = 8.0  # mm, half the side of the skin on which units are laid out

START = 3.0  # mm, radius of the pressure that the first solution starts from


@cache
def fine() -> patterns.Pad:
    """Return the pad of the experiments on the grid of this module."""
    return replace(patterns.pad(), points=POINTS, spacing=SPACING)


def sites(scene: Scene) -> Sites:
    """End organs of the population of a scene under a flat skin, z into the body."""
    lines = np.arange(-SKIN, SKIN + 0.25, 0.5)
    flat = np.stack(np.meshgrid(lines, lines, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    normals = np.tile([0.0, 0.0, -1.0], (len(flat), 1))
    skin = Surface(flat, normals, np.full(len(flat), 0.25))
    return of_population(place_units(scene.ask, skin, np.array([0.0, 0.0, 1.0])))


def strains(scene: Scene, organs: Sites) -> Array:
    """Strain (n, n_organs, 3, 3) at the end organs over a spacing of the dots of a scene, evenly.

    The first is that with a dot in the middle of the pad.
    """
    indenter: Any = scene.indenter
    pad, profile, spacing = fine(), indenter.profile, indenter.spacing
    force = scene.motion.peak / NEWTON_PER_MILLINEWTON
    count = max(3, round(spacing / STEP))
    places, n = organs.points[:, :2], len(organs.points)
    both = np.vstack([places, places * [-1.0, 1.0]])
    mirror = np.array([-1.0, 1.0, 1.0])
    out = np.empty((count, n, 3, 3))
    pressure = np.maximum(0.0, 1.0 - np.hypot(*np.moveaxis(pad.places, -1, 0)) / START)

    def rise_at(shift: Array) -> patterns.Shape:
        return lambda at: profile.rise(at - shift)

    for k in range(count // 2 + 1):
        shift = np.array([spacing * k / count, 0.0])
        pressure = pad.pressure_by_force(rise_at(shift), force, pressure)
        for z in np.unique(organs.depths):
            deep = organs.depths == z
            strain = pad.strain(pressure, float(z), both[np.tile(deep, 2)])
            here, there = np.split(strain, 2)
            out[k, deep] = here
            out[-k, deep] = there * np.multiply.outer(mirror, mirror)
    return out


@cache
def scanned(
    spacing: float, diameter: float = dots.DIAMETER
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Rates in Hz, and mean and deviation of strain, over dots, by type.

    As `dots.scanned`.
    """
    scene = dots.scene(spacing, diameter)
    organs, speed = sites(scene), float(scene.to_dict()["motion"]["speed"])
    strain = strains(scene, organs)
    count = round(spacing / speed / EVERY)
    passes = round(dots.DISTANCE / spacing)
    one = resample(dots.inputs(strain, organs), count, axis=0)
    time = spacing / speed / count * np.arange(count * passes + 1, dtype=np.float64)
    inputs = np.concatenate([np.tile(one, (passes, 1)), one[:1]])
    rates = dots.fired(organs, time, inputs, spacing / speed)
    return rates, dots.variations(strain, organs)

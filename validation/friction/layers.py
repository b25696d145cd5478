"""Scanned dots on exact layers, finer than any mesh of the finger: rates against their spacing.

The same units and dots as in `dots.py`, on the grid of the mechanics `layered`, with and without
ridges of the skin. Elastic, and of one period: dots on a grid move by their spacing until all
repeats, and dots moved to one side are the mirror image of those moved to the other: half a spacing
is solved. In between the strain is its Fourier series over the way.
"""

from functools import cache
from typing import Any

import numpy as np
from fefinger.validation.afferents import patterns
from fefinger.validation.friction import dots
from scipy.signal import resample

from fefinger.contact.stepper import Target
from fefinger.mechanics.press.layer_grid import StrainProbe
from fefinger.mechanics.press.unit_placement import of_population, place_units
from fefinger.neural.populations import Surface
from fefinger.results.records import Sites
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Ridges
from fefinger.support.arrays import Array
from fefinger.support.units import NEWTON_PER_MILLINEWTON


POINTS, SPACING = 256, 0.06
"""Grid points on a side and their distance in mm."""

STEP = 0.1  # mm of the way between solutions, a seventh of a dot

FINE_STEP = 0.05  # mm of the same on ridges, a ninth of one

EVERY = 2e-4  # s between the samples that units are given

SKIN = 8.0  # mm, half the side of the skin on which units are laid out


@cache
def fine() -> patterns.Pad:
    """Return the pad of the experiments on the grid of this module."""
    pad = patterns.pad()
    return patterns.Pad(pad.layers, pad.radius, POINTS, SPACING)


def sites(scene: Scene) -> Sites:
    """End organs of the population of a scene under a flat skin, z into the body."""
    lines = np.arange(-SKIN, SKIN + 0.25, 0.5)
    flat = np.stack(np.meshgrid(lines, lines, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    normals = np.tile([0.0, 0.0, -1.0], (len(flat), 1))
    skin = Surface(flat, normals, np.full(len(flat), 0.25))
    return of_population(place_units(scene.ask, skin, np.array([0.0, 0.0, 1.0])))


def strains(
    scene: Scene,
    organs: Sites,
    ridges: Ridges | None = None,
    start: float = 0.0,
    friction: float = 0.0,
) -> Array:
    """Strain (n, n_organs, 3, 3) at the end organs over a spacing of the dots of a scene, evenly.

    The first is that with a dot in the middle of the pad, where straight ridges have a crest. With
    a `start` mm from there nothing is mirrored, nor with friction, under which a spacing is passed
    before the one that counts.
    """
    indenter: Any = scene.indenter
    pad, profile, spacing = fine(), indenter.profile, indenter.spacing
    force = scene.motion.peak / NEWTON_PER_MILLINEWTON
    count = max(3, round(spacing / (STEP if ridges is None else FINE_STEP)))
    grid = pad.grid
    skin = pad.gap(lambda at: 0.0 * at[..., 0] if ridges is None else ridges.valleys(at))
    contact = pad.contact(
        lambda shift: skin + profile.rise(grid.places - np.array(shift)), friction
    )
    places, n = organs.points[:, :2], len(organs.points)
    mirrored = not start and not friction
    both = np.vstack([places, places * [-1.0, 1.0]])
    probe = StrainProbe(grid, both, np.tile(organs.depths, 2), friction=friction > 0.0)
    mirror = np.array([-1.0, 1.0, 1.0])
    out = np.empty((count, n, 3, 3))
    for k in range(-count if friction else 0, count // 2 + 1 if mirrored else count):
        target = Target(force, by_force=True, shift=(start + spacing * k / count, 0.0))
        patterns.solved(contact, target)
        if k < 0:
            continue
        out[k], there = np.split(probe.strain(contact.elastic), 2)
        if mirrored:
            out[-k] = there * np.multiply.outer(mirror, mirror)
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
    return fired(organs, strain, spacing, speed), dots.variations(strain, organs)


def fired(
    organs: Sites, strain: Array, spacing: float, speed: float, seed: int = dots.SEED
) -> dict[str, float]:
    """Rates in Hz by type at a speed in mm/s, of strain over a spacing of dots."""
    count = round(spacing / speed / EVERY)
    passes = round(dots.DISTANCE / spacing)
    one = resample(dots.inputs(strain, organs), count, axis=0)
    time = spacing / speed / count * np.arange(count * passes + 1, dtype=np.float64)
    inputs = np.concatenate([np.tile(one, (passes, 1)), one[:1]])
    return dots.fired(organs, time, inputs, spacing / speed, seed)

"""Records of a pad that many worlds share, of their state and of what a step gives.

The compliance of the pad is in none of them: numba compiles what takes a record once for every type
of its arrays, and the compliance alone may be in single precision.
"""

from typing import NamedTuple

import numpy as np

from fefinger.contact.signed_distance import Shapes
from fefinger.support.arrays import Array, Flags, Integers


VALID, DEEP, BORDER, PASSED, UNSOLVED = 0, 1, 2, 3, 4
"""Verdicts on a step: penetration beyond `deepest`; contact at the border of the pad; an object
that moved through the skin within the step; no contact found, so that the state is as before."""

AREA, STICK, DEPTH = 6, 7, 8
"""Columns of the readings of an object, behind the six of force and moment: area, area that sticks,
depth."""


class Pad(NamedTuple):
    """Skin of a pad, shared by all worlds.

    points and normals (n, 3) of the vertices, outward; owner (k, 3): vertex at each corner of
    a triangle, or -1; places and skin (k, q, 3): quadrature points and outward normals there; hats
    (k, 3, q) mm²: weights times the hats of the corners; areas (n,) mm²; border (n,): where contact
    could spread beyond the pad; weights and rates (m,) of the Prony terms over the long-time one.
    """

    points: Array
    normals: Array
    owner: Integers
    places: Array
    skin: Array
    hats: Array
    areas: Array
    border: Flags
    weights: Array
    rates: Array


class Factors(NamedTuple):
    """Pawluk's modulus by angles (k,) in degrees and penetrations (i,) in mm of plates.

    values (k, i, 3): the logarithm of t, and of the patch in mm², and the fullness of the
    penetration, see `pad_gaps.penetration`. The angle is that of a plate, about y: 0 below the pad,
    positive toward the tip.
    """

    angles: Array
    depths: Array
    values: Array


class Moves(NamedTuple):
    """One step of all worlds: the objects' poses at its end, and how it is judged.

    rotation (w, b, 3, 3) and place (w, b, 3) mm of the objects `shapes` in the frame of the finger;
    dt s; deepest mm: penetration beyond which a step is not valid; factors: t of plates.
    """

    shapes: Shapes
    rotation: Array
    place: Array
    dt: float
    deepest: float
    factors: Factors


class Softness(NamedTuple):
    """Flexibility of the objects themselves.

    matrix (k, n, n) mm³/kPa of k elastic bodies, for the pressures at all vertices of the pad; body
    (b,): which of them an object is, -1 if it is rigid. Without a matrix all are rigid.
    """

    matrix: Array
    body: Integers


RIGID = Softness(np.empty((0, 0, 0)), np.empty(0, dtype=np.int64))
"""Of objects that are all rigid."""


class Worlds(NamedTuple):
    """State of all worlds.

    terms (w, m, 3n) kPa: internal variables of the Prony series; elastic (w, 3n) kPa: y; linear (w,
    3n) kPa: q, of which displacement and strain are linear; x (w, c n): pressures, with friction
    then both tractions in the frames of the vertices; active (w, n): in contact; rotation (w, b, 3,
    3) and place (w, b, 3) mm: last poses; stepped (w,): whether there are any.
    """

    terms: Array
    elastic: Array
    linear: Array
    x: Array
    active: Flags
    rotation: Array
    place: Array
    stepped: Flags


class Readings(NamedTuple):
    """What a step gives.

    traction (w, n, 3) kPa on the skin; pressure (w, n) kPa; slip (w, n, 3) mm of the skin over the
    object in the step; touched (w, n): number of the object, or -1; bodies (w, b, 9): see AREA,
    in N, N mm about the origin, mm² and mm; hit (w, n, 3) mm³: first moments of the places of
    contact; frame (w, 3, n, 3): direction of the pressure and both of the traction; stiffness (w,):
    g t of the step; verdict (w,).
    """

    traction: Array
    pressure: Array
    slip: Array
    touched: Integers
    bodies: Array
    hit: Array
    frame: Array
    stiffness: Array
    verdict: Integers


class Work(NamedTuple):
    """What a thread needs for a step of one world.

    gap, ahead (n,): weighted gaps mm³, gaps at the vertices mm; near (n,) and listed (n,): flags
    and numbers of the near vertices, as many as found[0]; past (3n,) h, moved and held (3n,): A h
    and A q; offset (c n,): right side of the contact problem.
    """

    gap: Array
    ahead: Array
    near: Flags
    listed: Integers
    found: Integers
    past: Array
    moved: Array
    held: Array
    offset: Array


def worlds(count: int, pad: Pad, bodies: int, components: int) -> Worlds:
    """Allocate the state of some worlds at rest; components: 1, or 3 with friction."""
    n, terms = len(pad.areas), len(pad.rates)
    return Worlds(
        terms=np.zeros((count, terms, 3 * n)),
        elastic=np.zeros((count, 3 * n)),
        linear=np.zeros((count, 3 * n)),
        x=np.zeros((count, components * n)),
        active=np.zeros((count, n), dtype=np.bool_),
        rotation=np.zeros((count, bodies, 3, 3)),
        place=np.zeros((count, bodies, 3)),
        stepped=np.zeros(count, dtype=np.bool_),
    )


def readings(count: int, pad: Pad, bodies: int) -> Readings:
    """Allocate the readings of some worlds."""
    n = len(pad.areas)
    return Readings(
        traction=np.zeros((count, n, 3)),
        pressure=np.zeros((count, n)),
        slip=np.zeros((count, n, 3)),
        touched=np.full((count, n), -1, dtype=np.int64),
        bodies=np.zeros((count, bodies, 9)),
        hit=np.zeros((count, n, 3)),
        frame=np.zeros((count, 3, n, 3)),
        stiffness=np.ones(count),
        verdict=np.zeros(count, dtype=np.int64),
    )


def work(pad: Pad, components: int) -> Work:
    """Allocate the work arrays of a thread."""
    n = len(pad.areas)
    return Work(
        gap=np.zeros(n),
        ahead=np.zeros(n),
        near=np.zeros(n, dtype=np.bool_),
        listed=np.zeros(n, dtype=np.int64),
        found=np.zeros(1, dtype=np.int64),
        past=np.zeros(3 * n),
        moved=np.zeros(3 * n),
        held=np.zeros(3 * n),
        offset=np.zeros(components * n),
    )

"""Positions of the end organs, of a population or central ones, and the skin above them.

Shared by all mechanics; needs no mesh. Their strain is read by `fem/elements/probe.py`.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from fefinger.geometry.finger_mesh import Halves, triangle_areas
from fefinger.geometry.profiles import directions
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask, innervation
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from fefinger.neural.populations import Surface


REFERENCE_DEPTH = 0.5
"""Depth in mm of the small flat press that sets the length of a strain."""


def central_sites(ask: Ask, pulp: float, origin: Array, axis: Array) -> Sites:
    """Place one site per type of `ask` (all four where it names none) under the first touch.

    They lie at the depths of their types along the inward normal `axis` (3,) from `origin` (3,), in
    a tissue `pulp` mm thick.

    InputError for end organs that would lie in the bone.
    """
    depth_of = {kind: organ.depth for kind, organ in innervation().items()} | dict(ask.depths)
    types = ask.spikes or tuple(depth_of)
    depth = np.array([depth_of[kind] for kind in types])
    deepest = float(depth.max(initial=0.0))
    if deepest >= pulp:
        raise InputError(
            f"ask.depths: expected end organs above the bone, less than {pulp:g} mm deep, received "
            f"one at {deepest:g} mm; give depths that this finger has, or ask for the types of "
            "lesser depth alone"
        )
    points = origin + depth[:, None] * axis
    return Sites(points, np.tile(-axis, (len(depth), 1)), depth, tuple(types))


def end_organ_sites(
    ask: Ask, pulp: float, origin: Array, axis: Array, skin: "Callable[[], Surface]"
) -> Sites:
    """Place the end organs of the population of `ask` under the skin, or without one the central.

    The population lies about the first touch of the standard plate, wherever the indenter is.
    """
    if ask.population is None:
        return central_sites(ask, pulp, origin, axis)
    # Here, as a scene without a population loads none of the afferents.

    from fefinger.mechanics.press import unit_placement

    units = unit_placement.place_units(ask, skin(), direction(STANDARD))
    return unit_placement.of_population(units)


def meshed(points: Array, triangles: Integers, normals: Array, *, half: bool) -> "Surface":
    """Return the skin of a mesh: triangles (n, 3) of its pad, smooth outward normals (n_points, 3).

    That of a half model is mirrored.
    """
    from fefinger.neural.populations import Surface

    weights = np.repeat(triangle_areas(points[triangles]) / 3.0, 3)
    shares = np.bincount(triangles.ravel(), weights, len(points)).astype(np.float64)
    used = np.unique(triangles)
    used = used[np.linalg.norm(normals[used], axis=1) > 0.5]
    points, normals, shares = points[used], normals[used], shares[used]
    if half:
        halves = Halves.of(points)
        points, normals = halves.vectors(points), halves.vectors(normals)
        shares = halves.shares(shares)
    return Surface(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), shares)


def spherical(radius: float, axis: Array) -> "Surface":
    """Return a pad of `radius` mm that touches the origin, where `axis` (3,) points inward."""
    from fefinger.neural.populations import Surface

    # A spherical pad ends where the sine of its slope is 0.9.
    reach = 0.9 * radius
    lattice = 0.4  # mm between the points of a spherical pad
    x = lattice * np.arange(-np.floor(reach / lattice), np.floor(reach / lattice) + 1)
    flat = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    flat = flat[np.linalg.norm(flat, axis=1) <= reach]
    depth = np.sqrt(radius**2 - np.sum(flat**2, axis=1))
    outward = flat @ directions(axis) - np.outer(depth, axis)
    return Surface(radius * axis + outward, outward / radius, lattice**2 * radius / depth)

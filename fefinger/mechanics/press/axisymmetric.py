"""Response to a scene from an axisymmetric elastic contact, by `theory/contact/ting.py`.

The finger is a body with one G whose pad is a sphere; its contact grows in circles.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Protocol

import numpy as np

from fefinger.geometry.profiles import directions
from fefinger.mechanics.press.mesh_limits import check_reached
from fefinger.mechanics.press.sites import (
    REFERENCE_DEPTH,
    central_sites,
    end_organ_sites,
    spherical,
)
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.results.records import Pad, Response, Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import BeyondError, InputError
from fefinger.support.progress import Progress, Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact import ting
from fefinger.theory.relaxation import Prony, creep_integral, in_series


if TYPE_CHECKING:
    from fefinger.neural.drives import Reference


RINGS, SECTORS = 16, 24  # of the pad on which the pressure is reported


class ElasticContact(Protocol):
    """A contact of the relaxed body, by the depth (n,) mm of the indenter."""

    def force(self, depth: Array) -> Array:
        """Return the force (n,) in mN."""

    def depth(self, force: float) -> Array:
        """Return the depth in mm under a force in mN."""

    def contact_radius(self, depth: Array) -> Array:
        """Return the contact radius (n,) in mm."""

    def load(self, depth: Array, r: Array) -> Array:
        """Return the force (n, m) in mN within the distances r (m,) mm of the axis."""

    def strain(self, depth: Array, r: Array, z: Array) -> Array:
        """Return e_r, e_t, e_z, e_rz (n, 4, m) at r, z (m,) mm, z > 0 below the surface."""


@dataclass(frozen=True)
class Touch:
    """First touch: where (3,) mm, and the unit inward normal of the pad (3,) there."""

    origin: Array
    axis: Array


def touch(finger: Finger, indenter: Indenter) -> Touch | None:
    """Return the first touch on the spherical pad, or None if the place is not on it."""
    upright = direction(STANDARD)
    center = finger.pad_radius * upright
    at, flat = indenter.place, indenter.flat
    if flat is not None:
        axis = direction(flat)
    elif at is None:
        axis = upright
    else:
        aside = (center[:2] - np.asarray(at)) / finger.pad_radius
        if aside @ aside >= 1:
            return None
        axis = np.append(aside, np.sqrt(1 - aside @ aside))
    return Touch(center - finger.pad_radius * axis, axis)


def respond(
    scene: Scene,
    contact: ElasticContact,
    plate: ElasticContact,
    progress: Progress | None = None,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    numbers: dict[str, float],
    share: float = 0.0,
) -> Response:
    """Solve the scene with the elastic `contact`; `plate`: contact of the finger with a plate.

    share: the part that a soft object has in the compliance at once, before tissue relaxes.

    InputError if the indenter is placed beyond the pad.
    """
    stages, finger, motion = Stages(progress), scene.finger, scene.motion
    first = _first_touch(scene)
    with stages.stage("contact"):
        time = time_grid(motion, fast="FAII" in scene.ask.spikes)
        prony = in_series(finger.prony, share, scene.indenter.soft_prony)
        history = _march(motion, time, prony, contact)
        deepest = float(history.depth.max())
        check_reached(motion, finger.pulp, deepest)
        _check_width(contact, deepest, numbers["relative_radius_mm"])
        force = history.stress(contact.force(history.nodes)) / prony.long_time
    pad = pressure = area = middle = None
    if scene.ask.wants("pressure"):
        with stages.stage("pressure"):
            pad, pressure = _pressure(finger.pad_radius, prony, contact, first, history)
            area = np.pi * contact.contact_radius(history.edge) ** 2
            middle = np.where((force > 0)[:, None], first.origin[:2], np.nan)
    sites = reference = strain = None
    if scene.ask.wants("strain") or scene.ask.spikes:
        with stages.stage("strain"):
            skin = partial(spherical, finger.pad_radius, direction(STANDARD))
            sites = end_organ_sites(scene.ask, finger.pulp, first.origin, first.axis, skin)
            r, z, frames = _cylinder(first, sites)
            own = _of_the_skin(history, share, scene.indenter.soft_prony)
            strain = turned(own.strain(_strain(contact, history.nodes, r, z)), frames)
            reference = small_press(scene.ask, finger.pulp, plate) if scene.ask.spikes else None
    radii, steps = len(history.nodes), len(history.time)
    return Response(
        mechanics=mechanics,
        time=history.time,
        depth=history.depth,
        force=force * NEWTON_PER_MILLINEWTON,
        contact_area=area,
        centroid=middle,
        pad=pad,
        pressure=pressure,
        sites=sites,
        strain=strain,
        reference=reference,
        status=f"Solved: the elastic contact at {radii} contact radii, {steps} time steps.",
        seconds=stages.seconds,
        notes=notes,
        numbers=numbers,
    )


def _first_touch(scene: Scene) -> Touch:
    first = touch(scene.finger, scene.indenter)
    if first is None:
        raise InputError(
            f"indenter.at: expected a place on the pad, a sphere of {scene.finger.pad_radius:g} mm "
            f"under the 30 degree plate, received {scene.indenter.place}"
        )
    return first


def _check_width(contact: ElasticContact, deepest: float, radius: float) -> None:
    widest = float(contact.contact_radius(np.array([deepest]))[0])
    if widest > radius * (1 + 1e-9):
        raise BeyondError(
            f"motion: expected a contact narrower than its relative radius of {radius:.4g} mm, "
            f"received one of {widest:.4g} mm at a depth of {deepest:.4g} mm; press less, or take "
            "a larger indenter"
        )


def _march(
    motion: Motion, time: Array, prony: Prony, contact: ElasticContact
) -> ting.ContactHistory:
    value = motion.value(time)
    if not motion.by_force:
        return ting.press_by_depth(prony, time, value, ting.radius_nodes(float(value.max())))
    force = value / NEWTON_PER_MILLINEWTON
    nodes = ting.radius_nodes(float(contact.depth(float(force.max()))) * (1 + 1e-9))
    elastic = ting.ElasticForce(nodes, contact.force(nodes) / prony.long_time)
    return ting.press_by_force(prony, time, force, elastic)


def _of_the_skin(history: ting.ContactHistory, share: float, soft: Prony) -> ting.ContactHistory:
    """Return a history without the displacement of a soft object, which creeps under the stress."""
    if not share:
        return history
    yielded = share * creep_integral(soft, history.time, history.stressed)
    return replace(history, strained=history.strained - yielded)


def _pressure(
    radius: float,
    prony: Prony,
    contact: ElasticContact,
    first: Touch,
    history: ting.ContactHistory,
) -> tuple[Pad, Array]:
    """Return the pad out to the widest contact and the pressure (n_t, n_pad) in kPa on it."""
    nodes = history.nodes
    last = min(int(np.searchsorted(nodes, history.edge.max())), len(nodes) - 1)
    reach = float(contact.contact_radius(nodes[last : last + 1])[0])
    edges = reach * np.arange(1, RINGS + 1) / RINGS
    areas = np.pi * np.diff(edges**2, prepend=0.0)
    load = np.diff(contact.load(nodes, edges), axis=1, prepend=0.0)
    rings = history.stress(load / areas) / prony.long_time
    sectors = np.append(1, np.full(RINGS - 1, SECTORS))
    ring = np.repeat(np.arange(RINGS), sectors)
    return _pad(first, edges, (areas / sectors)[ring], radius), rings[:, ring]


def _strain(contact: ElasticContact, depth: Array, r: Array, z: Array) -> Array:
    """Return the strain (n, 4, m) of a contact; InputError for points where it has none."""
    try:
        return contact.strain(depth, r, z)
    except ValueError as error:
        raise InputError(
            f"ask.depths: {error}; ask for other depths or for no strain, or press less"
        ) from error


def turned(components: Array, frames: Array) -> Array:
    """Return tensors (n_t, m, 3, 3) from e_r, e_t, e_z, e_rz (n_t, 4, m).

    frames (m, 3, 3) hold the unit vectors of r, t and z as rows.
    """
    radial, around, inward = np.moveaxis(frames, 1, 0)

    slanted = radial[:, :, None] * inward[:, None, :]
    parts = [each[:, :, None] * each[:, None, :] for each in (radial, around, inward)]
    basis = np.stack([*parts, slanted + np.swapaxes(slanted, 1, 2)], axis=1).reshape(-1, 4, 9)
    tensors = np.empty((len(components), len(frames), 9))
    # Written in place: with many sites a copy of the tensors takes as long as everything else.
    np.matmul(np.moveaxis(components, 2, 0), basis, out=np.moveaxis(tensors, 1, 0))
    return tensors.reshape(len(components), len(frames), 3, 3)


def small_press(ask: Ask, pulp: float, plate: ElasticContact) -> "Reference":
    """Return the strain of the relaxed finger under the standard plate, at a small depth."""
    from fefinger.neural.drives import Reference

    standard = Touch(np.zeros(3), direction(STANDARD))
    central = central_sites(ask, pulp, standard.origin, standard.axis)
    r, z, frames = _cylinder(standard, central)
    strain = turned(_strain(plate, np.array([REFERENCE_DEPTH]), r, z), frames)[0]
    return Reference(REFERENCE_DEPTH, central.types, central.normals, strain)


def _cylinder(first: Touch, organs: Sites) -> tuple[Array, Array, Array]:
    """Return r, z (m,) of the sites about the axis of the contact, and their frames (m, 3, 3).

    The body has the skin flat: r belongs to the skin above a site, z is the depth below it, and the
    frame is turned so that z runs along the site's own normal.
    """
    offset = organs.points + organs.depths[:, None] * organs.normals - first.origin
    aside = offset - np.outer(offset @ first.axis, first.axis)
    r = np.linalg.norm(aside, axis=1)
    side = directions(first.axis)[0]
    away = r > 1e-12 * (1.0 + np.abs(offset).max())
    radial = np.where(away[:, None], aside / np.where(away, r, 1.0)[:, None], side)
    inward = -organs.normals
    radial = radial - np.einsum("ij,ij->i", radial, inward)[:, None] * inward
    radial /= np.linalg.norm(radial, axis=1, keepdims=True)
    frames = np.stack([radial, np.cross(inward, radial), inward], axis=1)
    return np.where(away, r, 0.0), organs.depths, frames


def _pad(first: Touch, edges: Array, areas: Array, radius: float) -> Pad:
    """Return points on the spherical pad: the middle, then rings of sectors out to `edges` mm.

    The pressure at a point is the mean over its cell of `areas` (n_pad,) mm², so that the sum of
    pressure times area is the force.
    """
    r = np.repeat((edges[1:] + edges[:-1]) / 2, SECTORS)
    angle = np.tile(2 * np.pi * np.arange(SECTORS) / SECTORS, RINGS - 1)
    one, two = directions(first.axis)
    aside = np.outer(r * np.cos(angle), one) + np.outer(r * np.sin(angle), two)
    aside = np.concatenate([np.zeros((1, 3)), aside])
    drop = np.concatenate([[0.0], r**2 / (2 * radius)])
    normals = aside / radius - first.axis
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = first.origin + aside + drop[:, None] * first.axis
    here = np.arange(SECTORS)
    after = (here + 1) % SECTORS
    fan = np.column_stack([np.zeros(SECTORS, np.int64), after + 1, here + 1])
    inner = 1 + SECTORS * np.arange(RINGS - 2)[:, None]
    outer = inner + SECTORS
    strips = [
        np.stack([inner + here, inner + after, outer + here], axis=-1),
        np.stack([inner + after, outer + after, outer + here], axis=-1),
    ]
    triangles = np.concatenate([fan, np.stack(strips, axis=1).reshape(-1, 3)])
    return Pad(points, areas, normals, triangles)

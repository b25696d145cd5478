"""The Response of a finite-element press: pad, areas, centroid, frames and notes."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.body import Body, Solid
from fefinger.fem.contact.contact_area import Surface as Touched
from fefinger.fem.contact.patch import Seen
from fefinger.fem.elements.probe import tensors
from fefinger.geometry import mirror
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mechanics.press.notes import normalized, relaxing
from fefinger.mechanics.press.problem import Contact
from fefinger.neural.reference import Reference
from fefinger.results.records import Fields, Pad
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.progress import Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


FRAMES_MOVING, FRAMES_RESTING = 20, 6


def origins(mesh: FingerMesh, finger: Solid, stages: Stages) -> dict[str, str]:
    """Return what an answer was computed from, with what solver, and in how much memory."""
    found = {"mesh": mesh.name, "mesh_sha256": mesh.fingerprint, "memory": stages.memory}
    return found | {"solver": finger.system.name} if isinstance(finger, Body) else found


def gave_way(finger: Solid) -> tuple[str, ...]:
    """Return which factors in single precision failed."""
    if not isinstance(finger, Body):
        return ()
    count = len(finger.system.failed)
    if not count:
        return finger.system.solver.notes
    tangents = (
        f"Single precision failed for {count} factor{'s' if count > 1 else ''} of the tangent; "
        f"{'those' if count > 1 else 'that'} in double precision, of twice the memory, "
        f"{'were' if count > 1 else 'was'} taken instead."
    )
    return (*finger.system.solver.notes, tangents)


def inside(gap: Array) -> float:
    """Return how far a vertex of the pad lies inside the indenter at most, in mm.

    Contact closes the gaps weighted with the hats, not the one at each vertex.
    """
    return float(np.maximum(-gap, 0.0).max(initial=0.0))


def exact(penetration: float) -> str:
    """Return in what sense the complementarity of a contact is exact, for its status."""
    return (
        "exact complementarity of pressures and weighted gaps; "
        f"vertices lie up to {penetration:.2g} mm inside the indenter"
    )


def frames_of(depth: Array, peak: int) -> NDArray[np.int64]:
    """Choose frames that share the path of the indenter, a few of its rests, and the peak."""
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(depth)))])
    moving = np.searchsorted(path, np.linspace(0, path[-1], FRAMES_MOVING))
    evenly = np.linspace(0, len(depth) - 1, FRAMES_RESTING).round()
    return np.unique(np.concatenate([moving, evenly, [peak]]).astype(np.int64))


def answer(
    scene: Scene,
    finger: Solid,
    contact: Contact,
    reference: Reference | None,
    fields: Fields | None,
) -> dict[str, Any]:
    """Return the fields of a Response that the solved contact gives."""
    history, on_pad = contact.history, contact.reduced.patch
    seen = on_pad.seen
    pad, column = whole_pad(finger, seen.vertices, seen.triangles, seen.areas)
    pressure = on_seen(history.pressure, seen)[:, column]
    sides = 2 if finger.half else 1
    force = sides * history.pressure @ on_pad.travel * NEWTON_PER_MILLINEWTON
    strain = None
    if contact.sites is not None:
        components = history.elastic @ contact.reduced.strain.T
        strain = tensors(components.reshape(len(contact.time), -1, 6))
        strain = mirror.from_half(strain, contact.sites.points) if finger.half else strain
    asked = scene.ask.pressure
    approach = history.elastic @ contact.reduced.approach.T
    gap = on_pad.clearance(history.depth, approach)[:, column]
    penetration = inside(gap)
    surface = Touched(pad.points, pad.triangles, contact.touch.axis, contact.touch)
    return {
        "time": contact.time,
        "depth": history.depth,
        "force": force,
        "contact_area": surface.area(pressure > 0, gap) if asked else None,
        "centroid": centroid(pad, pressure) if asked else None,
        "pad": pad if asked else None,
        "pressure": pressure if asked else None,
        "gap": gap if asked else None,
        "moment": whole_moment(history.pressure @ on_pad.moment, finger.half) if asked else None,
        "sites": contact.sites,
        "strain": strain,
        "reference": reference,
        "fields": fields,
        "status": f"Solved: {history.exchanges} contact solutions with {exact(penetration)}.",
        "numbers": {
            "unknowns": finger.space.n_unknowns,
            "candidates": len(on_pad.vertices),
            "half": float(finger.half),
            "penetration_mm": penetration,
        },
    }


def on_seen(pressure: Array, seen: Seen) -> Array:
    """Return the pressure (n_t, n_seen) kPa at all vertices seen: none but the candidates'."""
    return np.pad(pressure, ((0, 0), (0, len(seen.vertices) - pressure.shape[1])))


def whole_moment(meshed: Array, half: bool) -> Array:
    """Return the moment (n_t, 3) N mm on the whole finger about the origin."""
    whole = meshed * np.array([0.0, 2.0, 0.0]) if half else meshed
    return np.asarray(whole * NEWTON_PER_MILLINEWTON)


def centroid(pad: Pad, pressure: Array) -> Array:
    """Return the center (n_t, 2) mm of the pressure in x and y, nan where there is none."""
    total = (pressure @ pad.areas)[:, None]
    moment = pressure @ first_moments(pad)[:, :2]
    return np.divide(moment, total, out=np.full_like(moment, np.nan), where=total > 0)


def first_moments(pad: Pad) -> Array:
    """Return the integrals (n_pad, 3) mm³ of every hat times the place, over the triangles."""
    corners = pad.points[pad.triangles]
    sides = corners[:, 1:] - corners[:, :1]
    twelfths = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 24
    moments = np.zeros_like(pad.points)
    share = twelfths[:, None, None] * (corners + corners.sum(axis=1, keepdims=True))
    np.add.at(moments, pad.triangles, share)
    return moments


def whole_pad(
    finger: Solid, vertices: NDArray[np.int64], faces: NDArray[np.int64], areas: Array
) -> tuple[Pad, NDArray[np.int64]]:
    """Return the pad of the whole finger, and which of `vertices` each of its points is."""
    points, normals = finger.space.points[vertices], finger.normals[vertices]
    column = np.arange(len(points))
    number = np.full(len(finger.space.points), -1, dtype=np.int64)
    number[vertices] = column
    triangles = number[faces]
    triangles = triangles[(triangles >= 0).all(axis=1)]
    if not finger.half:
        return Pad(points, areas, normals, triangles), column
    halves = mirror.Halves.of(points)
    pad = Pad(
        points=halves.vectors(points),
        areas=halves.shares(areas),
        normals=halves.vectors(normals),
        triangles=halves.triangles(triangles),
    )
    return pad, halves.origin


def scene_notes(scene: Scene) -> tuple[str, ...]:
    """Return what a reader has to know of this scene's finger."""
    cut = "held" if scene.finger.cut == "fixed" else "free"
    own = relaxing(scene.finger)
    return (f"The proximal cut of the tissue is {cut}.", *normalized(scene.finger.prony), *own)

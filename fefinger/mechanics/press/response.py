"""The Response of a finite-element press, and its fields on the mesh."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import sparse

from fefinger.contact.stepper import History
from fefinger.fem.body import Body, Solid
from fefinger.fem.contact.contact_area import CandidateSurface
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.probe import gradient_at_vertices, strain_at_vertices
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.stored_energy import StoredEnergy
from fefinger.geometry import finger_mesh
from fefinger.geometry.finger_mesh import SKIN, SUBCUTANEOUS, FingerMesh, inside_weights
from fefinger.mechanics.press import finite_sliding, moving_contact
from fefinger.mechanics.press.placement import first_moments, on_neighborhood, whole_pad
from fefinger.mechanics.press.problem import (
    FiniteStrainHistory,
    Press,
    SmallStrainHistory,
    frames_of,
    materials,
)
from fefinger.results.records import Fields, Pad, Response
from fefinger.support.arrays import Array, Integers
from fefinger.support.progress import Stages
from fefinger.support.tensors import VOIGT, logarithmic, tensor_from_voigt
from fefinger.support.units import NEWTON_PER_MILLINEWTON


def small_strain_fields(
    press: Press, contact: History, on_pad: Patch, solve: Callable[[Integers], Array]
) -> Fields:
    """Fields of a contact on a patch at some of the times.

    solve: the unknowns (n_unknowns, n) of the body at times of these numbers (n,).
    """
    frames = frames_of(contact.depth, int(np.argmax(contact.pressure @ on_pad.projected)))
    unknowns, original = solve(frames), press.body.original
    fields = no_fields(press.mesh, press.time[frames])
    fields.displacement[:, original] = unknowns[: 3 * len(original)].T.reshape(len(frames), -1, 3)
    at_vertices = strain_at_vertices(press.body.space) @ unknowns
    fields.strain[:, original] = at_vertices.T.reshape(len(frames), -1, 6)
    fields.pressure[:, original[on_pad.vertices]] = contact.pressure[frames]
    energy = _energies(press, finite=False)
    return replace(fields, energy=np.array([energy(each) for each in unknowns.T]))


def finite_strain_fields(
    press: Press, times: Array, states: Iterable[Array], pad: Integers, pressure: Array
) -> Fields:
    """Fields at times (n,) s, from the unknowns (n_unknowns,) of the body at each.

    pressure (n, n_pad) kPa at its vertices `pad` (n_pad,); the strain is logarithmic.
    """
    original, gradients = press.body.original, gradient_at_vertices(press.body.space)
    fields, (rows, columns) = no_fields(press.mesh, times), zip(*VOIGT, strict=True)
    fields.pressure[:, original[pad]] = pressure
    energy, densities = _energies(press, finite=True), []
    for frame, values in enumerate(states):
        fields.displacement[frame, original] = values[: 3 * len(original)].reshape(-1, 3)
        logs = logarithmic((gradients @ values).reshape(-1, 3, 3))
        fields.strain[frame, original] = logs[:, rows, columns]
        densities.append(energy(values))
    return replace(fields, energy=np.array(densities))


def _energies(press: Press, *, finite: bool) -> Callable[[Array], Array]:
    """Return a function from unknowns (n_unknowns,) of the body to `Fields.energy` (n_points, 2).

    The tissues are taken relaxed, and with their instantaneous moduli.
    """
    finger, body = press.finger, press.body
    stored = _stored_energy(press, finite=finite)
    tissues = {SKIN: finger.skin, SUBCUTANEOUS: finger.subcutaneous}
    rises = {k: 1 / (tissue.prony or finger.prony).long_time for k, tissue in tissues.items()}
    rise = np.array([rises[int(label)] for label in stored.tissue])
    of_volume = rise if finger.relaxation == "whole" else np.ones_like(rise)

    def energy(values: Array) -> Array:
        distortion, volume = stored.cells(values[: body.space.n_displacements].reshape(-1, 3))
        limits = distortion + volume, rise * distortion + of_volume * volume
        densities = np.zeros((len(press.mesh.points), len(limits)))
        densities[body.original] = np.column_stack([stored.at_vertices(each) for each in limits])
        return densities

    return energy


def _stored_energy(press: Press, *, finite: bool) -> StoredEnergy:
    """Energy of skin and subcutaneous tissue, relaxed."""
    relaxed = materials(press.finger)
    soft = {label: relaxed[label] for label in (SKIN, SUBCUTANEOUS)}
    return StoredEnergy(press.body.space, soft, finite=finite)


def stiffening(press: Press, states: Iterable[Array]) -> Array:
    """Mean exponent (n,) of the energy of the tissues at states (n_unknowns,) of the body."""
    stored, count = _stored_energy(press, finite=True), press.body.space.n_displacements
    return np.array([stored.stiffening(values[:count].reshape(-1, 3)) for values in states])


def no_fields(mesh: FingerMesh, times: Array) -> Fields:
    """Zero fields at times (n,) s on a whole mesh; they stay zero in its rigid parts."""
    shape = len(times), len(mesh.points)
    return Fields(
        mesh.points,
        mesh.cells,
        mesh.region,
        times,
        displacement=np.zeros((*shape, 3)),
        strain=np.zeros((*shape, 6)),
        pressure=np.zeros(shape),
    )


def interpolation(space: Space, points: Array) -> sparse.csr_matrix:
    """Matrix (n_points, n_vertices) from values at the vertices of a mesh to those at points.

    Linear within the cells; a point just outside gets the values of the nearest place.
    """
    cell, weights = inside_weights(space.points[space.vertices], points)
    rows = np.arange(len(points)).repeat(4)
    where = (rows, space.vertices[cell].ravel())
    return sparse.csr_matrix((weights.ravel(), where), (len(points), len(space.points)))


def small_strain_response(press: Press, history: SmallStrainHistory, stages: Stages) -> Response:
    """Return the Response of a press solved at small strain."""
    contact, on_pad = history.contact, history.reduced.patch

    def solve(frames: Integers) -> Array:
        loads = on_pad.loads @ contact.elastic_pressure[frames].T
        return press.method.unknowns(press.body, np.asarray(loads))

    with stages.stage("fields"):
        fields = small_strain_fields(press, contact, on_pad, solve) if press.fields else None
    with stages.stage("pressure"):
        pad, column = whole_pad(press.body, on_pad.neighborhood)
        pressure = on_neighborhood(contact.pressure, on_pad.neighborhood)[:, column]
        displacement = contact.elastic_pressure @ history.reduced.normal_displacement.T
        displacement += history.reduced.object.recession(press.time, contact.pressure)
        if press.motion.slides:
            on_pad = replace(on_pad, distance=moving_contact.distances(press, on_pad))
        gap = on_pad.clearance(contact.depth, displacement)[:, column]
        quantities = {}
        if press.pressure:
            obstacle, bearing = press.obstacle, pressure > 0
            edges = obstacle if press.indenter.sharp else None
            surface = CandidateSurface(pad.points, pad.triangles, obstacle.axis, edges)
            moves = press.motion.slides and not obstacle.profile.plane
            area = bearing @ pad.areas if moves else surface.area(bearing, gap)
            moment = contact.pressure @ on_pad.moment
            quantities = of_pressure(pad, pressure, area, gap, moment, press.body.half)
        force = press.body.sides * contact.pressure @ on_pad.projected * NEWTON_PER_MILLINEWTON
        strain = None
        if press.sites is not None:
            components = contact.elastic_pressure @ history.reduced.strain_operator.T
            strain = press.unfolded(tensor_from_voigt(components.reshape(len(press.time), -1, 6)))
        lateral = moving_contact.lateral(press, history, pad, column) if press.tangential else None
    penetration = deepest_penetration(gap)
    return make_response(
        press,
        stages,
        len(on_pad.vertices),
        penetration,
        notes=moving_contact.notes(press),
        time=press.time,
        depth=contact.depth,
        force=force,
        strain=strain,
        reference=history.reference,
        fields=fields,
        status=f"Solved: {contact.exchanges} contact solutions with {exactness(penetration)}.",
        lateral=lateral,
        **quantities,
    )


def finite_strain_response(press: Press, history: FiniteStrainHistory, stages: Stages) -> Response:
    """Return the Response of a press solved at finite strain, at all times up to its end."""
    with stages.stage("fields"):
        fields = _kept_fields(press, history) if press.fields else None
    with stages.stage("pressure"):
        steps, seen = history.steps, history.contact.neighborhood
        pressure, force, scale = _between_steps(press, history)
        pad, column = whole_pad(press.body, seen)
        quantities = {}
        if press.pressure:
            quantities = of_pressure(
                pad,
                on_neighborhood(pressure, seen)[:, column],
                steps.bounded(areas_of_steps(press, history, pad, column)),
                steps.smooth(history.gap)[:, column],
                steps.smooth(history.moment),
                press.body.half,
            )
        by_force = press.motion.by_force
        depth = steps.bounded(history.depth) if by_force else steps.path
        strain = press.unfolded(steps.smooth(history.strain)) if press.sites else None
        lateral = None
        if press.tangential:
            lateral = finite_sliding.lateral(press, history, pressure, scale, column)
    penetration = deepest_penetration(history.gap)
    work = {
        "steps": len(history.depth),
        "iterations": history.iterations,
        "downhill": history.descents,
    }
    return make_response(
        press,
        stages,
        len(history.contact),
        penetration,
        notes=finite_sliding.notes(press),
        numbers=work,
        time=steps.time,
        depth=depth,
        force=force,
        strain=strain,
        reference=history.reference,
        fields=fields,
        status=_status(history, penetration),
        lateral=lateral,
        **quantities,
    )


def of_pressure(
    pad: Pad, pressure: Array, area: Array, gap: Array, moment: Array, half: bool
) -> dict[str, Any]:
    """Return the quantities of a Response that are read from the pressure.

    pressure (n_t, n_pad) kPa and gap (n_t, n_pad) mm on the pad of the whole finger, area (n_t,)
    mm², moment (n_t, 3) mN mm of the meshed part, which is `half` of the finger or all of it.
    """
    total, first = (pressure @ pad.areas)[:, None], pressure @ first_moments(pad)[:, :2]
    return {
        "pad": pad,
        "pressure": pressure,
        "contact_area": area,
        "centroid": np.divide(first, total, out=np.full_like(first, np.nan), where=total > 0),
        "gap": gap,
        "moment": moment * (np.array([0.0, 2.0, 0.0]) if half else 1.0) * NEWTON_PER_MILLINEWTON,
    }


def make_response(
    press: Press,
    stages: Stages,
    candidates: int,
    penetration: float,
    *,
    notes: tuple[str, ...],
    numbers: Mapping[str, float] | None = None,
    **quantities: Any,
) -> Response:
    """Return the Response of a press: its `quantities`, and what every answer of a mesh states."""
    body, mesh = press.body, press.mesh
    return Response(
        mechanics=press.mechanics,
        sites=press.sites,
        seconds=stages.seconds,
        notes=(*press.notes, *_precision(body), *notes),
        numbers={
            "unknowns": body.space.n_unknowns,
            "candidates": candidates,
            "half": float(body.half),
            **(numbers or {}),
            "penetration_mm": penetration,
        },
        sources={"mesh": mesh.name, "mesh_sha256": mesh.fingerprint, "memory": stages.memory},
        **quantities,
    )


def _precision(body: Solid) -> tuple[str, ...]:
    if not isinstance(body, Body):
        return ()
    count = len(body.system.failed)
    tangents = (
        f"Single precision failed for {count} factor{'s' if count > 1 else ''} of the tangent; "
        f"{'those' if count > 1 else 'that'} in double precision, of twice the memory, "
        f"{'were' if count > 1 else 'was'} taken instead."
    )
    return (tangents,) if count else ()


def deepest_penetration(gap: Array) -> float:
    """Return the largest depth in mm of a vertex of the pad inside the indenter.

    Contact closes the gaps weighted with the hats, not the one at each vertex.
    """
    return float(np.maximum(-gap, 0.0).max(initial=0.0))


def exactness(penetration: float) -> str:
    """Describe for the status of a contact how exact its complementarity is."""
    return (
        "exact complementarity of pressures and weighted gaps; "
        f"vertices lie up to {penetration:.2g} mm inside the indenter"
    )


def _kept_fields(press: Press, history: FiniteStrainHistory) -> Fields:
    """Return the fields at the load steps whose state was kept."""
    kept = np.array(sorted(history.frames))
    states = (history.frames[number] for number in kept)
    vertices, pressure = history.contact.on.vertices, history.pressure[kept]
    return finite_strain_fields(press, history.steps.times[kept], states, vertices, pressure)


def _between_steps(press: Press, history: FiniteStrainHistory) -> tuple[Array, Array, Array]:
    """Return the pressure (n_t, n_candidates) kPa and the force (n_t,) N at all times.

    Under force control both are scaled to the prescribed force; the last (n_t,) is the factor.
    """
    pressure = history.steps.bounded(history.pressure)
    axial = history.steps.bounded(history.sideways.axial)
    force = press.body.sides * (pressure @ history.contact.projected + axial)
    force *= NEWTON_PER_MILLINEWTON
    ratio = np.ones_like(force)
    if press.motion.by_force:  # that is prescribed between the steps as well
        np.divide(history.steps.path, force, out=ratio, where=force > 0)
    return pressure * ratio[:, None], force * ratio, ratio


def areas_of_steps(press: Press, history: FiniteStrainHistory, pad: Pad, column: Integers) -> Array:
    """Contact areas (n,) mm² of the whole, deformed finger at the steps."""
    obstacle, seen = history.contact.obstacle, history.contact.neighborhood
    edges = obstacle if press.indenter.sharp else None
    sign = np.ones((len(column), 3))
    sign[len(seen.vertices) :] = finger_mesh.SIGNS  # the mirror images follow
    pressed = on_neighborhood(history.pressure, seen)[:, column] > 0
    areas, places = np.empty(len(history.depth)), press.places(history.steps.times)
    for step, moved in enumerate(history.moved):
        points = pad.points + sign * moved[column] - places[step]
        surface = CandidateSurface(points, pad.triangles, obstacle.axis, edges)
        areas[step] = surface.area(pressed[step][None], history.gap[step][column][None])[0]
    return areas


def _status(history: FiniteStrainHistory, penetration: float) -> str:
    globalized = (
        f", {history.descents} of them by a globalized Newton method," if history.descents else ""
    )
    return (
        f"{'Stopped' if history.halt else 'Solved'}: {len(history.depth)} steps{globalized} in "
        f"{history.iterations} iterations on {history.factors + 1} factors, with "
        f"{exactness(penetration)}.{f' Then: {history.halt}' if history.halt else ''}"
    )

"""Fields on the mesh at some of the times of a press."""

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np
from scipy import sparse

from fefinger.contact.march import History
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.probe import gradient_at_vertices, strain_at_vertices
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.stored_energy import StoredEnergy
from fefinger.geometry.finger_mesh import SKIN, SUBCUTANEOUS, FingerMesh
from fefinger.geometry.locate import inside_weights
from fefinger.geometry.voigt import VOIGT, logarithmic
from fefinger.mechanics.press.materials import materials
from fefinger.mechanics.press.problem import Press, frames_of
from fefinger.results.records import Fields
from fefinger.support.arrays import Array, Integers


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

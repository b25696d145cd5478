"""Fields on the mesh under unit elastic stresses of a loop, for pictures of it while it is stepped.

What a loop steps is linear in the elastic stress of its contact, but for the logarithmic strain at
finite strain, which is interpolated between the tabulated depths as at the end organs.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fefinger.fem.body import Solid
from fefinger.fem.condensation import Operator, displaced
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.probe import gradient_at_vertices, strain_at_vertices
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.mechanics.press.modal_body import FingerModes, ModalBody
from fefinger.mechanics.press.tabulated_press import TabulatedPress
from fefinger.mesh.store import load_or_build
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array, Integers
from fefinger.support.tensors import VOIGT, logarithmic


Single = NDArray[np.float32]


@dataclass(frozen=True)
class UnitFields:
    """Fields on the mesh of a finger, half or whole, under each of k unit elastic stresses.

    mesh: of all regions; displacement (k, n_points, 3) mm and strain (k, n_points, 6), with the
    components xx yy zz xy yz xz, 0 in rigid parts; pad (n,): the points of `Step.pressure`.
    """

    mesh: FingerMesh
    displacement: Single
    strain: Single
    pad: Integers


def at_small_strain(
    finger: Finger, operator: Operator, patch: Patch, *, with_continuation: bool = False
) -> UnitFields:
    """Return the fields under unit loads of a patch, by the condensed operator."""
    mesh = load_or_build(finger, half=operator.half, with_continuation=with_continuation)
    return _linear(mesh, operator, patch, displaced(operator, patch.loads.tocsc()))


def with_inertia(
    finger: Finger,
    operator: Operator,
    modes: FingerModes,
    body: ModalBody,
    *,
    with_continuation: bool,
) -> UnitFields:
    """Return the fields under unit loads of a patch, and then of unit amplitudes of the modes."""
    mesh = load_or_build(finger, half=operator.half, with_continuation=with_continuation)
    patch, space = body.static.patch, operator.space
    static, count = displaced(operator, patch.loads.tocsc()), len(body.participation)
    shapes = np.zeros((len(static), count))
    shapes[: space.n_displacements] = modes.combined(
        space.n_displacements, np.arange(count), np.eye(count)
    )
    own = body.participation / body.oscillators.omega_squared[:, None]
    return _linear(mesh, operator, patch, np.hstack([static - shapes @ own, shapes]))


def at_finite_strain(tabulated: TabulatedPress) -> UnitFields:
    """Return the fields at the depths of a table."""
    press, table = tabulated.press, tabulated.table
    space, (rows, columns) = press.body.space, zip(*VOIGT, strict=True)
    states = table.unknowns(table.at_depths, space.n_unknowns)
    gradients = gradient_at_vertices(space)
    strain = np.array([logarithmic((gradients @ u).reshape(-1, 3, 3)) for u in states])
    return _on_mesh(
        press.mesh, press.body, states, strain[..., rows, columns], tabulated.contact.on.vertices
    )


def _linear(mesh: FingerMesh, operator: Operator, patch: Patch, unknowns: Array) -> UnitFields:
    """Return the fields of unknowns (n_unknowns, k) at small strain."""
    strain = (strain_at_vertices(operator.space) @ unknowns).T
    shape = len(strain), -1, 6
    return _on_mesh(mesh, operator, unknowns.T, strain.reshape(shape), patch.vertices)


def _on_mesh(
    mesh: FingerMesh, body: Solid, unknowns: Array, strain: Array, pad: Integers
) -> UnitFields:
    """Return unknowns (k, n_unknowns) and strain (k, n, 6) of a body on the whole mesh."""
    original, shape = body.original, (len(unknowns), len(mesh.points))
    displacement, strains = np.zeros((*shape, 3), np.float32), np.zeros((*shape, 6), np.float32)
    displacement[:, original] = unknowns[:, : 3 * len(original)].reshape(len(unknowns), -1, 3)
    strains[:, original] = strain
    return UnitFields(mesh, displacement, strains, original[pad])

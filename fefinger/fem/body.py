"""A finger as a factored elastic body: soft tissue, held facets, symmetry, one factor."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fefinger.checks import InputError
from fefinger.fem.contact import Patch
from fefinger.fem.forms import Elastic, stiffness
from fefinger.fem.solve import System, factor
from fefinger.fem.spaces import Array, Integers, Space
from fefinger.mesh.record import FingerMesh, volumes


FLAT = 1e-6  # volume over the cube of the longest edge from a corner, of a cell without volume
BLOCK = 64  # loads solved at once: enough to stream the factor once for many, small in memory


@dataclass(frozen=True)
class Body:
    """A factored body.

    pad (n, 3) triangles and normals (n_points, 3) in the numbering of the space; original
    (n_points,) the number that each vertex has in the mesh; half: only y >= 0 is there.
    """

    space: Space
    system: System
    pad: Integers
    normals: Array
    original: Integers
    half: bool


@dataclass(frozen=True)
class Reduced:
    """What the body does under unit loads on a patch.

    flexibility F (n, n), strain (n_rows, n), and approach (n, n) mm, the displacement of the
    patch's vertices along the obstacle's normal.
    """

    patch: Patch
    flexibility: Array
    strain: Array
    approach: Array


def body(mesh: FingerMesh, tissues: Mapping[int, Elastic], held: Sequence[str]) -> Body:
    """Assemble and factor the cells of `mesh` whose region is in `tissues`.

    `held` names the facets that do not move; the medial plane of a half finger slides in itself.
    A region that is left out (a rigid bone) must be held through the facets that bound it.

    Raises
    ------
    InputError
        If a tissue has no cells, a cell is inverted or flat, or the body can move freely.
    """
    _check(mesh, tissues)
    kept = np.isin(mesh.region, list(tissues))
    original, cells = np.unique(mesh.cells[kept], return_inverse=True)
    number = np.full(len(mesh.points), -1, dtype=np.int64)
    number[original] = np.arange(len(original))
    space = Space(mesh.points[original], cells.reshape(-1, 4), mesh.region[kept])
    fixed = [_unknowns(space, _present(space, mesh, number, name), (0, 1, 2)) for name in held]
    if mesh.half:
        fixed.append(_unknowns(space, _present(space, mesh, number, "medial"), (1,)))
    system = factor(space, stiffness(space, tissues), np.concatenate(fixed))
    pad = _present(space, mesh, number, "pad")
    return Body(space, system, pad, mesh.pad_normals[original], original, mesh.half)


def _check(mesh: FingerMesh, tissues: Mapping[int, Elastic]) -> None:
    """Raise InputError for a mesh that lacks a tissue or has cells without volume."""
    for label in tissues:
        if not (mesh.region == label).any():
            present = ", ".join(map(str, np.unique(mesh.region)))
            message = (
                f"mesh {mesh.name}: expected cells of region {label}, received regions {present} "
                "alone; mesh the finger again"
            )
            raise InputError(message)
    corners = mesh.points[mesh.cells]
    size = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2).max(axis=1)
    bad = np.flatnonzero(~(volumes(mesh.points, mesh.cells) > FLAT * size**3))
    if len(bad):
        message = (
            f"mesh {mesh.name}: expected cells of positive volume, received {len(bad)} inverted or "
            f"flat ones, the first of them number {bad[0]}; mesh the finger again"
        )
        raise InputError(message)


def reduce(
    body: Body,
    patch: Patch,
    strain: sparse.csr_matrix,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Reduced:
    """Solve for every unit load of the patch; keep F and the strains `strain` @ unknowns."""
    count = len(patch.vertices)
    flexibility = np.empty((count, count))
    strains = np.empty((strain.shape[0], count))
    approach = np.empty((count, count))
    for start in range(0, count, BLOCK):
        block = slice(start, min(start + BLOCK, count))
        unknowns = body.system.solve(patch.loads[:, block].toarray())
        flexibility[:, block] = patch.loads.T @ unknowns
        strains[:, block] = strain @ unknowns
        approach[:, block] = patch.places.T @ unknowns
        progress(block.stop / count)
    return Reduced(patch, (flexibility + flexibility.T) / 2, strains, approach)


def _present(space: Space, mesh: FingerMesh, number: Integers, name: str) -> Integers:
    """Triangles of the facets `name` that bound kept cells, in the numbering of the space."""
    triangles = number[mesh.facets[name]]
    return np.asarray(triangles[space.has_faces(triangles)])


def _unknowns(space: Space, triangles: Integers, components: Sequence[int]) -> Integers:
    if len(triangles) == 0:
        return np.empty(0, dtype=np.int64)
    nodes = space.face_nodes(triangles)
    return (3 * nodes[:, None] + np.asarray(components)).ravel()

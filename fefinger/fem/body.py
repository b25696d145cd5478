"""Linear elastic body of a finger mesh: soft tissue, held facets, symmetry and its system."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from fefinger.contact.soft import RIGID, PressingObject
from fefinger.fem.contact.patch import Patch
from fefinger.fem.elements.assembly import Elastic, numbering, stiffness
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg.system import System, factor, prepare
from fefinger.geometry import finger_mesh
from fefinger.geometry.finger_mesh import FingerMesh, volumes
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError


BLOCK = 64  # loads per solve: many share one pass through the factor, at little memory


@dataclass(frozen=True)
class Solid:
    """The soft tissue of a finger mesh with its finite-element space.

    pad (n, 3) triangles and normals (n_points, 3) in the numbering of the space; original
    (n_points,) the number of each vertex in the mesh; half: only y >= 0 is meshed.
    """

    space: Space
    pad: Integers
    normals: Array
    original: Integers
    half: bool

    @property
    def planes(self) -> tuple[int, ...]:
        """Axes normal to the planes of symmetry, beyond which the body is its mirror image."""
        return (1,) if self.half else ()

    @property
    def sides(self) -> int:
        """Number of copies of it in the whole finger: 2 of a half."""
        return 2 if self.half else 1

    def folded(self, points: Array) -> Array:
        """Return the places in it (n, 3) mm of points of the whole finger."""
        return finger_mesh.to_half(points) if self.half else points

    def unfolded(self, tensors: Array, points: Array) -> Array:
        """Return tensors (..., n, 3, 3) at points (n, 3), given those at their `folded` places."""
        return finger_mesh.from_half(tensors, points) if self.half else tensors

    @property
    def loadable(self) -> Flags | None:
        """Whether each vertex (n_points,) may be in contact; None if all of the pad may be."""
        return None

    def cut_off(self, vertices: Integers) -> bool:
        """Whether some of the vertices (n,) lie beside some of the pad that are not loadable."""
        if self.loadable is None:
            return False
        able = self.loadable[self.pad]
        return bool(np.isin(vertices, self.pad[able.any(axis=1) & ~able.all(axis=1)]).any())


@dataclass(frozen=True)
class Body(Solid):
    """A solid with the linear system of its stiffness matrix."""

    system: System


@dataclass(frozen=True)
class Reduced:
    """Response of a body to unit loads on a patch.

    flexibility F (n, n); strain_operator (n_rows, n): strain per unit load; normal_displacement
    (n_near, n) mm: of the patch's neighborhood, along the obstacle's normal; object: what presses.
    """

    patch: Patch
    flexibility: Array
    strain_operator: Array
    normal_displacement: Array
    object: PressingObject = RIGID


def body(
    mesh: FingerMesh,
    tissues: Mapping[int, Elastic],
    held: Sequence[str],
    *,
    factored: bool = True,
) -> Body:
    """Assemble and factor the cells of `mesh` whose region is in `tissues`.

    `held` names the facets that do not move; the medial plane of a half finger slides in itself.
    A region that is left out (a rigid bone) must be held through the facets that bound it.
    Unless `factored`, the matrix is factored on first use.

    Raises
    ------
    InputError
        If a tissue has no cells, a cell is inverted or flat, or a body to be factored can move
        freely.
    """
    _check(mesh, tissues)
    soft = solid(mesh, tissues)
    fixed = prescribed(soft, mesh, held)
    make = factor if factored else prepare
    system = make(soft.space, stiffness(soft.space, tissues), fixed)
    return Body(soft.space, soft.pad, soft.normals, soft.original, soft.half, system)


def solid(mesh: FingerMesh, regions: Iterable[int]) -> Solid:
    """Build the solid of those cells of `mesh` whose region is among `regions`."""
    chosen = np.isin(mesh.region, list(regions))
    original, cells = np.unique(mesh.cells[chosen], return_inverse=True)
    space = Space(mesh.points[original], cells.reshape(-1, 4), mesh.region[chosen])
    pad = _present(space, mesh, original, "pad")
    return Solid(space, pad, mesh.pad_normals[original], original, mesh.half)


def prescribed(
    soft: Solid, mesh: FingerMesh, held: Sequence[str], *, odd: bool = False
) -> Integers:
    """Prescribed (zero) unknowns: those on the facets `held` and in the medial plane.

    A field of half a finger continues beyond the medial plane as its mirror image or, if `odd`, as
    the negative of that: then the plane moves normal to itself only, and has no mean stress.
    """
    space = soft.space
    fixed = [
        _unknowns(space, _present(space, mesh, soft.original, name), (0, 1, 2)) for name in held
    ]
    if mesh.half:
        medial = _present(space, mesh, soft.original, "medial")
        fixed.append(_unknowns(space, medial, (0, 2) if odd else (1,)))
        if odd:
            inside = np.isin(space.vertices, medial)
            fixed.append(space.n_displacements + np.unique(space.pressures[inside]))
    return np.concatenate(fixed)


def _check(mesh: FingerMesh, tissues: Mapping[int, Elastic]) -> None:
    """Raise InputError for a mesh that lacks a tissue or has cells without volume."""
    for label in tissues:
        if not (mesh.region == label).any():
            present = ", ".join(map(str, np.unique(mesh.region)))
            raise InputError(
                f"mesh {mesh.name}: expected cells of region {label}, received only regions "
                f"{present}; mesh the finger again"
            )
    corners = mesh.points[mesh.cells]
    size = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2).max(axis=1)
    flat = 1e-6  # volume over (longest edge from a corner)³ below which a cell counts as flat
    bad = np.flatnonzero(~(volumes(mesh.points, mesh.cells) > flat * size**3))
    if len(bad):
        raise InputError(
            f"mesh {mesh.name}: expected cells of positive volume, received {len(bad)} inverted or "
            f"flat ones, the first of them number {bad[0]}; mesh the finger again"
        )


def reduce(
    body: Body,
    patch: Patch,
    strain: sparse.csr_matrix,
    progress: Callable[[float], None] = lambda fraction: None,
) -> Reduced:
    """Solve for every unit load of the patch: F, and the strains `strain` @ unknowns."""
    count = len(patch.vertices)
    flexibility = np.empty((count, count))
    strains = np.empty((strain.shape[0], count))
    displacement = np.empty((patch.places.shape[1], count))
    for start in range(0, count, BLOCK):
        block = slice(start, min(start + BLOCK, count))
        unknowns = body.system.solve(patch.loads[:, block].toarray())
        flexibility[:, block] = patch.loads.T @ unknowns
        strains[:, block] = strain @ unknowns
        displacement[:, block] = patch.places.T @ unknowns
        progress(block.stop / count)
    return Reduced(patch, (flexibility + flexibility.T) / 2, strains, displacement)


def _present(space: Space, mesh: FingerMesh, original: Integers, name: str) -> Integers:
    """Triangles of the facets `name` that bound the solid, in the numbering of the space."""
    triangles = numbering(original, len(mesh.points))[mesh.facets[name]]
    return np.asarray(triangles[space.has_faces(triangles)])


def _unknowns(space: Space, triangles: Integers, components: Sequence[int]) -> Integers:
    if len(triangles) == 0:
        return np.empty(0, dtype=np.int64)
    nodes = space.face_nodes(triangles)
    return (3 * nodes[:, None] + np.asarray(components)).ravel()

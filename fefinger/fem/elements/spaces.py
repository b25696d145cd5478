"""Taylor-Hood spaces on tetrahedra, with one continuous pressure per tissue.

Displacements are continuous quadratics, the mean stress p = K div u is a continuous linear inside
each tissue and free to jump from one tissue to the next, as the exact one does. The pair is
inf-sup stable, so nu = 0.5 is an ordinary case (Boffi, Brezzi and Fortin, Mixed Finite Element
Methods, 2013, section 8.8).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementTetP2, ElementTriP1, ElementTriP2, MeshTet, MeshTri

from fefinger.geometry.finger_mesh import triangle_areas
from fefinger.support.arrays import Array, Flags, Integers


class _Mesh(MeshTet):
    """Mesh of scikit-fem that finds its edges and faces by an integer for each.

    The numbering is the same. np.unique of columns, which scikit-fem calls, takes 6 times as long.
    """

    @staticmethod
    def build_entities(
        t: Integers, indices: Sequence[Sequence[int]], sort: bool = True
    ) -> tuple[Integers, Integers]:
        """Return entities (k, n) by their sorted vertices, and their numbers (m, n_cells)."""
        corners = np.sort(np.hstack([t[each] for each in indices]), axis=0)
        keys = np.zeros(corners.shape[1], dtype=np.int64)
        for row in corners:  # 64 bits suffice for three vertices below 2e6 points
            keys = keys * (int(t.max()) + 1) + row
        _, first, number = np.unique(keys, return_index=True, return_inverse=True)
        return np.ascontiguousarray(corners[:, first]), number.reshape(len(indices), -1)


@dataclass(frozen=True)
class Space:
    """Taylor-Hood space on a set of tetrahedra.

    points (n_points, 3) mm, cells (n_cells, 4), tissue (n_cells,) an integer label per cell.
    Displacement unknown 3 * node + component, with the vertices first among the nodes (the order
    of scikit-fem); pressure unknowns follow, numbered tissue by tissue.
    """

    points: Array
    cells: Integers
    tissue: NDArray[np.int8]

    @cached_property
    def scalar(self) -> Basis:
        """The scalar quadratic basis; degree 2 is exact for products of its gradients."""
        mesh = _Mesh(self.points.T.copy(), self.cells.T.astype(np.int64).copy())
        return Basis(mesh, ElementTetP2(), intorder=2)

    @cached_property
    def nodes(self) -> Integers:
        """Node numbers of each cell (n_cells, 10), in the local order of scikit-fem."""
        return np.asarray(self.scalar.element_dofs.T, dtype=np.int64)

    @cached_property
    def node_points(self) -> Array:
        """Positions of the nodes (n_nodes, 3): vertices, then edge midpoints."""
        return np.asarray(self.scalar.doflocs.T)

    @cached_property
    def pressures(self) -> Integers:
        """Pressure numbers of each cell (n_cells, 4), counted from zero, apart per tissue."""
        numbers = np.empty_like(self.vertices)
        start = 0
        for label in np.unique(self.tissue):
            inside = self.tissue == label
            vertices, inverse = np.unique(self.vertices[inside], return_inverse=True)
            numbers[inside] = start + inverse.reshape(-1, 4)
            start += len(vertices)
        return numbers

    @cached_property
    def vertices(self) -> Integers:
        """Vertex numbers of each cell (n_cells, 4), in the local order of scikit-fem."""
        return np.asarray(self.scalar.mesh.t.T, dtype=np.int64)

    @cached_property
    def unknowns(self) -> Integers:
        """Unknowns of each cell (n_cells, 34): 30 displacements, then 4 pressures."""
        displacements = (3 * self.nodes[:, :, None] + np.arange(3)).reshape(len(self.nodes), -1)
        return np.hstack([displacements, self.n_displacements + self.pressures])

    @cached_property
    def jacobians(self) -> Array:
        """Gradients (n_cells, 3, 3) 1/mm of the three reference coordinates of each cell."""
        corners = self.points[self.vertices]
        return np.asarray(np.linalg.inv(np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)))

    def shape_gradients(self, places: Array) -> Array:
        """Gradients (10, 3, n) of the quadratic shapes at reference coordinates (3, n)."""
        return np.array([self.scalar.elem.lbasis(places, node)[1] for node in range(10)])

    @property
    def n_nodes(self) -> int:
        """Number of displacement nodes."""
        return int(self.scalar.N)

    @property
    def n_displacements(self) -> int:
        """Number of displacement unknowns."""
        return 3 * self.n_nodes

    @property
    def n_unknowns(self) -> int:
        """Number of displacement and pressure unknowns."""
        return self.n_displacements + int(self.pressures.max()) + 1

    def edge_nodes(self, triangles: Integers) -> Integers:
        """Edge nodes (n_triangles, 3) of vertex triples, on the edges 01, 12 and 02.

        Raises KeyError if a triangle has an edge that is not an edge of the mesh.
        """
        pairs = np.sort(triangles[:, [[0, 1], [1, 2], [0, 2]]], axis=2)
        keys = self._edge_key(*np.moveaxis(pairs, 2, 0))
        edges = np.sort(self.scalar.mesh.edges, axis=0)
        mesh_keys = self._edge_key(edges[0], edges[1])
        order = np.argsort(mesh_keys)
        place = np.minimum(np.searchsorted(mesh_keys, keys, sorter=order), len(mesh_keys) - 1)
        numbers = order[place]
        if not np.array_equal(mesh_keys[numbers], keys):
            raise KeyError("triangles: expected faces of the mesh, received an edge that it lacks")
        return np.asarray(self.scalar.edge_dofs[0][numbers], dtype=np.int64)

    def face_nodes(self, triangles: Integers) -> Integers:
        """All nodes that lie on the given vertex triples, sorted."""
        return np.unique(np.concatenate([triangles.ravel(), self.edge_nodes(triangles).ravel()]))

    def has_faces(self, triangles: Integers) -> Flags:
        """Whether vertex triples (n_triangles, 3) are faces of the mesh."""
        corners = self.vertices[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]]
        faces, keys = (self._face_key(f) for f in (corners.reshape(-1, 3), triangles))
        return np.isin(keys, faces)

    def _face_key(self, faces: Integers) -> Integers:
        """Compute a unique integer (n,) per vertex triple; 64 bits suffice below 2e6 points."""
        low, middle, high = np.sort(faces, axis=1).astype(np.int64).T
        return self._edge_key(self._edge_key(low, middle), high)

    def _edge_key(self, low: Integers, high: Integers) -> Integers:
        return low.astype(np.int64) * len(self.points) + high


@dataclass(frozen=True)
class Trace:
    """Quadratic displacements and linear pressures on a set of surface triangles.

    Quadrature of degree 5 on each triangle: weights (n_tri, n_q) mm², places (n_tri, n_q, 3) mm on
    the flat facets, linear (3, n_q) and quadratic (6, n_q) shape functions, slopes (2, 6, n_q) of
    the latter along the sides (n_tri, 2, 3) mm from the first vertex to the other two; nodes
    (n_tri, 6) of the displacement space (three vertices, then the edges 01, 12, 02).
    """

    triangles: Integers
    nodes: Integers
    weights: Array
    places: Array
    linear: Array
    quadratic: Array
    slopes: Array
    sides: Array

    @cached_property
    def hats(self) -> Array:
        """Weights times the linear shape functions (n_tri, 3, n_q) mm²."""
        return self.linear[None] * self.weights[:, None, :]


def trace(space: Space, triangles: Integers) -> Trace:
    """Return the traces of the space on vertex triples (n_tri, 3)."""
    reference = MeshTri.init_refdom()
    quadratic = Basis(reference, ElementTriP2(), intorder=5)
    linear = Basis(reference, ElementTriP1(), intorder=5)
    shapes = np.array([np.asarray(f[0])[0] for f in linear.basis])
    corners = space.points[triangles]
    sides = corners[:, 1:] - corners[:, :1]
    return Trace(
        triangles=triangles,
        nodes=np.hstack([triangles, space.edge_nodes(triangles)]),
        weights=triangle_areas(corners)[:, None] * 2 * quadratic.dx[0][None, :],
        places=np.einsum("iq,tid->tqd", shapes, corners),
        linear=shapes,
        quadratic=np.array([np.asarray(f[0])[0] for f in quadratic.basis]),
        slopes=np.array([f[0].grad[:, 0] for f in quadratic.basis]).swapaxes(0, 1),
        sides=sides,
    )

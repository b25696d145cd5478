"""Part of the suite `fem`: patch tests, manufactured solutions and inf-sup constants."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.fem.element_kinds import OURS, Kind, assembled
from fefinger.validation.problems.grids import box
from scipy.linalg import eigh

from fefinger.fem.elements.assembly import Elastic, stiffness
from fefinger.fem.elements.probe import strain_at
from fefinger.fem.elements.spaces import Space, trace
from fefinger.fem.linalg.system import factor
from fefinger.support.arrays import Array
from fefinger.support.tensors import tensor_from_voigt


RATIOS = (0.3, 0.45, 0.49, 0.499, 0.5)
CELLS = (4, 6, 9)
GRADIENT = np.array([[0.1, 0.2, -0.3], [0.4, -0.3, 0.1], [0.05, 0.6, 0.2]])
"""Of a linear displacement, without change of volume, so that nu = 0.5 can have it too."""

MEASURES = {
    "displacement": (3.0, 0.3, 0.003),
    "strain": (2.0, 0.3, 0.03),
    "mean stress": (2.5, 0.6, 0.02),  # 2 in theory, more on meshes as even as these
}
"""Expected order with its tolerance, and the largest relative L2 error on 9³ boxes."""

UNSTABLE = Kind("P1-P1", 1, "vertex")
MANUFACTURED = (
    "manufactured: u = curl(a) + grad(b) / K, so that the mean stress is laplace(b) at nu = 0.5 too"
)


def cube(cells: int) -> Space:
    """Return a unit cube of `cells`³ boxes of 6 tetrahedra."""
    line = np.linspace(0, 1, cells + 1)
    return box(line, line, line)


def shaken(cells: int) -> Space:
    """Return a cube whose inner points are moved by up to 0.15 of a box."""
    even = cube(cells)
    points = even.points.copy()
    inside = ((points > 0) & (points < 1)).all(axis=1)
    shake = np.random.default_rng(3).uniform(-0.15, 0.15, points.shape) / cells
    points[inside] += shake[inside]
    return Space(points, even.cells, even.tissue)


@cache
def patch_error(poisson: float) -> float:
    """Return the largest error of the strain of a linear displacement in perturbed cells."""
    space = shaken(3)
    places = space.node_points
    fixed = np.flatnonzero(np.repeat(((places == 0) | (places == 1)).any(axis=1), 3))
    system = factor(space, stiffness(space, {1: Elastic(7.0, poisson)}), fixed)
    prescribed = (places @ GRADIENT.T).ravel()[fixed]
    answer = system.solve(np.zeros(space.n_unknowns), prescribed)
    points = np.random.default_rng(0).uniform(0.05, 0.95, (20, 3))
    computed = tensor_from_voigt((strain_at(space, points) @ answer).reshape(-1, 6))
    return float(np.abs(computed - (GRADIENT + GRADIENT.T) / 2).max())


@dataclass(frozen=True)
class Manufactured:
    """The exact solution and what loads it, at points (n, 3) of the unit cube."""

    elastic: Elastic

    def displacement(self, points: Array) -> Array:
        """Return u (n, 3)."""
        s, c = np.sin(np.pi * points), np.cos(np.pi * points)
        swirl = np.stack([s[:, i] * c[:, i - 1] * c[:, i - 2] for i in range(3)], axis=1)
        return swirl * [1, 1, -2] + self._soft * swirl / np.pi

    def gradient(self, points: Array) -> Array:
        """Return du_i / dx_j (n, 3, 3)."""
        s, c = np.sin(np.pi * points), np.cos(np.pi * points)
        gradients = np.empty((len(points), 3, 3))
        for i in range(3):
            for j in range(3):
                other = 3 - i - j
                gradients[:, i, j] = (
                    c.prod(axis=1) if i == j else -s[:, i] * s[:, j] * c[:, other]
                ) * np.pi
        return gradients * (np.array([1, 1, -2]) + self._soft / np.pi)[:, None]

    def mean_stress(self, points: Array) -> Array:
        """Return the mean stress (n,), K div u."""
        return 3 * self.elastic.shear * np.cos(np.pi * points).prod(axis=1)

    def stress(self, points: Array) -> Array:
        """Return the stress (n, 3, 3)."""
        gradient = self.gradient(points)
        strain = (gradient + gradient.transpose(0, 2, 1)) / 2
        trace = np.einsum("nii->n", strain)[:, None, None] * np.eye(3)
        mean = self.mean_stress(points)[:, None, None] * np.eye(3)
        return 2 * self.elastic.shear * (strain - trace / 3) + mean

    def load(self, points: Array) -> Array:
        """Return -div of the stress (n, 3)."""
        s, c = np.sin(np.pi * points), np.cos(np.pi * points)
        swirl = np.stack([s[:, i] * c[:, i - 1] * c[:, i - 2] for i in range(3)], axis=1)
        mu = self.elastic.shear
        turning = 3 * np.pi**2 * mu * swirl * [1, 1, -2]
        return turning + (1 + 4 * mu / 3 * self.elastic.compressibility) * 3 * mu * np.pi * swirl

    @property
    def _soft(self) -> float:
        """Size mu / K of grad(b) / K."""
        return self.elastic.shear * self.elastic.compressibility


@cache
def errors(poisson: float, cells: int) -> dict[str, float]:
    """Return the relative L2 errors by the names of MEASURES, at the quadrature points.

    The displacement is prescribed on five faces of the cube, the traction on the sixth.
    """
    exact, space = Manufactured(Elastic(1.0, poisson)), cube(cells)
    tissues = {1: exact.elastic}
    places = space.node_points
    held = (places[:, :2] == 0) | (places[:, :2] == 1)
    fixed = np.flatnonzero(np.repeat(held.any(axis=1) | (places[:, 2] == 0), 3))
    system = factor(space, stiffness(space, tissues), fixed)
    prescribed = exact.displacement(places).ravel()[fixed]
    unknowns = system.solve(_loads(space, exact), prescribed)
    basis = space.scalar
    shapes = np.array([np.asarray(f[0])[0] for f in basis.basis])
    slopes = np.array([f[0].grad for f in basis.basis])
    points = np.moveaxis(np.asarray(basis.global_coordinates()), 0, 2).reshape(-1, 3)
    moved = unknowns[: space.n_displacements].reshape(-1, 3)[space.nodes]
    gradient = np.einsum("eki,kjeq->eqij", moved, slopes).reshape(-1, 3, 3)
    pressures = unknowns[space.n_displacements :][space.pressures] * exact.elastic.shear
    # At the quadrature points the linear shapes are the barycentric coordinates.
    linear = np.linalg.solve(_corner_matrix(space), _lifted(points, len(space.cells)))
    mean = np.einsum("ek,ekq->eq", pressures, linear).ravel()
    weight = basis.dx.ravel()
    return {
        "displacement": _relative(
            np.einsum("eki,kq->eqi", moved, shapes).reshape(-1, 3),
            exact.displacement(points),
            weight,
        ),
        "strain": _relative(_symmetric(gradient), _symmetric(exact.gradient(points)), weight),
        "mean stress": _relative(mean, exact.mean_stress(points), weight),
    }


def order(name: str, poisson: float) -> float:
    """Return the fitted order of an error over CELLS."""
    values = [errors(poisson, cells)[name] for cells in CELLS]
    return float(-np.polyfit(np.log(CELLS), np.log(values), 1)[0])


@cache
def inf_sup(kind: Kind, cells: int) -> float:
    """Return the inf-sup constant of a kind of element on a cube that is held all around.

    The least but one eigenvalue, since the mean stress is known up to a constant there, of
    B A^-1 B' against the mass of the pressures; a shear modulus of 1.
    """
    space, elastic = cube(cells), Elastic(2.6, 0.3)
    discrete = assembled(kind, space, {1: elastic})
    n = discrete.n_displacements
    whole = discrete.matrix.toarray()
    nodes = space.node_points[: n // 3]
    free = np.flatnonzero(np.repeat(((nodes > 0) & (nodes < 1)).all(axis=1), 3))
    divergence = whole[n:][:, free]
    mass = -whole[n:, n:] / elastic.compressibility
    schur = divergence @ np.linalg.solve(whole[np.ix_(free, free)], divergence.T)
    return float(np.sqrt(max(0.0, eigh(schur, mass, eigvals_only=True)[1])))


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield patch tests, orders and errors for every Poisson ratio, and inf-sup constants."""
    for nu in (0.49,) if quick else RATIOS:
        patch = f"patch test, nu {nu:g}: strain in randomly perturbed cells"
        linear = "a linear displacement"
        yield Case(patch, partial(patch_error, nu), Expected(0.0, 1e-9), linear, reason="rounding")
        for name, (expected, spread, limit) in MEASURES.items():
            title = f"manufactured, nu {nu:g}: order of {name}"
            measure = partial(order, name, nu)
            reason = "fitted over 4, 6 and 9 boxes along an edge"
            yield Case(title, measure, Expected(expected, spread), MANUFACTURED, reason=reason)
            title = f"manufactured, nu {nu:g}: {name} on 9³ boxes"
            measure = partial(lambda q, n: errors(n, CELLS[-1])[q], name, nu)
            reason = "relative L2 error: an order alone may lead to a wrong answer"
            yield Case(title, measure, Expected(0.0, limit), MANUFACTURED, reason=reason)
    yield from _stability(3 if quick else 4)


def _stability(cells: int) -> Iterator[Case]:
    why = "Boffi, Brezzi and Fortin 2013, 8.8: bounded from below"
    yield Case(
        f"inf-sup constant on {cells}³ boxes over that on {cells - 1}³, Taylor-Hood",
        lambda: inf_sup(OURS, cells) / inf_sup(OURS, cells - 1),
        Expected(1.0, 0.25),
        why,
        reason="does not fall with the mesh",
    )
    name = f"inf-sup constant on {cells}³ boxes, P1-P1, which is unstable"
    source = "pressures that no displacement sees"
    reason = "shows that the measure can fail"
    yield Case(name, lambda: inf_sup(UNSTABLE, cells), Expected(0.0, 1e-6), source, reason=reason)


def _loads(space: Space, exact: Manufactured) -> Array:
    """Return the loads (n_unknowns,) of the body and of the face z = 1."""
    basis = space.scalar
    shapes = np.array([np.asarray(f[0])[0] for f in basis.basis])
    points = np.moveaxis(np.asarray(basis.global_coordinates()), 0, 2)
    body = exact.load(points.reshape(-1, 3)).reshape(points.shape)
    loads = np.zeros((space.n_nodes, 3))
    np.add.at(loads, space.nodes, np.einsum("kq,eqi,eq->eki", shapes, body, basis.dx))
    facets = np.asarray(basis.mesh.facets.T, dtype=np.int64)
    face = trace(space, facets[(space.points[facets][:, :, 2] == 1).all(axis=1)])
    pull = exact.stress(face.places.reshape(-1, 3))[:, :, 2].reshape(face.places.shape)
    np.add.at(loads, face.nodes, np.einsum("kq,tqi,tq->tki", face.quadratic, pull, face.weights))
    return np.concatenate([loads.ravel(), np.zeros(space.n_unknowns - space.n_displacements)])


def _corner_matrix(space: Space) -> Array:
    """Return (n_cells, 4, 4): ones above the coordinates of the corners, one column each."""
    corners = np.moveaxis(space.points[space.vertices], 1, 2)
    return np.concatenate([np.ones((len(corners), 1, 4)), corners], axis=1)


def _lifted(points: Array, n_cells: int) -> Array:
    """Return (n_cells, 4, n_q): ones above the coordinates of the points."""
    columns = np.moveaxis(points.reshape(n_cells, -1, 3), 1, 2)
    return np.concatenate([np.ones((n_cells, 1, columns.shape[2])), columns], axis=1)


def _symmetric(gradient: Array) -> Array:
    return (gradient + gradient.transpose(0, 2, 1)) / 2


def _relative(computed: Array, exact: Array, weight: Array) -> float:
    """Return the L2 norm of the difference over the norm of `exact`."""
    axes = tuple(range(1, computed.ndim))
    square = np.sum((computed - exact) ** 2, axis=axes), np.sum(exact**2, axis=axes)
    return float(np.sqrt(weight @ square[0] / (weight @ square[1])))

"""Suite `elements`: Taylor-Hood tetrahedra against a manufactured solution, for every nu."""

from collections.abc import Iterator
from functools import cache

import numpy as np
from fefinger.validation.case import Case
from numpy.typing import NDArray

from fefinger.fem.forms import Elastic, stiffness
from fefinger.fem.grids import box
from fefinger.fem.solve import factor


Array = NDArray[np.float64]

RATIOS = (0.3, 0.49, 0.5)
CELLS = (2, 4, 8)
SOURCE = "manufactured: u = curl of a potential, so that div u = 0 and the load is -mu laplace(u)"


def exact(points: Array) -> Array:
    """Return the displacement (n, 3) at points (n, 3); its load is 3 pi² mu times itself."""
    s, c = np.sin(np.pi * points), np.cos(np.pi * points)
    return np.stack(
        [
            s[:, 0] * c[:, 1] * c[:, 2],
            c[:, 0] * s[:, 1] * c[:, 2],
            -2 * c[:, 0] * c[:, 1] * s[:, 2],
        ],
        axis=1,
    )


@cache
def error(poisson: float, cells: int) -> float:
    """Return the L2 error of the displacement in a unit cube of `cells`³ boxes of 6 cells."""
    elastic = Elastic(1.0, poisson)
    line = np.linspace(0, 1, cells + 1)
    space = box(line, line, line)
    places = space.node_points
    outer = (np.isclose(places, 0) | np.isclose(places, 1)).any(axis=1)
    fixed = np.flatnonzero(np.repeat(outer, 3))
    system = factor(space, stiffness(space, {1: elastic}), fixed)
    basis = space.scalar
    shapes = np.array([np.asarray(f[0])[0] for f in basis.basis])
    quadrature = np.asarray(basis.global_coordinates())
    truth = exact(quadrature.reshape(3, -1).T).T.reshape(quadrature.shape)
    load = 3 * np.pi**2 * elastic.shear * np.einsum("iq,ceq,eq->eic", shapes, truth, basis.dx)
    loads = np.zeros(space.n_unknowns)
    np.add.at(loads[: space.n_displacements].reshape(-1, 3), space.nodes, load)
    answer = system.solve(loads, exact(places).ravel()[fixed])
    at_nodes = answer[: space.n_displacements].reshape(-1, 3)
    field = np.einsum("iq,eic->ceq", shapes, at_nodes[space.nodes])
    return float(np.sqrt(np.sum((field - truth) ** 2 * basis.dx)))


def order(poisson: float) -> float:
    """Return the fitted order of convergence over CELLS."""
    errors = [error(poisson, cells) for cells in CELLS]
    return float(-np.polyfit(np.log(CELLS), np.log(errors), 1)[0])


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the order and the last error for every Poisson ratio."""
    for nu in RATIOS[1:2] if quick else RATIOS:
        yield Case(
            "elements",
            f"order of displacement, nu {nu:g}",
            lambda n=nu: order(n),
            3.0,
            0.35,
            "1",
            SOURCE,
        )
        yield Case(
            "elements",
            f"displacement error on 8³ boxes, nu {nu:g}",
            lambda n=nu: error(n, 8),
            0.0,
            2.5e-3,
            "mm",
            SOURCE,
        )

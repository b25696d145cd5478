"""Cost and error of other tetrahedral elements on the same meshes, for comparison only.

`fefinger.fem` has one element, Taylor-Hood with a pressure per tissue; here it is one of seven. Run
as `python -m fefinger.validation.fem.element_kinds reports [PART ...]`; all of PARTS take about six
minutes of CPU. The rows of parts that are not named are kept.
"""

import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from fefinger.validation.fem import exact as fem_exact
from fefinger.validation.fem import hertz
from fefinger.validation.problems.quarter import Exact, Pressed, Quarter, turned
from fefinger.validation.provenance import save, saved
from scipy import sparse

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.probe import strain_at
from fefinger.fem.elements.spaces import Space
from fefinger.fem.linalg import multifrontal
from fefinger.fem.linalg.dissection import dissect
from fefinger.support.arrays import Array, Integers
from fefinger.support.processes import one_thread
from fefinger.support.tensors import tensor_from_voigt
from fefinger.theory.contact.indentation import subsurface_field
from fefinger.theory.contact.stack import Stack


REPORT = "elements.json"
RATIOS = (0.3, 0.49, 0.4999)
PARTS = (*(f"Hertz/{nu:g}" for nu in RATIOS), "stack")
LEVELS_OF_STACK = (fem_exact.EVERYDAY, fem_exact.FINE)
INTERFACE_DEPTHS = (0.6, 0.9, 1.1, 1.4)  # mm, the interface is at 1 mm
EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))  # of the quadratics, after the corners
# Four points, exact for the squares of linear functions.
INNER, OUTER = (5 + 3 * np.sqrt(5)) / 20, (5 - np.sqrt(5)) / 20
RULE = np.full((4, 4), OUTER) + (INNER - OUTER) * np.eye(4)

# Integrals over a cell of unit volume of the bubble 256 l0 l1 l2 l3 and of its derivatives.
BUBBLE = 256 * 6 / 5040
BUBBLE_SLOPES = 256**2 * (np.full((4, 4), 24.0) + 24.0 * np.eye(4)) / 362880


@dataclass(frozen=True)
class Kind:
    """An element: degree of the displacement, where pressures sit, and what makes it stable."""

    name: str
    degree: Literal[1, 2]
    pressure: Literal["", "vertex", "tissue", "cell"]
    stable: Literal["", "bubble", "projection"] = ""


OURS = Kind("Taylor-Hood, a pressure per tissue", 2, "tissue")
KINDS = (
    OURS,
    Kind("Taylor-Hood, one pressure", 2, "vertex"),
    Kind("P2-P0", 2, "cell"),
    Kind("P2", 2, ""),
    Kind("MINI", 1, "vertex", "bubble"),
    Kind("P1-P1 stabilized", 1, "vertex", "projection"),
    Kind("P1", 1, ""),
)


@dataclass(frozen=True)
class Discrete:
    """A body in some kind of element: the matrix (n, n), and the unknowns of each cell."""

    matrix: sparse.csr_matrix
    unknowns: Integers
    n_displacements: int


def assembled(kind: Kind, space: Space, tissues: Mapping[int, Elastic]) -> Discrete:
    """Return the body of `space` in elements of another kind."""
    nodes = space.nodes if kind.degree == 2 else space.vertices
    n_displacements = 3 * (int(nodes.max()) + 1)
    displacements = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)
    pressures = n_displacements + _pressures(kind, space)
    unknowns = np.hstack([displacements, pressures])
    blocks = _blocks(kind, space, tissues)
    rows = np.broadcast_to(unknowns[:, :, None], blocks.shape).ravel()
    columns = np.broadcast_to(unknowns[:, None, :], blocks.shape).ravel()
    n = int(unknowns.max()) + 1
    matrix = sparse.coo_matrix((blocks.ravel(), (rows, columns)), shape=(n, n)).tocsr()
    return Discrete(matrix, unknowns, n_displacements)


def _pressures(kind: Kind, space: Space) -> Integers:
    """Return the pressure numbers (n_cells, 0, 1 or 4) of each cell."""
    if kind.pressure == "cell":
        return np.arange(len(space.vertices))[:, None]
    if kind.pressure == "tissue":
        return space.pressures
    return space.vertices if kind.pressure else space.vertices[:, :0]


def _blocks(kind: Kind, space: Space, tissues: Mapping[int, Elastic]) -> Array:
    """Return the element matrices (n_cells, n_local, n_local)."""
    corners = space.points[space.vertices]
    sides = np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)
    inverse = np.linalg.inv(sides)
    slopes = np.concatenate([-inverse.sum(axis=1, keepdims=True), inverse], axis=1)
    volume = np.abs(np.linalg.det(sides)) / 6
    shear = np.array([tissues[int(k)].shear for k in space.tissue])
    soft = np.array([tissues[int(k)].compressibility for k in space.tissue])
    gradients = np.einsum("iqk,eka->eiqa", _derivatives(kind), slopes)
    weight = (volume[:, None] / len(RULE)) * np.ones(len(RULE))
    outer = np.einsum("eiqa,ejqb,eq->eiajb", gradients, gradients, weight, optimize=True)
    stiff = outer.transpose(0, 1, 4, 3, 2) - (2 / 3) * outer
    for c in range(3):
        stiff[:, :, c, :, c] += np.einsum("eiaja->eij", outer)
    stiff = stiff * shear[:, None, None, None, None]
    if not kind.pressure:
        stiff += outer / soft[:, None, None, None, None]
    size = 3 * gradients.shape[1]
    a = stiff.reshape(len(volume), size, size)
    if not kind.pressure:
        return a
    # Pressures in units of the largest shear modulus, so that all blocks have like size.
    scale = max(one.shear for one in tissues.values())
    values = RULE.T if kind.pressure != "cell" else np.ones((1, len(RULE)))
    b = scale * np.einsum("kq,eiqa,eq->ekia", values, gradients, weight, optimize=True)
    b = b.reshape(len(volume), len(values), size)
    mass = np.einsum("kq,lq,eq->ekl", values, values, weight) * soft[:, None, None]
    c = -(scale**2) * (mass + _stabilizing(kind, slopes, volume, shear))
    return np.concatenate(
        [np.concatenate([a, b.transpose(0, 2, 1)], 2), np.concatenate([b, c], 2)], 1
    )


def _derivatives(kind: Kind) -> Array:
    """Return derivatives (n_local, 4 points, 4) of the shapes by the barycentric coordinates."""
    corners = np.repeat(np.eye(4)[:, None], len(RULE), axis=1)
    if kind.degree == 1:
        return corners
    corners = corners * (4 * RULE.T - 1)[:, :, None]
    middles = np.zeros((len(EDGES), len(RULE), 4))
    for edge, (i, j) in enumerate(EDGES):
        middles[edge, :, i], middles[edge, :, j] = 4 * RULE[:, j], 4 * RULE[:, i]
    return np.concatenate([corners, middles])


def _stabilizing(kind: Kind, slopes: Array, volume: Array, shear: Array) -> Array | float:
    """Stabilization of the pressure block (n_cells, 4, 4), added to the compressibility.

    The bubble, eliminated from its cell (Arnold, Brezzi and Fortin, Calcolo 21:337, 1984), or the
    departure of the pressure from its mean (Bochev and Dohrmann, SIAM J. Numer. Anal. 44:82, 2006).
    """
    if kind.stable == "projection":
        spread = (np.ones((4, 4)) + np.eye(4)) / 20 - 1 / 16
        return np.asarray((volume / shear)[:, None, None] * spread)
    if kind.stable == "bubble":
        product = np.einsum("kl,eka,elb->eab", BUBBLE_SLOPES, slopes, slopes)
        whole = np.einsum("eaa->e", product)[:, None, None] * np.eye(3)
        bubble_stiffness = (shear * volume)[:, None, None] * (whole + product / 3)
        pull = BUBBLE * volume[:, None, None] * slopes
        return np.asarray(pull @ np.linalg.solve(bubble_stiffness, pull.transpose(0, 2, 1)))
    return 0.0


def embedding(kind: Kind, space: Space) -> sparse.csr_matrix:
    """Return the quadratic displacements (3 n_nodes, n) of the displacements of a kind."""
    if kind.degree == 2:
        return sparse.identity(space.n_displacements, format="csr")
    count = int(space.vertices.max()) + 1
    rows, columns = [np.arange(count)], [np.arange(count)]
    middles, first = np.unique(space.nodes[:, 4:].ravel(), return_index=True)
    for end in (0, 1):
        corners = space.vertices[:, [edge[end] for edge in EDGES]].ravel()
        rows.append(middles)
        columns.append(corners[first])
    shares = np.concatenate([np.ones(count), np.full(2 * len(middles), 0.5)])
    where = (np.concatenate(rows), np.concatenate(columns))
    scalar = sparse.csr_matrix((shares, where), shape=(space.n_nodes, count))
    return sparse.kron(scalar, sparse.identity(3), format="csr")


@one_thread
def solved(kind: Kind, body: Quarter, depth: float) -> tuple[Pressed, Array, float, int]:
    """Return the contact, the quadratic displacements (n,), the CPU seconds and the unknowns.

    The seconds are of assembly, factor, loads and contact, not of the mesh and its numbering.
    """
    space, patch = body.space, body.patch
    _ = space.pressures  # numbers the unknowns, which all kinds need
    wide = embedding(kind, space)
    started = time.process_time()
    discrete = assembled(kind, space, body.tissues)
    n = discrete.matrix.shape[0]
    held = body.held.copy()
    held[:, :2] |= space.node_points[:, :2] == 0
    is_free = np.ones(n, dtype=bool)
    is_free[: discrete.n_displacements] = ~held.ravel()[: discrete.n_displacements]
    free, fixed = np.flatnonzero(is_free), np.flatnonzero(~is_free)
    reduced = discrete.matrix[free][:, free].tocsr()
    number = np.where(is_free, np.cumsum(is_free) - 1, -1)
    centers = space.points[space.vertices].mean(axis=1)
    inside = int(is_free[: discrete.n_displacements].sum())
    dissection = dissect(number[discrete.unknowns], centers, inside)
    factor = multifrontal.factor(reduced, dissection)
    loads = (wide.T @ patch.loads[: space.n_displacements]).toarray()
    answer = np.zeros((n, loads.shape[1] + 1))
    answer[fixed, -1] = body.prescribed.ravel()[fixed]
    right = np.zeros_like(answer)
    right[: len(loads), :-1] = loads
    right -= discrete.matrix @ answer
    answer[free] = factor.solve(right[free])
    moved = loads.T @ answer[: len(loads)]
    pressure = Complementarity((moved[:, :-1] + moved[:, :-1].T) / 2).solve(
        patch.gap - depth * patch.projected + moved[:, -1]
    )
    displacement = wide @ (answer[: len(loads)] @ np.append(pressure, 1.0))
    return Pressed(body, pressure), displacement, time.process_time() - started, len(free)


def hertz_row(kind: Kind, poisson: float, level: int) -> dict[str, Any]:
    """Return the errors in % and the cost of a kind in Hertz contact."""
    truth = hertz.hertz(poisson)
    body = hertz.body(poisson, level)
    a = truth.contact_radius
    r, z = (a * axis.ravel() for axis in np.meshgrid(hertz.OFFSETS, hertz.DEPTHS))
    turn = np.array([np.cos(hertz.AZIMUTH), np.sin(hertz.AZIMUTH)])
    points = np.column_stack([np.multiply.outer(r, turn), z])
    return _row(kind, body, hertz.exact(truth), points, turned(truth.strain(r, z), turn))


def stack_row(kind: Kind, level: int) -> dict[str, Any]:
    """Return the same for skin on softer tissue, with the strain on both sides of the interface."""
    solution = fem_exact.stack(LEVELS_OF_STACK[level])
    truth = fem_exact.stack_contact()
    a = truth.contact_radius
    r, z = (axis.ravel() for axis in np.meshgrid(a * np.array([0, 0.5, 1.0]), INTERFACE_DEPTHS))
    turn = np.array([np.cos(hertz.AZIMUTH), np.sin(hertz.AZIMUTH)])
    assert isinstance(truth.body, Stack)
    strain = turned(subsurface_field(truth.body, [truth], r, z=z).strain[0], turn)
    points = np.column_stack([np.multiply.outer(r, turn), z])
    return _row(kind, solution.body, solution.exact, points, strain)


def _row(kind: Kind, body: Quarter, exact: Exact, points: Array, strain: Array) -> dict[str, Any]:
    pressed, displacement, seconds, unknowns = solved(kind, body, exact.depth)
    full = np.zeros(body.space.n_unknowns)
    full[: len(displacement)] = displacement
    computed = tensor_from_voigt((strain_at(body.space, points) @ full).reshape(-1, 6))
    departure = np.linalg.norm(computed - strain, axis=(1, 2))
    size = np.linalg.norm(strain, axis=(1, 2)).max()
    peak = float(exact.pressure(np.array(0.0), np.array(0.0)))
    return {
        "nodes": body.space.n_nodes if kind.degree == 2 else len(body.space.points),
        "unknowns": unknowns,
        "cpu_s": round(seconds, 3),
        "force_%": 100 * (pressed.force / exact.force - 1),
        "peak_%": 100 * (float(pressed.pressure.max()) / peak - 1),
        "pressure_%": 100 * pressed.pressure_error(exact, 1.0),
        "strain_%": 100 * float(np.sqrt(np.mean(departure**2)) / size),
    }


def rows_of(part: str) -> list[dict[str, Any]]:
    """Return the rows of every kind on every mesh of one of PARTS."""
    case, _, ratio = part.partition("/")
    if case == "stack":
        return [
            {"case": case, "poisson": 0.49, "level": level, "element": kind.name}
            | stack_row(kind, level)
            for kind in KINDS
            for level in range(len(LEVELS_OF_STACK))
        ]
    return [
        {"case": case, "poisson": float(ratio), "level": level, "element": kind.name}
        | hertz_row(kind, float(ratio), level)
        for kind in KINDS
        for level in range(len(hertz.LEVELS))
    ]


def part_of(row: dict[str, Any]) -> str:
    """Part, of PARTS, that a row belongs to."""
    return "stack" if row["case"] == "stack" else f"Hertz/{row['poisson']:g}"


def report(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the report on those rows, in the order of PARTS."""
    return {
        "about": (
            "errors in % against Hertz and the exact stack (skin 100 kPa 1 mm, 34 kPa 4 mm, bone); "
            "strain is RMS over the largest; CPU seconds of assembly, factor, loads and contact "
            "with one thread, the same assembly and factor for all kinds"
        ),
        "rows": sorted(rows, key=lambda row: PARTS.index(part_of(row))),
    }


if __name__ == "__main__":
    target, named = Path(sys.argv[1]) / REPORT, sys.argv[2:] or PARTS
    hertz_row(OURS, 0.3, 0)  # compiles
    new_rows = [row for part in named for row in rows_of(part)]
    kept = [row for row in saved(target).get("rows", []) if part_of(row) not in named]
    save(target, report(kept + new_rows))

"""FEBio's input deck of the relaxing hemisphere, on the mesh of this project.

Units are mm, kPa, s and mN. FEBio's uncoupled Mooney-Rivlin law with the pressure model Abaqus is
W = c1 (I1 - 3) + c2 (I2 - 3) + K (J - 1)² / 2, as in `hyperelastic.laws`; its viscoelastic material
relaxes the whole second Piola-Kirchhoff stress by the same recursion as `load_path`.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from typing import Any

import numpy as np
from fefinger.validation.fem.solid import SERIES, TIMES
from fefinger.validation.problems.hemisphere import DEPTH, RADIUS, SPEED, Hemisphere

from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.material import Material
from fefinger.support.arrays import Array, Integers


SWAPPED = [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]  # nodes of a tetrahedron of the other orientation
ELEMENT = "TET10G4"  # four integration points, as here
CONTACT: dict[str, Any] = {
    "laugon": "AUGLAG",
    "tolerance": 0,
    "gaptol": 0.01,  # mm
    "penalty": 10,
    "auto_penalty": 1,
    "search_radius": 5,  # mm; below the size of a facet, contact may be lost
}
STEPPER = {"max_retries": 10, "dtforce": 1}
UPDATES = 20  # of BFGS before the stiffness is factored again: the fastest of 0, 10 and 20
SETTINGS = {"element": ELEMENT, "contact": CONTACT, "BFGS updates": UPDATES}


def tetrahedra(space: Space) -> Integers:
    """Nodes (n_cells, 10) in FEBio's order, counted from 0, all of positive volume."""
    edges = space.points[space.vertices[:, 1:]] - space.points[space.vertices[:, :1]]
    inverted = np.linalg.det(edges) < 0
    return np.where(inverted[:, None], space.nodes[:, SWAPPED], space.nodes)


def skin(ball: Hemisphere) -> Integers:
    """Nodes (n_facets, 6) of the candidate facets, counted from 0, with normals that point out."""
    nodes = ball.contact.on.part.nodes
    corners = ball.space.points[nodes[:, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("fc,fc->f", normals, corners[:, 0] - [0.0, 0.0, RADIUS]) < 0
    return np.where(inward[:, None], nodes[:, [1, 0, 2, 3, 5, 4]], nodes)


def deck(ball: Hemisphere) -> ET.Element:
    """FEBio's input (format 4.0) of the ramp and hold of `fem.solid`; `ball.law` is long-time."""
    root = ET.Element("febio_spec", version="4.0")
    _add(root, "Module", type="solid")
    control = _add(root, "Control")
    steps = {"time_steps": round(TIMES[-1] / TIMES[1]), "step_size": TIMES[1]}
    _fill(control, {"analysis": "STATIC", **steps, "plot_level": "PLOT_NEVER"})
    stepper = _fill(_add(control, "time_stepper", type="default"), STEPPER)
    _add(stepper, "dtmax", 0, lc=2)
    solver = _fill(_add(control, "solver", type="solid"), {"symmetric_stiffness": "symmetric"})
    _add(_add(solver, "qn_method", type="BFGS"), "max_ups", UPDATES)
    _materials(_add(root, "Material"), ball.law)
    _mesh(_add(root, "Mesh"), ball)
    domains = _add(root, "MeshDomains")
    _add(domains, "SolidDomain", name="tissue", mat="tissue", elem_type=ELEMENT)
    _add(domains, "SolidDomain", name="plate", mat="plate")
    boundary = _add(root, "Boundary")
    for axis in "xyz":
        held = _add(boundary, "bc", name=axis, node_set=axis, type="zero displacement")
        _add(held, f"{axis}_dof", 1)
    rigid = _add(root, "Rigid")
    fixed = _add(rigid, "rigid_bc", name="fixed", type="rigid_fixed")
    _fill(fixed, {"rb": "plate"} | {f"R{dof}_dof": 1 for dof in "xyuvw"})
    moved = _add(rigid, "rigid_bc", name="moved", type="rigid_displacement")
    _fill(moved, {"rb": "plate", "dof": "z", "relative": 0})
    _add(moved, "value", DEPTH, lc=1)
    pair = _add(_add(root, "Contact"), "contact", type="sliding-elastic", surface_pair="pair")
    _fill(pair, CONTACT)
    curves, spans = _add(root, "LoadData"), 1.01 * np.diff(TIMES)  # cut at the times of the curve
    _curve(curves, 1, [[0.0, 0.0], [DEPTH / SPEED, 1.0], [2 * TIMES[-1], 1.0]])
    _curve(curves, 2, np.column_stack([TIMES, np.append(spans, spans[-1])]))
    log = _add(_add(root, "Output"), "logfile")
    _add(log, "rigid_body_data", 2, data="Fz", file="force.txt")
    return root


def _materials(parent: ET.Element, law: Material) -> None:
    tissue = _add(parent, "material", id=1, name="tissue", type="viscoelastic")
    ratios = SERIES.weights[1:] / SERIES.weights[0]
    for number, (ratio, rate) in enumerate(zip(ratios, SERIES.rates, strict=True), 1):
        _fill(tissue, {f"g{number}": ratio, f"t{number}": 1 / rate})
    elastic = _add(tissue, "elastic", type="Mooney-Rivlin")
    _fill(elastic, dict(zip(("c1", "c2"), law.at_rest, strict=True)))
    _fill(elastic, {"k": 1 / law.compressibility, "pressure_model": "Abaqus"})
    _fill(_add(parent, "material", id=2, name="plate", type="rigid body"), {"density": 1})


def _mesh(parent: ET.Element, ball: Hemisphere) -> None:
    """Write the nodes, the tetrahedra, the plate of one brick, and their sets and surfaces."""
    space, cells = ball.space, tetrahedra(ball.space)
    square = np.array([[-1, -1], [2, -1], [2, 2], [-1, 2]]) * RADIUS
    plate = np.vstack([np.insert(square, 2, z, axis=1) for z in (-1.0, 0.0)])
    _rows(_add(parent, "Nodes", name="all"), "node", np.vstack([space.node_points, plate]))
    _rows(_add(parent, "Elements", type="tet10", name="tissue"), "elem", cells + 1)
    brick = _add(parent, "Elements", type="hex8", name="plate")
    _add(brick, "elem", space.n_nodes + np.arange(1, 9), id=len(cells) + 1)
    for axis, held in zip("xyz", ball.held.T, strict=True):
        _add(parent, "NodeSet", np.flatnonzero(held) + 1, name=axis)
    _rows(_add(parent, "Surface", name="skin"), "tri6", skin(ball) + 1)
    _rows(_add(parent, "Surface", name="face"), "quad4", space.n_nodes + np.array([[5, 6, 7, 8]]))
    _fill(_add(parent, "SurfacePair", name="pair"), {"primary": "skin", "secondary": "face"})


def _add(parent: ET.Element, tag: str, value: Any = "", **attributes: object) -> ET.Element:
    element = ET.SubElement(parent, tag, {name: str(text) for name, text in attributes.items()})
    numbers = np.atleast_1d(value).tolist()
    element.text = ",".join(map(str, numbers))
    return element


def _fill(parent: ET.Element, values: Mapping[str, Any]) -> ET.Element:
    for tag, value in values.items():
        _add(parent, tag, value)
    return parent


def _rows(parent: ET.Element, tag: str, rows: Array | Integers) -> None:
    for number, row in enumerate(rows, 1):
        _add(parent, tag, row, id=number)


def _curve(parent: ET.Element, number: int, points: Any) -> None:
    curve = _add(parent, "load_controller", id=number, type="loadcurve")
    _add(curve, "interpolate", "LINEAR")
    rows = _add(curve, "points")
    for point in points:
        _add(rows, "pt", point)

"""The reference press: a small flat press of the same finger that scales strain to displacement.

At small strain, and at finite strain with the measure of `solid`.
"""

import numpy as np

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact.deformed_gap import contact_surface
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.probe import recovered_gradient_at, recovered_strain_at
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.fem.hyperelastic.load_path import LoadPath, StressHistory, follow
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.mechanics.press import depth_table, placement
from fefinger.mechanics.press.problem import REACH, Press, ReferencePlate, SolutionMethod
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.neural.drives import Reference
from fefinger.results.records import Sites
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import ConvergenceError
from fefinger.support.tensors import logarithmic, tensor_from_voigt


def reference_press(
    body: Solid, plate: ReferencePlate, method: SolutionMethod, reduced: Reduced | None = None
) -> Reference:
    """Return the strain at the sites under the standard plate, at a small depth.

    `reduced`: the body under that plate, with its strain there, if that is available.
    """
    central = plate.sites
    if reduced is None:
        reach = 2 * REACH * REFERENCE_DEPTH
        candidates = patch(body.space, body.pad, body.normals, plate.obstacle, reach)
        probe = recovered_strain_at(body.space, central.points, body.planes)
        reduced = method.reduce(body, candidates, probe)
    free = reduced.patch.gap - REFERENCE_DEPTH * reduced.patch.projected
    pressure = Complementarity(reduced.flexibility).solve(free)
    check_border(pressure, reduced.patch.border)
    strain = tensor_from_voigt((reduced.strain_operator @ pressure).reshape(-1, 6))
    return Reference(REFERENCE_DEPTH, central.types, central.normals, strain)


def check_border(pressure: Array, border: Flags) -> None:
    """Raise ConvergenceError if the plate touches candidate vertices at their `border`."""
    if (pressure[border] > 0).any():
        message = (
            "reference press: expected contact inside its candidate vertices, but it left them, as "
            "if the pad was much flatter than a fingertip; check the shape of the finger"
        )
        raise ConvergenceError(message)


def reference_of(press: Press, reduced: Reduced, deepest: float) -> Reference | None:
    """Solve the reference press where one is wanted, on `reduced` if that is of the same plate.

    `deepest` mm is how deep the press itself went: its patch reaches no further.
    """
    if press.reference is None or press.sites is None:
        return None
    same = press.standard and deepest >= REFERENCE_DEPTH
    same = same and np.array_equal(press.sites.points, press.reference.sites.points)
    return reference_press(press.body, press.reference, press.method, reduced if same else None)


def reference_unknowns(press: Press, elements: Continuum) -> Array:
    """Return the unknowns of the relaxed finger under the standard plate at the reference depth.

    They are read from the table of that plate where one is at hand. ConvergenceError if the plate
    finds no equilibrium, or its contact leaves the candidates.
    """
    body, reach = press.body, 2 * REACH * REFERENCE_DEPTH
    table = depth_table.available(press.finger, STANDARD, press.mesh)
    if table is not None:
        return table.reference(body.space.n_unknowns)
    plate = placement.obstacle(STANDARD, body)
    contact = contact_surface(
        body.space, body.pad, body.normals, plate, reach, spreads=elements.nearly_incompressible
    )
    equilibrium = Equilibrium(elements, contact, press.system)
    states: list[State] = []
    steps = 2  # in which the reference depth is reached; its equilibrium does not depend on them
    path = LoadPath("depth", np.linspace(0, 1, steps + 1), lambda t: REFERENCE_DEPTH * t)
    follow(equilibrium, StressHistory(elements, {}), path, lambda _, state: states.append(state))
    check_border(states[-1].pressure, contact.on.border)
    return states[-1].values


def reference_strain(body: Solid, central: Sites, values: Array) -> Reference:
    """Return the logarithmic strain at central sites for the unknowns (n_unknowns,) of a body."""
    probe = recovered_gradient_at(body.space, central.points, body.planes)
    strain = logarithmic((probe @ values).reshape(-1, 3, 3))
    return Reference(REFERENCE_DEPTH, central.types, central.normals, strain)

"""The reference press of the end organs at finite strain, with the measure of `solid`."""

import numpy as np

from fefinger.fem.body import Solid
from fefinger.fem.contact.deformed_gap import contact_surface
from fefinger.fem.elements.recovery import recovered_gradient_at
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.fem.hyperelastic.load_path import Path, StressHistory, follow
from fefinger.fem.hyperelastic.logarithmic_strain import logarithmic
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.mechanics.press import depth_table_store, placement
from fefinger.mechanics.press.problem import REACH, Press
from fefinger.mechanics.press.reference import check_border
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.neural.reference import Reference
from fefinger.results.records import Sites
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array


STEPS = 2
"""In which the reference depth is reached; its equilibrium does not depend on them."""


def reference_unknowns(press: Press, elements: Continuum) -> Array:
    """Return the unknowns of the relaxed finger under the standard plate at the reference depth.

    They are read from the table of that plate where one is at hand. ConvergenceError if the plate
    finds no equilibrium, or its contact leaves the candidates.
    """
    body, reach = press.body, 2 * REACH * REFERENCE_DEPTH
    table = depth_table_store.at_hand(press.finger, STANDARD, press.mesh)
    if table is not None:
        return table.reference(body.space.n_unknowns)
    plate = placement.obstacle(STANDARD, body)
    contact = contact_surface(
        body.space, body.pad, body.normals, plate, reach, spreads=elements.nearly_incompressible
    )
    equilibrium = Equilibrium(elements, contact, press.system)
    states: list[State] = []
    path = Path("depth", np.linspace(0, 1, STEPS + 1), lambda t: REFERENCE_DEPTH * t)
    follow(equilibrium, StressHistory(elements, {}), path, lambda _, state: states.append(state))
    check_border(states[-1].pressure, contact.on.border)
    return states[-1].values


def reference_strain(body: Solid, central: Sites, values: Array) -> Reference:
    """Return the logarithmic strain at central sites for the unknowns (n_unknowns,) of a body."""
    probe = recovered_gradient_at(body.space, central.points, body.planes)
    strain = logarithmic((probe @ values).reshape(-1, 3, 3))
    return Reference(REFERENCE_DEPTH, central.types, central.normals, strain)

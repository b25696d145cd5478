"""The reference press: a small flat press of the same finger that scales strain to displacement."""

import numpy as np

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.geometry.voigt import tensor_from_voigt
from fefinger.mechanics.press.problem import REACH, Press, ReferencePlate, SolutionMethod
from fefinger.mechanics.press.sites import REFERENCE_DEPTH
from fefinger.neural.reference import Reference
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import ConvergenceError


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

"""Check of a hyperelastic law in the elements: Taylor test of the tangent, uniaxial stress."""

import numpy as np
from skfem import MeshTet

from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.material import Material
from fefinger.fem.hyperelastic.stress_kernels import at_point
from fefinger.laws import LAWS, Law
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


STEPS = (1e-3, 5e-4)
"""Lengths of the steps of the Taylor test, along displacements of .1 of the cube."""

ORDER = 1.9
"""Least order of the remainder; that of a tangent with a wrong entry is 1."""


def check_law(law: Law | str, **parameters: float) -> float:
    """Check a hyperelastic law, a `Law` or the name of one, with these parameters.

    Its derivatives are compared with differences of its energy, at stretches of some 1.1. Then the
    tangent of six elements that are deformed at random is compared with their residual: what a
    first-order Taylor series leaves out falls as the square of the step. Return the order that is
    found, which is about 2.

    Raises
    ------
    InputError
        An unknown law, parameters that are not its own, or derivatives that do not fit.
    """
    chosen = law if isinstance(law, Law) else LAWS.named("law", law)
    values = chosen.values(parameters)
    chosen.check(values)
    edge = np.linspace(0.0, 1.0, 2)
    mesh = MeshTet.init_tensor(edge, edge, edge)
    cells = np.ascontiguousarray(mesh.t.T, dtype=np.int64)
    space = Space(np.ascontiguousarray(mesh.p.T), cells, np.ones(len(cells), dtype=np.int8))
    compressibility = 0.1  # 1 / K over 1 / mu in the cube of the Taylor test
    body = continuum(space, {1: Material(1.0, compressibility, chosen, values)})
    at, along = np.random.default_rng(0).uniform(-0.05, 0.05, (2, space.n_unknowns))
    start, slope = body.residual(at, body.at_rest)[0], body.tangent(at, body.at_rest) @ along
    left = [
        np.linalg.norm(body.residual(at + h * along, body.at_rest)[0] - start - h * slope)
        for h in STEPS
    ]
    order = float(np.log2(left[0] / left[1]))
    if not order > ORDER:
        raise InputError(
            f"law {chosen.name!r}: expected a tangent whose Taylor remainder falls with order 2, "
            f"received order {order:.2f}; correct its second derivatives"
        )
    return order


def uniaxial(law: Law | str, stretch: Array, **parameters: float) -> Array:
    """Return the nominal stress (n,) over the shear modulus of incompressible tissue.

    stretch: (n,) of a bar that is pulled or pressed along its axis. The stress comes from the
    elements.

    Raises InputError for an unknown law, or parameters that are not its own.
    """
    chosen = law if isinstance(law, Law) else LAWS.named("law", law)
    material = Material(1.0, 0.0, chosen, chosen.values(parameters))
    nominal = np.empty(len(stretch))
    for k, along in enumerate(stretch):
        across = along**-0.5
        stress, _ = at_point(material, np.diag([along, across, across]) - np.eye(3))
        pressure = -stress[1] * across**2  # that leaves the sides free
        nominal[k] = along * (stress[0] + pressure / along**2)
    return nominal

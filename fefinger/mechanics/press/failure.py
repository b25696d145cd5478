"""Error message for a finite-strain press that stopped converging."""

import numpy as np

from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.geometry.finger_mesh import REGIONS
from fefinger.mechanics.press.hard_parts import NAIL
from fefinger.support.arrays import Array


def most_compressed(elements: Continuum, values: Array) -> tuple[float, Array, str]:
    """Return the smallest principal stretch in a body, the place (3,) mm at rest, and the tissue.

    `values` (n_unknowns,) are those of the body.
    """
    space = elements.space
    moved = values[space.unknowns[:, :30]].reshape(-1, 10, 3)
    deformation = np.eye(3) + np.einsum(
        "eni,qnk,ekj->eqij", moved, elements.reference, elements.jacobians
    )
    stretch = np.linalg.svd(deformation, compute_uv=False)[..., -1].min(axis=1)
    cell = int(np.argmin(stretch))
    place = space.points[space.vertices[cell]].mean(axis=0)
    names = {number: name for name, number in REGIONS.items()} | {NAIL: "nail"}
    name = names[int(space.tissue[cell])]
    return float(stretch[cell]), place, "subcutaneous tissue" if name == "subcutaneous" else name


def failure_message(error: Exception, elements: Continuum, values: Array | None) -> str:
    """Return the message of a press that found no equilibrium after `values` (n,), if any."""
    if values is None:
        return str(error)
    stretch, (x, y, z), tissue = most_compressed(elements, values)
    return (
        f"{error}. At the last equilibrium the {tissue} at x = {x:.1f}, y = {y:.1f}, z = {z:.1f} "
        f"mm is pressed to {stretch:.2g} of its length"
    )

"""What is wrong with a press by one mechanics, against a converged press of the same finger.

A press is known at DEPTHS evenly spaced depths; every error is one number for each of them.
"""

from dataclasses import dataclass, fields

import numpy as np
from fefinger.validation import tradeoff_runs as runs
from fefinger.validation import tradeoff_scenes as scenes
from fefinger.validation.evidence import ORDER
from fefinger.validation.tradeoff_runs import DEPTHS, Run
from numpy.typing import NDArray

from fefinger.checks import InputError


Array = NDArray[np.float64]

QUANTITIES = ("force", "pressure", "area", "centroid", "strain")


@dataclass(frozen=True)
class Press:
    """A press at its depths: depth (n,) mm, force (n,) N, area (n,) mm², centroid (n, 2) mm.

    taxels (n, k, k) mN about the centroid; strain (n, 4, 3, 3) at the central end organs.
    """

    depth: Array
    force: Array
    area: Array
    centroid: Array
    taxels: Array
    strain: Array

    def scaled(self, force: float) -> "Press":
        """Return the press of a body that is stiffer by a factor."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        scaled = {name: force * values[name] for name in ("force", "taxels")}
        return Press(**(values | scaled))


def press(name: str, mechanics: str, resolution: str = "standard") -> Press | None:
    """Return a press that was run; None where the mechanics refused."""
    arrays = runs.load(Run("press", name, mechanics, resolution))
    if arrays is None:
        return None
    at = arrays["kept"]
    return Press(
        arrays["depth"][at],
        arrays["force"][at],
        arrays["area"][at],
        arrays["centroid"][at],
        arrays["taxels"],
        arrays["strain"][at],
    )


def unknowns(name: str, mechanics: str, resolution: str) -> float:
    """Return the size of the mesh of a press."""
    arrays = runs.load(Run("press", name, mechanics, resolution))
    assert arrays is not None
    return float(arrays["unknowns"])


@dataclass(frozen=True)
class Converged:
    """A press in the limit of fine meshes, and by what it may be wrong: relative, (n,) each."""

    press: Press
    bars: dict[str, Array]


def limit(coarse: Press, fine: Press, ratio: float) -> Press:
    """Return the limit of two meshes, with `ratio` times the unknowns, of errors of order 2."""
    gain = 1 / (ratio ** (ORDER / 3) - 1)
    values = {
        each.name: getattr(fine, each.name)
        + gain * (getattr(fine, each.name) - getattr(coarse, each.name))
        for each in fields(Press)
    }
    return Press(**(values | {"depth": fine.depth}))


def converged(name: str, mechanics: str = "solid") -> Converged:
    """Return the press of `solid` (or another one) extrapolated over the meshes that it has.

    Where the coarse mesh is too coarse for the object, `solid` is taken to change with the mesh as
    `linear` does from the standard to the fine one.
    """
    fine = press(name, mechanics, "standard")
    if fine is None:
        msg = f"{name}: expected a press of {mechanics} on the standard mesh, it refused"
        raise InputError(msg)
    coarse = press(name, mechanics, "coarse")
    if coarse is not None:
        sizes = [unknowns(name, mechanics, mesh) for mesh in ("coarse", "standard")]
        best = limit(coarse, fine, sizes[1] / sizes[0])
        return Converged(best, errors(fine, best))
    finest, rough = press(name, "linear", "fine"), press(name, "linear", "standard")
    assert finest is not None
    assert rough is not None
    sizes = [unknowns(name, "linear", mesh) for mesh in ("standard", "fine")]
    small = limit(rough, finest, sizes[1] / sizes[0])
    moved = {
        each.name: getattr(fine, each.name) + getattr(small, each.name) - getattr(rough, each.name)
        for each in fields(Press)
    }
    best = Press(**(moved | {"depth": fine.depth}))
    return Converged(best, errors(fine, best))


def errors(found: Press, true: Press) -> dict[str, Array]:
    """Return the relative errors (n,) of each of QUANTITIES in presses to each depth.

    force: the largest difference on the way to a depth, of the force there; pressure: of the
    forces on taxels of 1 mm about the centroid, in L2; area: relative; centroid: the distance, of
    the radius of a circle of that area; strain: Frobenius norm over the four end organs.
    """
    apart = np.maximum.accumulate(np.abs(found.force - true.force))
    radius = np.sqrt(true.area / np.pi)
    return {
        "force": apart / true.force,
        "pressure": _norm(found.taxels - true.taxels) / _norm(true.taxels),
        "area": np.abs(found.area / true.area - 1),
        "centroid": np.linalg.norm(found.centroid - true.centroid, axis=1) / radius,
        "strain": _norm(found.strain - true.strain) / _norm(true.strain),
    }


def apart(found: Press, own: Press, true: Press) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return numerical and model error: found against its own limit, and that against the truth."""
    return errors(found, own), errors(own, true)


def _norm(values: Array) -> Array:
    return np.asarray(np.sqrt((values.reshape(len(values), -1) ** 2).sum(axis=1)))


@dataclass(frozen=True)
class Identified:
    """The free parameters of the mechanics without a mesh, fitted to the force of one press.

    b N/mm and m 1/mm of `lumped`; radius mm and modulus kPa of `hertz`; stiffness, the factor on
    both moduli of `layered`; residual: the largest difference of each over the largest force.
    """

    b: float
    m: float
    radius: float
    modulus: float
    stiffness: float
    residual: dict[str, float]


def identify(true: Press, layered: Press, poisson: float) -> Identified:
    """Fit lumped, hertz and layered to the force against depth of one press of a plate.

    The radius of `hertz` is that whose contact areas pi R d are those of the press.
    """
    from scipy.optimize import least_squares

    def spring(logs: Array) -> Array:
        b, m = np.exp(logs)
        return np.asarray(b / m * np.expm1(m * true.depth) - true.force)

    found = least_squares(spring, np.zeros(2), x_scale=1.0)
    b, m = (float(x) for x in np.exp(found.x))
    radius = _slope(np.pi * true.depth, true.area)
    shape = 4 / 3 * np.sqrt(radius) * true.depth**1.5 / 1e3  # N per kPa
    plane = _slope(shape, true.force)
    stiffness = _slope(layered.force, true.force)
    largest = true.force.max()
    residual = {
        "lumped": float(np.abs(found.fun).max() / largest),
        "hertz": float(np.abs(plane * shape - true.force).max() / largest),
        "layered": float(np.abs(stiffness * layered.force - true.force).max() / largest),
    }
    return Identified(b, m, radius, plane * (1 - poisson**2), stiffness, residual)


def _slope(x: Array, y: Array) -> float:
    """Return the factor a of y = a x by least squares."""
    return float(x @ y / (x @ x))


def law(identified: Identified, depth: Array) -> Array:
    """Return the force (n,) in N of the identified `lumped`."""
    b, m = identified.b, identified.m
    return np.asarray(b / m * np.expm1(m * depth))


def hertzian(name: str, identified: Identified) -> Press:
    """Return the press by the identified `hertz`."""
    from dataclasses import replace

    from fefinger.mechanics import hertz

    scene = scenes.press(name)
    finger, modulus = scene.finger, identified.modulus
    poisson = hertz.tissue(finger)[1]
    one = replace(
        finger,
        pad_radius=identified.radius,
        skin=replace(finger.skin, modulus=modulus, poisson=poisson),
        subcutaneous=replace(finger.subcutaneous, modulus=modulus, poisson=poisson),
    )
    response = hertz.respond(replace(scene, finger=one))
    assert response.contact_area is not None
    assert response.centroid is not None
    assert response.strain is not None
    wanted = response.depth.max() * np.arange(1, DEPTHS + 1) / DEPTHS
    at = np.searchsorted(response.depth, wanted * (1 - 1e-9))
    return Press(
        response.depth[at],
        response.force[at],
        response.contact_area[at],
        response.centroid[at],
        np.array([runs.taxels(response, int(step)) for step in at]),
        response.strain[at],
    )

"""Errors of a press by one mechanics, against a converged press of the same finger.

A press is known at DEPTHS evenly spaced depths; every error is one number for each of them.
"""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from fefinger.validation.tradeoff import runs, scenes
from fefinger.validation.tradeoff.runs import DEPTHS, Run

from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.mechanics.linear import FACETS
from fefinger.results.pressure import peaks
from fefinger.results.records import Response
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError


ORDER = 2.0
"""Order in the cell length that the extrapolation assumes; contact limits it to about two."""

QUANTITIES = (*STATED, "taxels", "centroid")


@dataclass(frozen=True)
class Press:
    """A press: depth (n,) mm, force (n,) N, area (n,) mm², centroid (n, 2) mm on the way down.

    strain (n, 4, 3, 3) at the central end organs; at (m,): the depths at which it is judged;
    taxels (m, k, k) mN about the centroid there; pressure (n,) kPa, the highest over 1 mm².
    """

    depth: Array
    force: Array
    area: Array
    centroid: Array
    strain: Array
    at: Integers
    taxels: Array
    pressure: Array

    def scaled(self, factor: float) -> "Press":
        """Return the press of a body that is stiffer by a factor."""
        stiffer = {name: factor * getattr(self, name) for name in ("force", "taxels", "pressure")}
        return replace(self, **stiffer)

    @classmethod
    def of(cls, response: Response) -> "Press":
        """Return the press that was answered by a ramp, without the time of first touch."""
        assert response.contact_area is not None
        assert response.centroid is not None
        assert response.strain is not None
        assert response.pad is not None
        assert response.pressure is not None
        wanted = response.depth.max() * np.arange(1, DEPTHS + 1) / DEPTHS
        at = np.searchsorted(response.depth, wanted * (1 - 1e-9))
        return cls(
            response.depth[1:],
            response.force[1:],
            response.contact_area[1:],
            response.centroid[1:],
            response.strain[1:],
            at - 1,
            np.array([runs.taxels(response, int(step)) for step in at]),
            peaks(response.pad, response.pressure)[1:],
        )


MEASURED = (*STATED, "centroid", "taxels")


@cache
def press(name: str, mechanics: str, resolution: str = "standard") -> Press | None:
    """Return a press that was run; None where the mechanics refused."""
    arrays = runs.load(Run("press", name, mechanics, resolution))
    if arrays is None:
        return None
    curves = ("depth", "force", "area", "centroid", "strain")
    values = {key: arrays[key][1:] for key in curves}
    at, taxels, highest = arrays["kept"] - 1, arrays["taxels"], arrays["highest"][1:]
    return Press(**values, at=at, taxels=taxels, pressure=highest)


def unknowns(name: str, mechanics: str, resolution: str) -> float:
    """Return the size of the mesh of a press."""
    arrays = runs.load(Run("press", name, mechanics, resolution))
    assert arrays is not None
    return float(arrays["unknowns"])


@dataclass(frozen=True)
class Converged:
    """A press on the finest meshes, and by what it may be wrong: relative, (n,) each."""

    press: Press
    bars: dict[str, Array]


def limit(coarse: Press, fine: Press, ratio: float) -> Press:
    """Return the limit of two meshes, with `ratio` times the unknowns, of errors of order 2."""
    return moved(fine, coarse, fine, left([1.0, ratio]))


def moved(press_: Press, start: Press, stop: Press, gain: float = 1.0) -> Press:
    """Return a press moved by `gain` times what leads from one press to another."""
    values = {
        name: getattr(press_, name) + gain * (getattr(stop, name) - getattr(start, name))
        for name in MEASURED
    }
    return replace(press_, **values)


@cache
def converged(name: str, mechanics: str = "solid") -> Converged:
    """Return the press of `solid` (or another one) on the finest meshes, and its error bars.

    The force is extrapolated over the meshes that the mechanics was run on, with errors of order
    2; where the coarse one is too coarse for the object, as that of `linear` changes from the
    standard to the fine mesh. Nothing else comes close to its order on the coarse mesh: for the
    rest, and for all of `linear`, that change is made and not extrapolated; what it leaves of an
    error of order 2 is in the bars, so that the truth has no noise of extrapolation.
    """
    standard, coarse = press(name, mechanics), press(name, mechanics, "coarse")
    rough, finest = press(name, "linear"), press(name, "linear", "fine")
    if standard is None or rough is None or finest is None:
        msg = f"{name}: expected presses of {mechanics} and `linear`, they refused"
        raise InputError(msg)
    sizes = [unknowns(name, "linear", mesh) for mesh in ("standard", "fine")]
    best = moved(standard, rough, finest)
    bars = {key: left(sizes) * values for key, values in errors(standard, best).items()}
    if coarse is not None:
        sizes = [unknowns(name, mechanics, mesh) for mesh in ("coarse", "standard")]
        limited = limit(coarse, standard, sizes[1] / sizes[0])
    else:
        limited = moved(standard, rough, finest, 1 + left(sizes))
    best = replace(best, force=limited.force)
    return Converged(best, bars | {"force": errors(standard, best)["force"]})


def left(sizes: list[float]) -> float:
    """Return the error of a mesh over what it changes of another, given the unknowns of both."""
    return 1 / ((sizes[1] / sizes[0]) ** (ORDER / 3) - 1)


def left_on(coarser: str, finer: str) -> float:
    """Return the error of a mesh over what it changes of a coarser one, by the facets of the pad.

    Meshes are graded: facets shrink faster than the unknowns grow, and contact is on the facets.
    """
    return 1 / ((FACETS[coarser] / FACETS[finer]) ** ORDER - 1)


def mesh_errors(pressed: Press | None, limit_: Converged) -> dict[str, Array]:
    """Return the numerical errors of a press on a mesh; None is the fine one, all but its force.

    They are those against the finest meshes, and what is left there but for the force.
    """
    rest = {key: bar for key, bar in limit_.bars.items() if key != "force"}
    if pressed is None:
        return rest
    numerical = errors(pressed, limit_.press)
    return numerical | {key: numerical[key] + bar for key, bar in rest.items()}


def errors(pressed: Press, true: Press) -> dict[str, Array]:
    """Return the relative errors (n,) of each of QUANTITIES in presses to each depth.

    Of those that are stated, the largest difference on the way to a depth, of the value there:
    force, highest pressure over 1 mm², contact area, strain (Frobenius norm over the four end
    organs). taxels: of the forces on taxels of 1 mm about the centroid, in L2; centroid: the
    distance, of the radius of a circle of that area.
    """
    at = true.at
    stated = {name: _largest(getattr(pressed, name), getattr(true, name), at) for name in STATED}
    shift = (pressed.centroid - true.centroid)[at]
    return stated | {
        "taxels": norm(pressed.taxels - true.taxels) / norm(true.taxels),
        "centroid": np.linalg.norm(shift, axis=1) / np.sqrt(true.area[at] / np.pi),
    }


def _largest(values: Array, true: Array, at: Integers) -> Array:
    """Return the largest difference so far of values (n, ...), of the value there, (m,) at some."""
    return np.asarray(np.maximum.accumulate(norm(values - true))[at] / norm(true[at]))


def norm(values: Array) -> Array:
    """Return the norms (n,) of values (n, ...), over all but the first axis."""
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
    depth, force, area = (values[true.at] for values in (true.depth, true.force, true.area))
    b, m = spring(depth, force)
    radius = _slope(np.pi * depth, area)
    shape = 4 / 3 * np.sqrt(radius) * depth**1.5 / 1e3  # N per kPa
    plane = _slope(shape, force)
    softer = layered.force[layered.at]
    stiffness = _slope(softer, force)
    largest = force.max()
    residual = {
        "lumped": float(np.abs(law((b, m), depth) - force).max() / largest),
        "hertz": float(np.abs(plane * shape - force).max() / largest),
        "layered": float(np.abs(stiffness * softer - force).max() / largest),
    }
    return Identified(b, m, radius, plane * (1 - poisson**2), stiffness, residual)


def spring(depth: Array, force: Array) -> tuple[float, float]:
    """Return b in N/mm and m in 1/mm of the spring of Eq. 2.1 nearest to force against depth."""
    from scipy.optimize import least_squares

    def apart(logs: Array) -> Array:
        b, m = np.exp(logs)
        return law((b, m), depth) - force

    optimum = least_squares(apart, np.zeros(2), x_scale=1.0)
    b, m = np.exp(optimum.x)
    return float(b), float(m)


def _slope(x: Array, y: Array) -> float:
    """Return the factor a of y = a x by least squares."""
    return float(x @ y / (x @ x))


def law(parameters: tuple[float, float], depth: Array) -> Array:
    """Return the force (n,) in N of the spring of Eq. 2.1 with b in N/mm and m in 1/mm."""
    b, m = parameters
    return np.asarray(b / m * np.expm1(m * depth))


def hertzian(name: str, identified: Identified) -> Press:
    """Return the press by the identified `hertz`."""
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
    return Press.of(hertz.respond(replace(scene, finger=one)))

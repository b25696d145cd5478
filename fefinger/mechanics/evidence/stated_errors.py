"""The error that a mechanics states of a scene: one rule, for all of them and all quantities.

1. A press is an object and a finger. Its features are curvatures, width of edges, angle, tilt and
   place of the object, size, contrast and stiffening of the finger (`presses.py`).
2. Every mechanics was compared with finite strain on the finest mesh in some 95 presses, at twelve
   depths (`presses.py`). Finite strain itself is compared with what its meshes extrapolate to.
3. The estimate for a scene is the mean of the errors in the NEAREST presses, at its depth over the
   thickness; weights are 1 / (distance² + SAME).
4. The stated error is the estimate times a factor: the 95 % quantile of actual errors over
   estimates, in scenes that were measured with all mechanics (of one scene more than there are, as
   a new one is); of the strain of each type, and of pressure and area by formulas, which scatter
   with the tissue, also in presses that are left out. There is one factor for each mechanics and
   quantity, computed by `validation/evidence/derive.py`.
5. Nothing is stated where the nearest press is FARTHEST away or all of them are less deep.

Small strain is compared in tissue of the same law only: there its error follows the stiffening.
`modal` adds the error of its modes, and `plan` that of neglected inertia. Errors under force
control follow from those at a given depth.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from fefinger.mechanics.evidence.presses import EVIDENCE, Features, Press, nearest, pressed, read
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.support.text import format_excess, percent
from fefinger.support.vocabulary import TYPES


STATED = ("force", "pressure", "area", "strain")
"""Quantities with stated errors: of the force the largest error through time over the peak, of the
others (highest pressure over 1 mm², contact area, strain at the end organs as a Frobenius norm)
the error when the force is largest. Of the strain there is also that of each type of afferent."""

NEAREST = 5
"""Number of presses that are averaged; from 2 to 12 the stated errors differ by a tenth."""

SAME = 0.002
"""Square of a distance within which presses count about alike."""

FARTHEST = 1.6
"""Distance of the nearest press beyond which nothing is stated."""

LEAST = 1e-4
"""Least error that is told from none."""


SOFT, ROUND, SHALLOW, THIN = 0.03, 0.07, 0.15, 0.25
"""Errors of the force by what stands for a soft plate and for a round object, to a depth over the
relative radius and over its thickness: the largest of the suite `soft` are 2.4 and 6.3 %."""


class StatedError(NamedTuple):
    """A relative error and its source; nan where it is not known, and the source says why."""

    error: float
    source: str


class Estimate(NamedTuple):
    """Mean error of the nearest presses, and the presses."""

    error: float
    presses: tuple[Press, ...]


def strain_of(kind: str) -> str:
    """Return the name of the strain at the end organs of a type of afferent."""
    return f"strain {kind}"


STRAINS = tuple(map(strain_of, TYPES))
"""Strains of each type of afferent, stated where its spikes are asked."""


def error_of(mechanics: str) -> Callable[..., StatedError]:
    """Return the `error` of a mechanics (see `fefinger.mechanics.Mechanics`): the measured one.

    With a mesh it is that on the mesh of the scene.
    """

    def error(case: Situation, quantity: str = "force") -> StatedError:
        """Return the measured relative error of a quantity, and its source."""
        mesh = case.mesh if MECHANICS[mechanics].meshed else None
        return stated(Candidate(mechanics, mesh), case, quantity)

    return error


def stated(candidate: Candidate, case: Situation, quantity: str = "force") -> StatedError:
    """Return the error of a quantity and its source; nan where nothing comparable was measured.

    Under a soft object it is that under a rigid one, which deforms the skin more, and the object's.
    """
    found = _under_rigid(candidate, case, quantity)
    if case.indenter.soft_body is None or math.isnan(found.error):
        return found
    if reason := _not_measured(case, quantity):
        return StatedError(math.nan, f"not known: {reason}")
    own = ROUND if math.isfinite(case.indenter.least_radius) else SOFT
    source = f"{found.source}; {percent(own)} of the soft object (reports/soft.json)"
    return StatedError(math.hypot(found.error, own), source)


def _not_measured(case: Situation, quantity: str) -> str:
    """Return why the error of what stands for a soft object is not known; "" if it is."""
    body, depth, least = case.indenter.soft_body, case.motion.deepest, case.indenter.least_radius
    assert body is not None
    if case.indenter.soft_prony.v:
        return "it was measured of soft objects that do not relax"
    if quantity != "force" or depth is None:
        return "under soft objects it was measured of the force, at prescribed depths"
    curvature = 1 / case.finger.pad_radius + 1 / least
    for name, part, most in (
        ("depth / relative radius", depth * curvature, SHALLOW),
        ("depth / indenter.thickness", depth / body.thickness, THIN),
    ):
        if part > most * (1 + 1e-9):
            return f"{name} = {format_excess(part, most)}, and soft objects were measured to there"
    return ""


def _under_rigid(candidate: Candidate, case: Situation, quantity: str) -> StatedError:
    """Return the error under a rigid object, as `stated`."""
    if candidate.resolution is None and not case.as_pressed:
        return StatedError(
            math.nan, "not known: it was measured on fingers of the shape and bone of the subjects"
        )
    if not MECHANICS[candidate.mechanics].finite:
        candidate = candidate.measured
    found = estimate(candidate, quantity, case.features, case.depth_over_thickness)
    if isinstance(found, str):
        return StatedError(math.nan, found)
    factor = read(EVIDENCE)["factors"].get(candidate.mechanics, {}).get(quantity)
    if factor is None:
        return StatedError(math.nan, "not known: no scene was compared")
    names = f"{found.presses[0].name} and {len(found.presses) - 1} more"
    source = f"reports/{EVIDENCE}, {names}: {percent(found.error)}, times {factor:.2g}"
    return StatedError(found.error * factor, source)


def estimate(
    candidate: Candidate, quantity: str, features: Features, part: float, without: str = ""
) -> Estimate | str:
    """Return the mean error of the presses next to one, at a depth over the thickness.

    A sentence where none is comparable. without: name of a press that is left out.
    """
    finite, label = MECHANICS[candidate.mechanics].finite, candidate.label
    near: list[tuple[float, Press, float]] = []
    reason = ""
    beyond = 1.06  # depth over that of the deepest press up to which the errors there count
    for distance, press in nearest(features):
        if press.name == without or quantity not in press.errors.get(label, {}):
            continue
        if not finite and press.features.law != features.law:
            continue
        if distance > FARTHEST and not near:
            reason = reason or (
                f"not known: no press like it was measured; the nearest, {press.name}, has another "
                f"{features.farthest(press.features)}"
            )
            break
        there = part if finite else part * stiffer(features, press.features)
        if there > beyond * press.part[-1]:
            reason = reason or (
                f"not known: it goes to {there:.2g} of the finger's thickness, and presses like it "
                f"were measured to {press.part[-1]:.2g}"
            )
            continue
        near.append((distance, press, there))
        if len(near) == NEAREST:
            break
    if not near:
        return reason or "not known: it was not measured"
    errors = [_error_at(press, candidate, quantity, there) for _, press, there in near]
    weights = [1 / (distance**2 + SAME) for distance, *_ in near]
    mean = float(np.average(errors, weights=weights))
    return Estimate(mean, tuple(press for _, press, _ in near))


def stiffer(features: Features, there: Features) -> float:
    """Return the factor on the depth for which small strain has the same error as in a press.

    Tissue of Demiray's law stiffens by its exponent times I1 - 3, which grows as the square of the
    depth. 1 without stiffening.
    """
    return math.sqrt(features.exponent / there.exponent) if features.exponent else 1.0


def _error_at(press: Press, candidate: Candidate, quantity: str, part: float) -> float:
    """Return the error of a press at a relative depth, constant beyond the deepest measured one.

    Above the shallowest one that on a mesh grows as the inverse of the depth, since the mesh
    resolves ever less of the contact.
    """
    errors = press.errors[candidate.label][quantity]
    known = np.isfinite(errors)
    parts, logs = press.part[known], np.log(np.maximum(errors[known], LEAST))
    part = max(part, LEAST * float(parts[0]))  # a force of 0 presses to no depth
    value = math.exp(np.interp(math.log(part), np.log(parts), logs))
    grows = candidate.resolution is not None
    return value * max(float(parts[0]) / part, 1.0) if grows else value


def worst(errors: Mapping[str, float], types: Iterable[str]) -> float:
    """Return the largest error of the strain at the end organs of types, else of all together."""
    found = [errors[strain_of(kind)] for kind in types if strain_of(kind) in errors]
    return max(found, default=errors.get("strain", math.nan))


def at_force(at_depth: Mapping[str, float], force: float, case: Situation) -> dict[str, float]:
    """Convert relative errors at a depth, `at_depth` and that of the `force`, to those at a force.

    A quantity that grows no faster than the force gains at most the error of the force. The force
    grows as a power p of the depth, at least 1, so the error of the depth is at most
    (1 - force)^(-1/p) - 1.
    """
    power = max(1.0, pressed(case.features).steepness(case.depth_over_thickness))
    depth = (1 - force) ** (-1 / power) - 1 if force < 1 else math.inf
    return {"depth": depth} | {name: error + force for name, error in at_depth.items()}

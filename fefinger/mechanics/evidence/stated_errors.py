"""The error that a mechanics states of a scene, from the presses that were measured.

Finite strain: error of the mesh. Other mechanics: difference from finite strain. The error of the
time steps (`reports/time-steps.json`) is added in quadrature. `pressed.error` adds the error of its
convolution, `modal.error` that of its modes, and `plan` that of neglected inertia. Errors under
force control follow from those at a given depth.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from fefinger.mechanics.evidence import measured_tissue, press_mesh
from fefinger.mechanics.evidence.press_mesh import UNKNOWN, StatedError
from fefinger.mechanics.evidence.pressed_objects import axis_and_value
from fefinger.mechanics.evidence.table import TIME_STEPS, Measured, table
from fefinger.mechanics.press.notes import stiffens
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.scene import library
from fefinger.scene.indenters import Flat
from fefinger.support.text import percent


SOFT_SKIN = 1.6
"""Factor on errors of small strain where the skin is softer, against the tissue below it, than the
published one of 3 times its modulus. With skin and tissue alike the errors of the force under the
plate, the ball and the grating of the built-in scenes are 1.0 to 1.55 times as large (coarse mesh);
under the edge of a bar 3.4 times, less than under the plate. With skin 6 and 18 times as stiff they
are 0.8 and 0.2 times as large."""

STATED = ("force", "pressure", "area", "strain")
"""Quantities with stated errors: of the force the largest error through time over the peak, of the
others (highest pressure over 1 mm², contact area, strain at the end organs as a Frobenius norm)
the error when the force is largest."""

RAISED = {"coarse": 0.30, "standard": 0.13, "fine": 0.08}
"""Error of the mean force on raised dots 0.7 mm wide that are scanned, by the mesh: against that
extrapolated from all three; letters and Braille have wider parts and err less (validation/friction,
`mesh.py`)."""


def error_of(mechanics: str) -> Callable[..., StatedError]:
    """Return the `error` of a mechanics (see `fefinger.mechanics.Mechanics`): the measured one.

    With a mesh it is that on the mesh of the scene.
    """

    def error(case: Situation, quantity: str = "force") -> StatedError:
        """Return the measured relative error of a quantity, and its source."""
        mesh = case.mesh if MECHANICS[mechanics].meshed else None
        return measured(Candidate(mechanics, mesh), case, quantity)

    return error


def measured(candidate: Candidate, case: Situation, quantity: str = "force") -> StatedError:
    """Return the measured error of a quantity and its source.

    Not a number where nothing comparable was measured; the source then states the reason.
    """
    if not MECHANICS[candidate.mechanics].finite:
        if case.indenter.raised:
            return _raised(candidate, case, quantity)
        if not (case.published_tissue or case.calibrated_tissue):
            return _other_tissue(candidate, case, quantity)
    stated_error = press_mesh.error(candidate, case, quantity)
    if quantity != "force" and candidate.resolution is not None:
        # The mesh decides which points bear the pressure, whatever the tissue and the strain, so
        # the comparison of meshes at finite strain applies. The force has evidence of its own.
        mesh = press_mesh.error(Candidate("solid", candidate.resolution), case, quantity)
        stated_error = mesh if mesh.error > stated_error.error else stated_error
    paced = table().all(TIME_STEPS, f"error of {quantity}", Candidate(candidate.mechanics))
    steps = sum(each.value for each in paced)  # formulas have none
    # The error of the steps is independent of the mesh.
    return StatedError(math.hypot(stated_error.error, steps), stated_error.source)


def _raised(candidate: Candidate, case: Situation, quantity: str) -> StatedError:
    """Return the error under raised parts: that of the mesh under them, and that under a plate.

    They were compared while they slide, by the mean force.
    """
    if quantity != "force" or candidate.resolution is None:
        return UNKNOWN
    plate = measured(candidate, replace(case, indenter=Flat(*(case.indenter.plate or ()))))
    mesh = RAISED[candidate.resolution]
    source = f"reports/friction.json: {percent(mesh)} of the mesh under raised parts"
    return StatedError(mesh + plate.error, f"{source}; under a plate {plate.source}")


def _other_tissue(candidate: Candidate, case: Situation, quantity: str) -> StatedError:
    """Return the error of a mesh at small strain on published tissue, for a finger of other tissue.

    Tissue that stiffens in another way, and formulas, were not compared there.
    """
    finger = case.finger
    if not MECHANICS[candidate.mechanics].meshed or stiffens(finger):
        return StatedError(
            math.nan, "not known: it was measured on published and calibrated tissue"
        )
    alike = replace(case, finger=measured_tissue.of_published(finger))
    on_published = measured(candidate, alike, quantity)
    source = f"{on_published.source}, on tissue {library.PUBLISHED!r}"
    if not measured_tissue.soft_skin(finger):
        return StatedError(on_published.error, source)
    # Under an edge soft skin bends more than the published one, as it does under a plate.
    plate = replace(alike, indenter=Flat())
    bent = measured(candidate, plate, quantity) if case.indenter.sharp else on_published
    error = float(np.maximum(on_published.error, SOFT_SKIN * bent.error))
    return StatedError(error, f"{source}, and {SOFT_SKIN:g} times as much for softer skin")


def at_force(at_depth: Mapping[str, float], force: float, case: Situation) -> dict[str, float]:
    """Convert relative errors at a depth, `at_depth` and that of the `force`, to those at a force.

    A quantity that grows no faster than the force gains at most the error of the force. The force
    grows as a power p of the depth, so the error of the depth is at most (1 - force)^(-1/p) - 1.
    """
    depth = (1 - force) ** (-1 / steepness(case)) - 1 if force < 1 else math.inf
    return {"depth": depth} | {name: error + force for name, error in at_depth.items()}


def steepness(case: Situation) -> float:
    """Return the smallest exponent p of force = a depth^p in the measured presses around a scene.

    It is 1 for a scene without comparable presses: a contact stiffens as it grows.
    """
    if axis_and_value(case.indenter) is None or not (
        case.published_tissue or case.calibrated_tissue
    ):
        return 1.0
    return max(1.0, min(_power(each, case.depth_over_thickness) for each in case.force_curves))


def _power(force: Measured, part: float) -> float:
    """Return the smallest exponent of force over depth near a relative depth of a press."""
    depth = np.asarray(force.depth)
    powers = np.diff(np.log(force.values)) / np.diff(np.log(depth))
    at = int(np.searchsorted(depth, part * force.conditions["thickness_mm"]))
    return float(powers[max(at - 2, 0) : at + 1].min(initial=powers[-1]))

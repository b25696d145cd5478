"""What a loop in real time steps: a contact, and what is read of it, prepared once.

A finger is reduced to the candidates of a press of a given depth; the contact on them is solved by
the mechanics of the same name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, Protocol

import numpy as np
from scipy import sparse

from fefinger.contact.active_set import BEYOND, DONE, TURNED
from fefinger.contact.complementarity import Complementarity
from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.inertial import InertialContact
from fefinger.contact.readout import Readout, readout
from fefinger.contact.stepper import Target
from fefinger.fem.body import Reduced, Solid
from fefinger.fem.condensation import Operator, OutsideError
from fefinger.fem.contact.obstacle import OwnObstacle, Rigid
from fefinger.fem.contact.patch import Patch, patch
from fefinger.fem.contact.travel import Travel
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.geometry import finger_mesh
from fefinger.geometry.profiles import frame
from fefinger.mechanics.press import mesh_limits, moving_contact, operator, placement, problem
from fefinger.mechanics.press.compliances import pressing_object
from fefinger.mechanics.press.mesh_limits import needs_continuation
from fefinger.mechanics.press.modal_body import (
    FingerModes,
    ModalBody,
    body_of_modes,
    finger_modes,
)
from fefinger.mechanics.press.modal_press import contact_of
from fefinger.mechanics.press.placement import first_moments, whole_pad
from fefinger.mechanics.press.problem import on_enough_candidates
from fefinger.mechanics.press.reference import reference_press
from fefinger.mechanics.press.sites import central_sites
from fefinger.mechanics.press.time_steps import RESOLVED
from fefinger.mechanics.press.unit_fields import UnitFields, at_small_strain, with_inertia
from fefinger.neural.drives import Reference
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motions import Ramp
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.progress import Stages


APART = 0.25
"""Distance in mm of the places within reach at which candidates of a sliding object are sought."""

Precision = Literal["double", "single"]


class AnyContact(Protocol):
    """What a loop asks of a contact; `contact.stepper.Stepper` has it."""

    failures: Mapping[int, str]
    pose: Array
    pressure: Array

    @property
    def elastic(self) -> Array:
        """Elastic stress (k,), of which strains are linear."""

    @property
    def depth(self) -> float:
        """Present depth in mm."""

    def advance(self, dt: float, target: Target) -> int:
        """Advance by `dt` s to a target; return DONE or a failure, which changes nothing."""

    def reset(self) -> None:
        """Return to rest."""

    def state(self) -> tuple[Any, ...]:
        """Return the state."""

    def restore(self, state: tuple[Any, ...]) -> None:
        """Return to a state."""


@dataclass(frozen=True)
class Prepared:
    """A finger under an object, prepared for steps in real time.

    finger; solid: the body that is solved; sites: the end organs at which strain is read; contact:
    what is stepped; readout: what is read of it; touch (3,) mm: the first touch; shown: what a text
    says of it. reduced: the body on its candidates, at small strain; strains(points) gives the
    strain (6 n_points, k) at points under unit elastic stresses; reference() the press that scales
    strain for afferents of the thesis; fields() the fields on the mesh, for pictures. With inertia:
    the modes, and the body of those that are stepped. places (n, 2) mm: of the candidates across
    the axis of the object.
    """

    finger: Finger
    solid: Solid
    sites: Sites
    contact: AnyContact
    readout: Readout
    touch: Array
    shown: tuple[str, ...]
    reduced: Reduced | None
    strains: Callable[[Array], Array]
    reference: Callable[[], Reference]
    fields: Callable[[], UnitFields]
    modes: FingerModes | None = None
    body: ModalBody | None = None
    places: Array | None = None

    @property
    def on_pad(self) -> Reduced:
        """The body on its candidates; InputError for a tabulated press, which has none."""
        if self.reduced is None:
            message = "mechanics: expected 'condensed' or 'modal', received 'pressed', a table"
            raise InputError(message)
        return self.reduced


@dataclass(frozen=True)
class _Reduction:
    """A finger on the candidates of a press, and the strain at its sites from the unknowns."""

    solid: Operator
    obstacle: Rigid
    sites: Sites
    reduced: Reduced
    probe: Callable[[], sparse.csr_matrix]
    with_continuation: bool = False


def pressed(
    finger: Finger,
    indenter: Indenter | OwnObstacle,
    deepest: float,
    sites: Sites | None,
    precision: Precision,
    stages: Stages,
) -> Prepared:
    """Prepare a finger under an object that moves along its axis.

    Raises
    ------
    InputError
        If the object misses the pad or leaves it before `deepest` mm, a site lies outside the soft
        tissue, or the tissues do not relax as one.
    """
    made = _reduction(finger, indenter, deepest, sites, stages)
    on, flexibility = made.reduced.patch, made.reduced.flexibility
    bounds, areas = _limits(made.solid, on), on.projected
    contact = made.reduced.object.frictionless(
        flexibility, on.gap, areas, finger.prony.branches, bounds
    )
    rows = made.reduced.strain_operator
    return _prepared(finger, made, contact, rows, precision)


def inertial(
    finger: Finger,
    indenter: Indenter | OwnObstacle,
    deepest: float,
    sites: Sites | None,
    precision: Precision,
    stages: Stages,
    longest: float,
) -> Prepared:
    """Prepare a finger with inertia; its modes are those that steps of `longest` s resolve.

    Errors as `pressed`, and ConvergenceError if the modes do not converge.
    """
    made = _reduction(finger, indenter, deepest, sites, stages)
    with stages.stage("modes") as report:
        modes = finger_modes(finger, made.solid, report)
    body = body_of_modes(finger, modes, made.reduced, made.probe).below(RESOLVED / longest)
    contact = contact_of(body, longest * (1 + 1e-9), _limits(made.solid, made.reduced.patch))
    low, high = modes.frequencies[[0, -1]]
    shown = f"{len(modes.frequencies)} modes, {low:.3g} to {high:.3g} Hz relaxed"
    prepared = _prepared(finger, made, contact, body.complete.strain_operator, precision)

    def fields() -> UnitFields:
        return with_inertia(
            finger, made.solid, modes, body, with_continuation=made.with_continuation
        )

    return replace(prepared, modes=modes, body=body, shown=(shown,), fields=fields)


def slid(
    finger: Finger,
    indenter: Indenter,
    deepest: float,
    reach: float,
    sites: Sites | None,
    precision: Precision,
    stages: Stages,
) -> Prepared:
    """Prepare a whole finger under an object that also moves sideways, with its friction.

    Candidates are found for the plane through the crests of the object, or for all places within
    `reach` mm that an object without such a plane may take.

    Errors as `pressed`.
    """
    with stages.stage("factor") as report:
        solid = operator.operator(finger, half=False, progress=report)
    obstacle = placement.obstacle(indenter, solid)
    chosen = sites or organs_under(finger, obstacle)
    probe = partial(recovered_strain_at, solid.space, chosen.points, solid.planes)
    path, mu = _disc(reach), indenter.friction

    def candidates(within: float, rings: int) -> Patch:
        return moving_contact.candidates(solid, obstacle, path, within / problem.REACH, rings)

    def reduce(on: Patch) -> Reduced:
        loaded = moving_contact.with_tractions(solid, on, obstacle.axis) if mu else on
        return replace(operator.reduced(finger, solid, loaded, chosen.points, probe), patch=on)

    reduced = _on_candidates(solid, deepest, candidates, reduce)
    on, branches = reduced.patch, finger.prony.branches
    reduced = replace(reduced, object=pressing_object(indenter, solid, on))
    gaps = Travel.of(solid.space, solid.normals, on, obstacle)
    made = _Reduction(solid, obstacle, chosen, reduced, probe)
    rest = gaps, on.projected, branches, _limits(solid, on)
    turns, flexibility = obstacle.profile.plane, reduced.flexibility
    contact: FrictionlessContact | FrictionalContact
    if mu:
        contact = FrictionalContact(flexibility, (mu, indenter.kinetic), *rest, turns=turns)
    else:
        contact = reduced.object.frictionless(flexibility, *rest, turns=turns)
    places = (solid.space.points[on.vertices] - obstacle.origin) @ frame(obstacle.axis)[:2].T
    prepared = _prepared(finger, made, contact, reduced.strain_operator, precision)
    return replace(prepared, places=places)


def unfolded(solid: Solid, points: Array, strain: Array) -> Array:
    """Return strain (6 n, ...) at points (n, 3), given that at their places in the half body."""
    if not solid.half:
        return strain
    signs = np.where(points[:, 1:2] < 0, finger_mesh.VOIGT_SIGNS, 1.0)
    return np.asarray(signs.reshape(-1, 1) * strain)


def _reduction(
    finger: Finger,
    indenter: Indenter | OwnObstacle,
    deepest: float,
    sites: Sites | None,
    stages: Stages,
) -> _Reduction:
    """Reduce a finger, or half of it where that is enough, to a press of `deepest` mm."""
    half = long = False
    if not isinstance(indenter, OwnObstacle):
        half = indenter.mirrored
        long = needs_continuation(finger, indenter, Ramp(1.0, deepest, corner=0.0))
    with stages.stage("factor") as report:
        solid = operator.operator(finger, half=half, with_continuation=long, progress=report)
    obstacle: Rigid
    if isinstance(indenter, OwnObstacle):
        obstacle = indenter
    else:
        obstacle = placement.obstacle(indenter, solid)
    chosen = sites or organs_under(finger, obstacle)
    where = solid.folded(chosen.points)
    probe = partial(recovered_strain_at, solid.space, where, solid.planes)

    def candidates(reach: float, rings: int) -> Patch:
        return patch(
            *(solid.space, solid.pad, solid.normals, obstacle), reach, rings, solid.loadable
        )

    def reduce(on: Patch) -> Reduced:
        return operator.reduced(finger, solid, on, where, probe)

    reduced = _on_candidates(solid, deepest, candidates, reduce)
    reduced = replace(reduced, object=pressing_object(indenter, solid, reduced.patch))
    return _Reduction(solid, obstacle, chosen, reduced, probe, long)


def _on_candidates(
    solid: Solid,
    deepest: float,
    candidates: Callable[[float, int], Patch],
    reduce: Callable[[Patch], Reduced],
) -> Reduced:
    """Return a finger reduced to candidates that a press of `deepest` mm stays within.

    The first unit loads of what `reduce` gives are the pressures on the candidates. Contact at the
    end of the object is a matter of each step.
    """

    def attempt(on: Patch, rings: int) -> tuple[Reduced, Flags]:
        count = len(on.vertices)
        if count == 0:
            raise InputError(mesh_limits.NOTHING_UNDER)
        reduced = reduce(on)
        solver = Complementarity(reduced.flexibility[:count, :count])
        pressure = solver.solve(on.gap - deepest * on.projected)
        pressed = (pressure > 0) & ~on.obstacle_border
        if not (on.border & pressed).any():
            placement.check_inside(solid, on.vertices[pressed], deepest)
        return reduced, pressed

    try:
        return on_enough_candidates(solid, deepest, candidates, attempt)
    except OutsideError:
        wanted = "at which contact stays on the palmar part of the pad"
    except ConvergenceError:
        wanted = "at which contact stays within the candidates that are tried"
    raise InputError(
        f"deepest: expected a depth {wanted}, received {deepest:g} mm; give a smaller `deepest`"
    )


def _prepared(
    finger: Finger,
    made: _Reduction,
    contact: FrictionlessContact | FrictionalContact | InertialContact,
    rows: Array,
    precision: Precision,
) -> Prepared:
    solid, on, points = made.solid, made.reduced.patch, made.sites.points
    pad, column = whole_pad(solid, on)
    count, first = len(on.vertices), first_moments(pad)
    moments = [np.bincount(column, first[:, c], minlength=count) for c in (0, 1)]

    def strains(points: Array) -> Array:
        where = solid.folded(points)
        probe = partial(recovered_strain_at, solid.space, where, solid.planes)
        reduced = operator.reduced(finger, solid, on, where, probe)
        return unfolded(solid, points, reduced.strain_operator)

    return Prepared(
        finger=finger,
        solid=solid,
        sites=made.sites,
        contact=contact,
        readout=readout(
            np.bincount(column, pad.areas, minlength=count).astype(np.float64),
            on.projected,
            np.array(moments),
            unfolded(solid, points, rows).T,
            np.float32 if precision == "single" else np.float64,
        ),
        touch=np.asarray(getattr(made.obstacle, "origin", np.zeros(3))),
        shown=(f"{count} vertices may touch",),
        reduced=made.reduced,
        strains=strains,
        reference=partial(reference_of, finger, solid, made.sites),
        fields=lambda: at_small_strain(finger, solid, on, with_continuation=made.with_continuation),
    )


def _limits(solid: Solid, on: Patch) -> Integers:
    """Return the outcome (n,) of contact at each candidate."""
    edge = on.border | np.isin(on.vertices, placement.border(solid))
    return np.select([on.obstacle_border, edge], [TURNED, BEYOND], DONE)


def organs_under(finger: Finger, obstacle: Rigid) -> Sites:
    """Place one end organ of each type under the first touch of an object."""
    origin = np.asarray(getattr(obstacle, "origin", np.zeros(3)))
    return central_sites(Ask(), finger.pulp, origin, obstacle.axis)


def reference_of(finger: Finger, solid: Solid, sites: Sites) -> Reference:
    """Return the press that scales the strain at the sites for units of the thesis."""
    ask = Ask(spikes=tuple(dict.fromkeys(sites.types)))
    plate = problem.reference_plate(finger, solid, ask)
    return reference_press(solid, plate, operator.METHOD)


def _disc(radius: float) -> Array:
    """Places (n, 2) mm that fill a disc, APART mm from each other, and its rim."""
    count = int(np.ceil(radius / APART))
    even = np.linspace(-radius, radius, 2 * count + 1)
    square = np.stack(np.meshgrid(even, even), axis=-1).reshape(-1, 2)
    turn = np.linspace(0.0, 2 * np.pi, 8 * count, endpoint=False)
    rim = radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([square[np.hypot(*square.T) < radius], rim, np.zeros((1, 2))])

"""Contacts prepared for a loop, other than at small strain: a rolling plate, a tabulated press."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy import sparse
from scipy.spatial import ConvexHull

from fefinger.contact.active_set import BEYOND, DONE
from fefinger.contact.frictionless import RollingContact
from fefinger.contact.readout import readout
from fefinger.contact.stepper import OTHER_STATE, Target
from fefinger.fem.body import Solid
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import Patch, patch, smooth_places
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.fem.elements.spaces import trace
from fefinger.mechanics.press import operator, placement, problem
from fefinger.mechanics.press.placement import first_moments, on_neighborhood, whole_pad
from fefinger.mechanics.press.prepared import (
    Precision,
    Prepared,
    organs_under,
    reference_of,
    unfolded,
)
from fefinger.mechanics.press.tabulated_press import TabulatedPress
from fefinger.mechanics.press.unit_fields import at_finite_strain, at_small_strain
from fefinger.neural.drives import Reference
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import Flat
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
from fefinger.support.progress import Stages
from fefinger.support.tensors import VOIGT
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.ting import NestedContact, State, node_weights


MEDIAL = (0, 2)
"""Components of the normal of a plate that rolls: it turns about y."""


def rolled(
    finger: Finger,
    angles: Sequence[float],
    deepest: float,
    sites: Sites | None,
    precision: Precision,
    stages: Stages,
) -> Prepared:
    """Prepare half a finger under a plate that turns about y between `angles` in degrees.

    Errors as `prepared.pressed`.
    """
    with stages.stage("factor") as report:
        solid = operator.operator(finger, half=True, progress=report)
    obstacle = placement.obstacle(Flat(float(np.mean(angles))), solid)
    chosen = sites or organs_under(finger, obstacle)
    every = [
        patch(solid.space, solid.pad, solid.normals, Obstacle(axis, np.zeros(3)), np.inf)
        for axis in np.eye(3)[list(MEDIAL)]
    ]
    surface = trace(solid.space, solid.pad)
    skin = smooth_places(solid.space.points, solid.normals, surface)[..., MEDIAL].reshape(-1, 2)
    outline = skin[ConvexHull(skin).vertices]
    under = _under_plates(solid, every[0], outline, angles, problem.REACH * deepest)
    on = _both_directions(every, under)

    def strains(points: Array) -> Array:
        probe = partial(recovered_strain_at, solid.space, solid.folded(points), solid.planes)
        found = operator.reduced(finger, solid, on, points, probe).strain_operator
        return unfolded(solid, points, found)

    folded = solid.folded(chosen.points)
    probe = partial(recovered_strain_at, solid.space, folded, solid.planes)
    reduced = operator.reduced(finger, solid, on, folded, probe)
    n, weights = int(under.sum()), every[0].areas[under]
    moments = np.array([each.gap[under] for each in every])
    along = -every[1].moment[under, 1] / every[1].projected[under]
    rim = np.flatnonzero(_on_rim(solid, every[0].vertices[under]))
    flexibility = reduced.flexibility.reshape(2, n, 2, n)
    return Prepared(
        finger=finger,
        solid=solid,
        sites=chosen,
        contact=RollingContact(flexibility, moments, weights, outline, rim, finger.prony.branches),
        readout=readout(
            2 * weights,
            weights,
            2 * weights * np.stack([along, np.zeros(n)]),
            unfolded(solid, chosen.points, reduced.strain_operator).T,
            np.float32 if precision == "single" else np.float64,
        ),
        touch=obstacle.origin,
        shown=(f"a plate from {min(angles):g} to {max(angles):g} degrees",),
        reduced=reduced,
        strains=strains,
        reference=partial(reference_of, finger, solid, chosen),
        fields=partial(at_small_strain, finger, solid, on),
    )


def medial_normal(angle: float) -> tuple[float, float]:
    """Return the normal (x, z) of a plate at an angle in degrees, in the plane of rolling."""
    x, z = direction(Flat(angle))[list(MEDIAL)].tolist()
    return x, z


def _under_plates(
    solid: Solid, every: Patch, outline: Array, angles: Sequence[float], reach: float
) -> Flags:
    """Flag the vertices that any of the plates is within `reach` mm of at first touch."""
    points = solid.space.points[every.vertices][:, MEDIAL]
    nearest = np.full(len(points), np.inf)
    for angle in np.arange(min(angles), max(angles) + 1.0, 1.0):
        normal = np.array(medial_normal(min(float(angle), max(angles))))
        nearest = np.minimum(nearest, points @ normal - float((outline @ normal).min()))
    return nearest <= reach


def _both_directions(every: Sequence[Patch], chosen: Flags) -> Patch:
    """Return the patch of chosen vertices with unit loads along both axes of the medial plane."""
    loads, places = (
        sparse.hstack([getattr(each, name)[:, chosen] for each in every]).tocsc()
        for name in ("loads", "places")
    )
    vertices = np.tile(every[0].vertices[chosen], 2)
    seen = replace(every[0].neighborhood, vertices=vertices)
    return replace(every[0], vertices=vertices, loads=loads, places=places, neighborhood=seen)


def _on_rim(solid: Solid, vertices: Integers) -> Flags:
    """Flag the candidates next to pad vertices that are none, or on the border of the pad."""
    inside = np.isin(solid.pad, vertices)
    beside = solid.pad[inside.any(axis=1) & ~inside.all(axis=1)]
    return np.isin(vertices, beside) | np.isin(vertices, placement.border(solid))


class TabulatedContact:
    """The contact of a press whose elastic states are tabulated by depth.

    pressure (n,) kPa: of the candidates; elastic (n_depths,): shares of the tabulated
    displacements, of which there is a strain each. Steps to a depth beyond `deepest` mm, or to a
    force that presses deeper, fail.
    """

    failures: Mapping[int, str] = {}

    def __init__(self, tabulated: TabulatedPress, deepest: float) -> None:
        table, prony = tabulated.table, tabulated.press.finger.prony
        # Elastic values of the modulus at t = 0, as the springs take them.
        self._pressures = tabulated.pressure / prony.long_time
        self._force, self._between = tabulated.instantaneous, table.between
        self._area = table.bounded(table.area)
        self._newton = tabulated.press.body.sides * NEWTON_PER_MILLINEWTON
        self._projected = self._newton * tabulated.contact.projected
        self.springs = NestedContact(prony, table.nodes, table.measure, deepest)
        self.deepest, self.pose = deepest, np.zeros(4)
        self.pressure, self.elastic = np.zeros(len(self._projected)), np.zeros(len(self._between.T))

    @property
    def depth(self) -> float:
        """Present depth in mm."""
        return self.springs.depth

    @property
    def contact_area(self) -> float:
        """Contact area in mm², of the elastic contact with the same edge."""
        return float(np.interp(self.springs.edge, self.springs.nodes, self._area))

    def advance(self, dt: float, target: Target) -> int:
        """Advance by `dt` s to a depth in mm or a force in mN; return DONE, or BEYOND."""
        force = None
        try:
            if target.by_force:
                force = target.value * self._newton
                self.springs.advance_force(dt, force, self._force)
            else:
                self.springs.advance(dt, target.value)
        except ValueError:
            return BEYOND
        self._read(force)
        return DONE

    def reset(self) -> None:
        """Return to rest: no contact and no history."""
        self.springs.reset()
        self._read(0.0)

    def state(self) -> State:
        """Return the state, some kilobytes."""
        return self.springs.state()

    def restore(self, state: State) -> None:
        """Return to a state of this contact; InputError for a state of another."""
        if [np.shape(each) for each in state] != [np.shape(each) for each in self.state()]:
            raise InputError(OTHER_STATE)
        self.springs.restore(state)
        self._read(None)

    def _read(self, force: float | None) -> None:
        """Set pressures, scaled to the force in N, and shares of the present state."""
        springs = self.springs
        stressed = node_weights(springs.stressed, springs.measure)
        borne_now = float(self._force.along(stressed, springs.depth)) if force is None else force
        np.maximum(stressed @ self._pressures, 0.0, out=self.pressure)
        borne = float(self.pressure @ self._projected)
        self.pressure *= borne_now / borne if borne > 0 else 0.0
        np.matmul(node_weights(springs.strained, springs.nodes), self._between, out=self.elastic)


def tabulated_strains(tabulated: TabulatedPress, points: Array) -> Array:
    """Return the strain (6 n_points, n_depths) at points (n_points, 3) of the tabulated states."""
    rows, columns = zip(*VOIGT, strict=True)
    strain = tabulated.strain(points)[..., rows, columns]
    return np.asarray(strain.reshape(len(strain), -1).T)


def _reference(tabulated: TabulatedPress) -> Reference:
    """Return the press that scales strain for the afferents of the thesis."""
    reference = tabulated.reference()
    assert reference is not None  # spikes are asked for
    return reference


def prepared(tabulated: TabulatedPress, deepest: float, sites: Sites | None) -> Prepared:
    """Prepare the contact of a tabulated press for steps to `deepest` mm in real time."""
    press, on = tabulated.press, tabulated.contact
    chosen = sites or press.sites
    assert chosen is not None  # spikes are asked for
    pad, column = whole_pad(press.body, on.neighborhood)
    seen = on_neighborhood(np.eye(len(on.projected)), on.neighborhood)[:, column]
    return Prepared(
        finger=press.finger,
        solid=press.body,
        sites=chosen,
        contact=TabulatedContact(tabulated, deepest),
        readout=readout(
            seen @ pad.areas,
            on.projected,
            (seen @ first_moments(pad)[:, :2]).T,
            tabulated_strains(tabulated, chosen.points).T,
            np.float64,
        ),
        touch=press.obstacle.origin,
        shown=(),
        reduced=None,
        strains=partial(tabulated_strains, tabulated),
        reference=partial(_reference, tabulated),
        fields=partial(at_finite_strain, tabulated),
    )

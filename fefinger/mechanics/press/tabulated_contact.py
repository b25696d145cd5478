"""Contact of a tabulated press at finite strain, stepped in real time as the others are."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from fefinger.contact.active_set import BEYOND, DONE
from fefinger.contact.readout import readout
from fefinger.contact.stepper import OTHER_STATE, Target
from fefinger.geometry.voigt import VOIGT
from fefinger.mechanics.press.placement import first_moments, on_neighborhood, whole_pad
from fefinger.mechanics.press.prepared import Prepared
from fefinger.mechanics.press.tabulated_press import TabulatedPress
from fefinger.mechanics.press.unit_fields import at_finite_strain
from fefinger.neural.drives import Reference
from fefinger.results.records import Sites
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.ting import NestedContact, State, node_weights


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

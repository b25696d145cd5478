"""A finger at finite strain in real time, by its tabulated elastic press.

    finger = ff.Pressed(ff.Finger.subject("a.h."), ff.Flat(angle=30), deepest=1.5)
    step = finger.step(depth=0.3, dt=1e-3)
    step.force, step.strain

It is `mechanics/pressed` without a scene. The press is read, or solved once and kept.
"""

import math

import numpy as np

from fefinger.geometry.voigt import VOIGT
from fefinger.mechanics import pressed
from fefinger.mechanics.press import elastic_press
from fefinger.mechanics.press.notes import elastic_hard_parts_reasons, separate_relaxation_reasons
from fefinger.mechanics.press.placement import first_moments, on_neighborhood, whole_pad
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.press.tabulated_press import METHOD, TabulatedPress
from fefinger.mechanics.realtime.loop import Loop, Step, check_frictionless, quick_number
from fefinger.neural.reference import Reference
from fefinger.results.records import Sites
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError, number
from fefinger.support.progress import Progress, Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.support.vocabulary import TYPES
from fefinger.theory.contact.ting import NestedContact, node_weights


class Pressed(Loop):
    """A finger at finite strain under an indenter, stepped in real time.

    Parameters
    ----------
    finger, indenter
        As in a scene.
    deepest
        Largest depth in mm of a step.
    sites
        End organs at which the strain is wanted; the central ones by default.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        If the indenter misses the pad, a site lies outside the soft tissue, or the tissues do not
        relax as one.
    ConvergenceError
        If an equilibrium of the elastic press is not reached.
    """

    def __init__(
        self,
        finger: Finger,
        indenter: Indenter = STANDARD,
        *,
        deepest: float = 1.5,
        sites: Sites | None = None,
        progress: Progress | None = None,
    ) -> None:
        super().__init__(finger, deepest)
        for reason in (*separate_relaxation_reasons(finger), *elastic_hard_parts_reasons(finger)):
            raise InputError(f"{reason.text}; use the mechanics 'solid'")
        check_frictionless(indenter)
        stages, motion = Stages(progress), Ramp(1.0, self.deepest, corner=0.0)
        scene = Scene(finger=finger, indenter=indenter, motion=motion, ask=Ask(spikes=TYPES))
        press = Press.of(scene, METHOD, stages, mechanics=pressed.name, notes=pressed.NOTES)
        table = elastic_press.load_or_solve(press, self.deepest, stages)
        self._tabulated = tabulated = TabulatedPress.of(press, table)
        self.indenter = indenter
        assert press.sites is not None  # as spikes are asked for
        self.sites = sites or press.sites
        rows, columns = zip(*VOIGT, strict=True)
        strain = tabulated.strain(self.sites.points)[..., rows, columns]
        self._strain = np.ascontiguousarray(strain.reshape(len(strain), -1))
        # Elastic values of the modulus at t = 0, as the springs take them.
        self._pressure = tabulated.pressure / finger.prony.long_time
        self._force = tabulated.instantaneous
        self._travel, self._between = tabulated.contact.projected, table.between
        self._area = table.bounded(table.area)
        pad, column = whole_pad(press.body, tabulated.contact.neighborhood)
        seen = on_neighborhood(np.eye(len(self._travel)), tabulated.contact.neighborhood)[:, column]
        self._loads = seen @ np.column_stack([pad.areas, first_moments(pad)[:, :2]])
        self._contact = NestedContact(finger.prony, table.nodes, table.measure, self.deepest)
        strain = np.zeros((len(self.sites.points), 6))
        self.now = Step.at_rest(np.zeros(len(self._travel)), strain)

    def _reference(self) -> Reference:
        reference = self._tabulated.reference()
        assert reference is not None  # as spikes are asked for
        return reference

    def reset(self) -> None:
        """Lift the indenter off and clear the stress history."""
        self._contact.reset()
        self._read()

    def step(self, depth: float, dt: float) -> Step:
        """Move the indenter to `depth` mm in `dt` s and return force, pressure and strain.

        Raises
        ------
        InputError
            A depth beyond `deepest`, or a number that is not finite; the finger stays as it was.
        """
        if not (isinstance(depth, float) and -math.inf < depth <= self.deepest):
            depth = number("depth", depth, at_most=self.deepest, unit="mm")
        dt = quick_number("dt", dt, 0.0, unit="s")
        self._contact.advance(dt, depth)
        return self._read()

    def step_force(self, force: float, dt: float) -> Step:
        """Load the indenter with `force` N in `dt` s and return force, pressure and strain.

        Raises
        ------
        InputError
            A force that presses deeper than `deepest`; the finger stays as it was.
        """
        force = number("force", force, at_least=0, unit="N")
        dt = number("dt", dt, at_least=0, unit="s")
        try:
            self._contact.advance_force(dt, force, self._force)
        except ValueError as error:
            raise InputError(f"{error} N; give a larger `deepest`") from None
        return self._read(force)

    def _read(self, force: float | None = None) -> Step:
        """Read force, pressure, area and strain of the present state; the force where not given."""
        now, contact = self.now, self._contact
        stressed = node_weights(contact.stressed, contact.measure)
        now.depth = contact.depth
        now.force = float(self._force.along(stressed, contact.depth)) if force is None else force
        np.maximum(stressed @ self._pressure, 0.0, out=now.pressure)
        unit = self._tabulated.press.body.sides * NEWTON_PER_MILLINEWTON
        borne = unit * float(now.pressure @ self._travel)
        now.pressure *= now.force / borne if borne > 0 else 0.0
        load, x, y = (now.pressure @ self._loads).tolist()
        now.x, now.y = (x / load, y / load) if load > 0 else (math.nan, math.nan)
        now.contact_area = float(np.interp(contact.edge, contact.nodes, self._area))
        strained = node_weights(contact.strained, contact.nodes) @ self._between
        np.matmul(strained, self._strain, out=now.strain.reshape(-1))
        return now

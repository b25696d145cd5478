"""A finger in real time, advanced by your own loop at the rates of a haptic controller.

    finger = ff.Loop(ff.Finger.subject("a.h."), ff.Flat(angle=30))
    step = finger.step(1e-3, depth=0.3)  # or force=0.5
    step.force, step.strain

It is the mechanics `pressed`, `condensed` or `modal` without a scene: what a finger needs is built
once and kept, and the contact that is stepped is the one that `run` takes through a motion.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import fields
from functools import partial
from typing import Any

import numpy as np

from fefinger.contact.active_set import DONE
from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.frictionless import FrictionlessContact
from fefinger.contact.inertial import InertialContact
from fefinger.contact.readout import X, Y, read, read_contact
from fefinger.contact.stepper import Target
from fefinger.fem.contact.obstacle import Rigid
from fefinger.geometry.profiles import frame
from fefinger.mechanics.loop_input import FAR, FIXED, failed_step, place, quick_number
from fefinger.mechanics.loop_setup import SUBSTEP, LoopOptions, prepare
from fefinger.mechanics.press.prepared import Precision
from fefinger.mechanics.press.prepared_contacts import TabulatedContact, medial_normal
from fefinger.neural.stepped import SteppedUnits
from fefinger.results.records import LoopState, Sites, Step
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, Plate, direction
from fefinger.scene.indenters import STANDARD, Flat
from fefinger.support.checks import InputError, boolean, instance, number
from fefinger.support.progress import Progress, Stages
from fefinger.support.registry import AFFERENTS
from fefinger.support.text import counted
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.support.vocabulary import FAMILIES


STILL = (0.0, 0.0), (0.0, 0.0)
"""Place and turn of an object that only moves along its axis."""


class Loop:
    """A finger under an object, stepped in real time.

    Parameters
    ----------
    finger, indenter
        As in a scene, with its friction; or, at small strain without friction, an object of your
        own with an `axis` (3,) and `gap(points)`, as `fem.contact.obstacle.Rigid`.
    mechanics
        "pressed": finite strain, any tissue. "condensed": small strain, with contact solved at each
        step; also sliding, friction and turning plates. "modal": small strain with inertia. At
        small strain, tissue that stiffens is as soft as at first touch, with a warning.
    deepest
        Depth in mm that the pad has to answer; candidate vertices and tables follow from it.
    reach
        None: the object only moves along its axis. A number: it may move sideways, so that the
        whole finger is prepared; how far in mm, for an object without a plane of crests, as a ball.
        0 by default where there is friction.
    angles
        Angles in degrees between which a plate is going to roll about y, on half a finger.
    sites
        End organs at which the strain is wanted; the central ones by default.
    substep
        Longest step in s in which the modes of "modal" move; longer steps are divided.
    precision
        "double", or "single" for strains to 1e-5 of the largest in half the time.
    stiffening
        t(u) of Pawluk (1997), Eq. 3.11, over a constant modulus, at a depth in mm, of "condensed":
        the contact pressure is then the integral of G(t - s) d(t q)(s), with q that of the linear
        body. Under depth control and while t > 0.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Attributes
    ----------
    now
        The last `Step`.
    sites, solid
        The end organs; the body that is solved.
    prepared
        What was prepared: contact, candidates, modes.

    Raises
    ------
    InputError
        If the object misses the pad or leaves it before `deepest`, a site lies outside the soft
        tissue, the tissues do not relax as one, or the mechanics cannot do what is asked.
    ConvergenceError
        If an equilibrium of the elastic press is not reached, or the modes do not converge.
    """

    def __init__(
        self,
        finger: Finger,
        indenter: Indenter | Rigid = STANDARD,
        *,
        mechanics: str = "pressed",
        deepest: float = 1.5,
        reach: float | None = None,
        angles: Sequence[float] | None = None,
        sites: Sites | None = None,
        substep: float = SUBSTEP,
        precision: Precision = "double",
        stiffening: Callable[[float], float] | None = None,
        progress: Progress | None = None,
    ) -> None:
        self.options = options = LoopOptions(
            *(finger, indenter, mechanics, deepest, reach),  # type: ignore[arg-type]  # checked there
            *(angles, sites, substep, precision, stiffening),  # type: ignore[arg-type]
        )
        made = self.prepared = prepare(options, Stages(progress))
        self.sites, self.solid = made.sites, made.solid
        self._contact, self._readout = made.contact, made.readout
        self._newton = made.solid.sides * NEWTON_PER_MILLINEWTON
        known = options.known
        plate = None if known is None else known.flat
        self._plate, self._first = plate, (plate.angle, plate.tilt) if plate else (0.0, 0.0)
        if options.angles is not None:
            self._first = (float(np.mean(options.angles)), 0.0)
        self._angles = self._first
        self._fixed = options.reach is None and options.angles is None
        pressure, strain = self._contact.pressure, self._readout.strain.reshape(-1, 6)
        self.now = Step(pressure, strain, np.zeros(2), np.zeros(2))
        self.reset()
        pose = self._pose(None, self._angles)
        for value, by_force in ((deepest / 2, False), (1.0, True)):
            # Compiles or loads what a step needs: none of them waits.
            self._contact.advance(0.0, Target(value, by_force, *pose))
        self.reset()

    def __repr__(self) -> str:
        """Show finger, object, depth and end organs, not the arrays."""
        finger, options = self.finger, self.options
        who = finger.subject_name or f"{finger.width:g} x {finger.thickness:g} mm"
        under = f", under {options.indenter}" if options.angles is None else ""
        organs = f"strain at {counted(self.sites.types)}"
        parts = "; ".join([f"to {self.deepest:g} mm", *self.prepared.shown, organs])
        tissue = f"{finger.tissue or 'own'} tissue, {finger.mesh} mesh"
        return f"<Loop, {options.mechanics}: finger {who}, {tissue}{under}; {parts}>"

    @property
    def finger(self) -> Finger:
        """The finger."""
        return self.options.finger

    @property
    def indenter(self) -> Indenter | Rigid:
        """The object."""
        return self.options.indenter

    @property
    def deepest(self) -> float:
        """Depth in mm that the pad has to answer."""
        return self.options.deepest

    def step(
        self,
        dt: float,
        *,
        depth: float | None = None,
        force: float | None = None,
        shift: tuple[float, float] | None = None,
        angle: float | None = None,
        tilt: float | None = None,
        strain: bool = True,
    ) -> Step:
        """Move the object in `dt` s to a depth in mm or a force in N; return what follows.

        shift: its place (x, y) in mm, of one that slides; angle, tilt: of a plate, in degrees, as
        of `ff.Flat`; each stays as it was where it is not given. The depth counts from first touch
        at the first place or, of a plate that rolls, at its present angle. strain: False leaves the
        strain as it was. A step that is refused leaves the finger as it was.

        Raises
        ------
        InputError
            If contact reaches the rim of the candidates, which is beyond `deepest`, or that of the
            object or the pad before it; this loop cannot move so; or a number is not finite.
        ConvergenceError
            If no contact is found.
        """
        dt, strain = quick_number("dt", dt, 0.0, unit="s"), boolean("strain", strain)
        angles = self._angles
        if angle is not None or tilt is not None:
            angles = self._turned(angle, tilt)
        value, by_force = self._wanted(depth, force)
        pose = self._pose(shift, angles)
        target = Target(value, by_force, *pose)
        outcome = self._advance(dt, target)
        if outcome != DONE:
            raise failed_step(outcome, target, self._contact, self.options, self._newton)
        self._angles = angles
        return self._read(strain=strain)

    def rest(
        self, seconds: float, *, depth: float | None = None, force: float | None = None
    ) -> Step:
        """Hold a depth in mm or a force in N for some s, in one step without inertia.

        Errors as `step`.
        """
        return self._hold(seconds, depth, force)

    def reset(self) -> None:
        """Lift the object off at its first place, and clear the history."""
        self._contact.reset()
        self._angles = self._first
        self._readout.summary[[X, Y]] = self.prepared.touch[:2]
        self._read(strain=True)

    def state(self) -> LoopState:
        """Return the state, some kilobytes: the loop goes on from it after `restore`."""
        x, y = self._readout.summary[[X, Y]].tolist()
        return LoopState(self._contact.state(), (x, y), self._angles)

    def restore(self, state: LoopState) -> Step:
        """Return to a state of this loop, or of one that was made in the same way.

        InputError for the state of another finger or object.
        """
        instance("state", state, LoopState, "a state of this loop, as its `state()` gives")
        self._contact.restore(state.contact)
        self._angles = state.angles
        self._readout.summary[[X, Y]] = state.center
        return self._read(strain=True)

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle and copy by recipe: the finger is prepared again from the cache."""
        return partial(again, type(self)), (self.options,), self.state()

    def __setstate__(self, state: LoopState) -> None:
        """Restore a state."""
        self.restore(state)

    def afferents(self, *, family: str = FAMILIES[0], **options: Any) -> SteppedUnits:
        """Return the units of the sites, to be stepped with the strain of every step.

        Family "recorded": `options` as for `neural.streaming.RecordedAfferents`. "thesis": one unit
        per site, `options` as for `neural.streaming.Afferents`, scaled by a reference press. One of
        your own: `drives` and `variation`. InputError for another, one without `stepper`, or as
        these.
        """
        sites, units = self.sites, AFFERENTS.named("family", family)
        reference = self.prepared.reference
        stepped: SteppedUnits = units.stepped(
            sites.types, sites.normals, unit=sites.unit, reference=reference, **options
        )
        return stepped

    def _hold(self, seconds: float, depth: float | None, force: float | None) -> Step:
        """Hold a depth or a force as `rest` does."""
        seconds = quick_number("seconds", seconds, 0.0, unit="s")
        target = Target(*self._wanted(depth, force), *self._pose(None, self._angles))
        outcome = self._contact.advance(seconds, target)
        if outcome != DONE:
            raise failed_step(outcome, target, self._contact, self.options, self._newton)
        return self._read(strain=True)

    def _advance(self, dt: float, target: Target) -> int:
        """Advance the contact; with inertia in steps that its modes can follow."""
        contact = self._contact
        if not isinstance(contact, InertialContact):
            if self.options.stiffening is not None:
                self._stiffen(target)
            return contact.advance(dt, target)
        parts = max(1, math.ceil(dt / self.options.substep * (1 - 1e-9)))
        if parts == 1:
            return contact.advance(dt, target)
        start = self.now.force / self._newton if target.by_force else contact.depth
        before = contact.state()
        for k in range(1, parts + 1):
            value = start + k / parts * (target.value - start)
            outcome = contact.advance(dt / parts, target._replace(value=value))
            if outcome != DONE:
                contact.restore(before)
                return outcome
        return DONE

    def _wanted(self, depth: float | None, force: float | None) -> tuple[float, bool]:
        """Return the depth in mm or the force in mN of the meshed part, and whether it is one."""
        if (depth is None) == (force is None):
            raise InputError(
                "step: expected a depth in mm or a force in N, received "
                f"{'none' if depth is None else 'both'}; give one of them"
            )
        if depth is not None:
            return quick_number("depth", depth, unit="mm"), False
        return quick_number("force", force, 0.0, unit="N") / self._newton, True

    def _pose(
        self, shift: tuple[float, float] | None, angles: tuple[float, float]
    ) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return place in mm and turn of a target, as its contact reads them."""
        if shift is None and self._fixed:
            return STILL
        options, at, pose = self.options, (0.0, 0.0), self._contact.pose
        if shift is not None:
            at = place(shift)
            if options.reach is None and at != (0.0, 0.0):
                raise InputError(FIXED.format("shift", shift, "`reach`"))
            level = options.known is not None and options.known.profile.level
            if options.reach is not None and not level:
                if math.hypot(*at) > options.reach * (1 + 1e-9):
                    raise InputError(FAR.format(options.reach, *at))
        elif options.reach is not None:
            at = (float(pose[0]), float(pose[1]))
        if options.angles is not None:
            return at, medial_normal(angles[0])
        if self._plate is None or angles == self._first:
            return at, (0.0, 0.0)
        normal = frame(direction(self._plate)) @ direction(Plate(*angles))
        return at, (float(normal[0] / normal[2]), float(normal[1] / normal[2]))

    def _turned(self, angle: float | None, tilt: float | None) -> tuple[float, float]:
        """Return angle and tilt of a plate in degrees; InputError where it cannot turn so."""
        options, (before, level) = self.options, self._angles
        if options.angles is not None:
            low, high = options.angles
            if tilt is not None:
                raise InputError(FIXED.format("tilt", tilt, "`reach`, not `angles`"))
            turned = before if angle is None else angle
            return number("angle", turned, at_least=low, at_most=high, unit="degrees"), 0.0
        if self._plate is None or options.reach is None:
            name, given = ("angle", angle) if tilt is None else ("tilt", tilt)
            raise InputError(FIXED.format(name, given, "`angles` or `reach`, of an ff.Flat"))
        plate = Flat(before if angle is None else angle, level if tilt is None else tilt)
        return plate.angle, plate.tilt

    def _stiffen(self, target: Target) -> None:
        """Set t at the depth of a target; it may be 0 or less only while there is no history."""
        contact, stiffening = self._contact, self.options.stiffening
        assert isinstance(contact, FrictionlessContact)
        assert stiffening is not None
        if target.by_force:
            message = "step: expected depth control, as t(u) is a function of the depth"
            raise InputError(message)
        value = float(stiffening(target.value))
        if value <= 0.0 and contact.elastic.any():
            raise InputError(
                "stiffening: expected t above 0 while the tissue has stress history, "
                f"received {value:g} at a depth of {target.value:g} mm; reset, or stay in contact"
            )
        contact.stiffening = value if value > 0.0 else 1.0

    def _read(self, *, strain: bool) -> Step:
        """Read what the present state gives."""
        now, contact, out = self.now, self._contact, self._readout
        if strain:
            t = contact.stiffening if isinstance(contact, FrictionlessContact) else 1.0
            read(out, contact.pressure, contact.elastic, 1.0 / t)
        else:
            read_contact(out, contact.pressure)
        force, now.contact_area, now.x, now.y = out.summary.tolist()
        now.depth, now.force, now.touching = contact.depth, force * self._newton, force > 0.0
        if isinstance(contact, TabulatedContact):
            now.contact_area = contact.contact_area
        elif self.options.reach is not None:
            self._read_sideways(now)
        return now

    def _read_sideways(self, now: Step) -> None:
        """Read what an object that moves sideways gives besides."""
        contact, projected = self._contact, self._readout.projected
        assert isinstance(contact, FrictionlessContact | FrictionalContact)
        now.shift[:] = contact.pose[:2]
        now.lateral_force[:] = contact.push() * NEWTON_PER_MILLINEWTON
        if isinstance(contact, FrictionlessContact):
            return
        traction, weights = contact.traction, contact.pressure * projected
        now.lateral_force += traction @ projected * NEWTON_PER_MILLINEWTON
        now.stick_area = float(self._readout.areas[contact.sticking].sum())
        now.work, now.torque = 1e-3 * float(contact.lost[0]), 0.0
        if now.touching and self.prepared.places is not None:
            places = self.prepared.places
            x, y = (places - weights @ places / weights.sum()).T
            turning = (x * traction[1] - y * traction[0]) @ projected
            now.torque = float(turning) * NEWTON_PER_MILLINEWTON


def again(kind: type[Loop], options: LoopOptions) -> Loop:
    """Make a loop of a kind from its options."""
    finger = kind.__new__(kind)
    Loop.__init__(finger, **{each.name: getattr(options, each.name) for each in fields(options)})
    return finger

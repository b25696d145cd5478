"""A fingertip for a simulator: it feels objects at any pose, and gives the wrench back.

    tip = ff.TactileFinger(ff.Finger.subject("a.h."), friction=0.6)
    touch = tip.step([(ff.shapes.Sphere(10), rotation, place)], dt=1e-3)
    touch.wrench, touch.taxels, touch.strain

Small strain about the undeformed pad, with pressure along the objects' normals, Coulomb friction
and the finger's relaxation; what finite strain adds is a factor by the deepest penetration.
"""

from collections.abc import Sequence
from functools import cached_property, partial
from typing import Any

import numpy as np

from fefinger.contact import active_set, pad_gaps, pad_worlds, posed_steps
from fefinger.contact.elastic_kernel import flexibility
from fefinger.contact.pad_worlds import UNSOLVED, Factors, Moves, Softness
from fefinger.contact.posed_coulomb import PosedCoulomb
from fefinger.contact.signed_distance import Shapes
from fefinger.mechanics.evidence.tactile_errors import measured_errors
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.loop_setup import A_FINGER, SOME_SITES
from fefinger.mechanics.press import operator
from fefinger.mechanics.press.compliances import kernel, pad_compliance
from fefinger.mechanics.press.prepared import Precision
from fefinger.mechanics.press.sites import end_organ_sites, meshed
from fefinger.mechanics.press.tactile_parts import Pose, TaxelGrid, TouchState, poses, under
from fefinger.neural.streaming import RecordedAfferents
from fefinger.results.records import Sites
from fefinger.results.touch import VERDICTS, Maps, Touch, TouchError
from fefinger.scene.ask import Ask, Layout
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD, Flat
from fefinger.shapes import Plane, Shape, packed
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import (
    ConvergenceError,
    InputError,
    boolean,
    choice,
    instance,
    integer,
    number,
)
from fefinger.support.processes import one_thread, threads, together
from fefinger.support.progress import Progress, Stages
from fefinger.support.vocabulary import TYPES
from fefinger.theory.contact.stack import Stack


ANGLES, DEPTHS = (0.0, 15.0, 30.0, 45.0), 12
"""Angles in degrees of plates, and depths, at which the factor of finite strain is taken."""

LIGHT = 0.25
"""Depth in mm up to which log t is proportional to depth: the force of so light a touch depends on
which vertices of the mesh it meets."""


class TactileFinger:
    """A finger that feels objects at any pose, rigid or soft, in one or many worlds.

    Parameters
    ----------
    finger
        As in a scene; its tissues relax as one.
    friction
        Coulomb's coefficient.
    deepest
        Largest penetration in mm that is answered; the factor of finite strain is known to it.
    taxels
        Where forces are summed.
    population, sites
        Units under the skin, or end organs of your own; one of each type by default.
    worlds
        How many fingers are stepped at once.
    finite_strain
        Whether forces grow with depth as at finite strain. False: small strain alone.
    precision
        "double", or "single" for half the memory and, of many worlds, less time.
    strict
        Whether a step that is not valid raises InputError, or says so in `Touch.valid`.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        If the tissues do not relax as one, an end organ lies outside the soft tissue, or a number
        is out of its range.
    """

    def __init__(
        self,
        finger: Finger,
        *,
        friction: float = 0.0,
        deepest: float = 1.5,
        taxels: TaxelGrid | None = None,
        population: Layout | None = None,
        sites: Sites | None = None,
        worlds: int = 1,
        finite_strain: bool = True,
        precision: Precision = "double",
        strict: bool = False,
        progress: Progress | None = None,
    ) -> None:
        self.finger, self.strict = finger, boolean("strict", strict)
        finite_strain = boolean("finite_strain", finite_strain)
        self._options = {
            **{"friction": friction, "deepest": deepest, "taxels": taxels},
            **{"population": population, "sites": sites, "worlds": worlds},
            **{"finite_strain": finite_strain, "precision": precision, "strict": strict},
        }
        self.friction = number("friction", friction, at_least=0)
        self.deepest = number("deepest", deepest, above=0, unit="mm")
        most = 1_000_000  # worlds of some 30 kB each
        self.worlds = integer("worlds", worlds, at_least=1, at_most=most)
        instance("finger", finger, Finger, A_FINGER)
        if sites is not None:
            instance("sites", sites, Sites, SOME_SITES)
        self.taxels = TaxelGrid(10, 7) if taxels is None else taxels
        instance("taxels", self.taxels, TaxelGrid, "a grid, as ff.TaxelGrid(10, 7)")
        single = choice("precision", precision, ("double", "single")) == "single"
        stages = Stages(progress)
        with stages.stage("factor") as report:
            solid = operator.operator(finger, half=False, progress=report)
        if sites is None:
            ask = Ask(spikes=TYPES, population=population)
            skin = partial(meshed, solid.space.points, solid.pad, solid.normals, half=False)
            sites = end_organ_sites(ask, finger.pulp, np.zeros(3), direction(STANDARD), skin)
        self.sites = sites
        made = pad_compliance(finger, solid, sites, np.float32 if single else np.float64)
        self.pad = pad = made.pad
        self._facets, self._own = made.facets, dict[Stack, Array]()
        self._soft: Softness | None = None
        self._maps = Maps(made.compliance, made.strain, self.taxels.weights(pad), pad.areas)
        self._bodies = -1
        self._solvers: list[tuple[Any, pad_worlds.Work]] = []
        self._kept = False
        self._state: pad_worlds.Worlds
        self._out: pad_worlds.Readings
        self._made: tuple[tuple[Shape, ...], Shapes] | None = None
        self._factors = Factors(np.array([0.0, 1.0]), np.array([0.0, 1.0]), np.zeros((2, 2, 3)))
        self._rest()
        if finite_strain:
            self._factors = self._finite_strain(progress)

    def _finite_strain(self, progress: Progress | None) -> Factors:
        """Return the factors t: relaxed forces of plates at finite over those at small strain.

        The tables of the plates are those of the mechanics `pressed`, read or solved and kept; they
        are without friction, and so is the pad that is compared.
        """
        pad = TactileFinger(
            self.finger, deepest=2 * self.deepest, sites=self.sites, finite_strain=False
        )
        depths = self.deepest * np.linspace(0.0, 1.0, DEPTHS + 1)
        light = min(int(np.searchsorted(depths, LIGHT)), DEPTHS)
        values = np.zeros((len(ANGLES), len(depths), 3))
        middle = 2  # index in ANGLES of the plate that touches farthest from the border of the pad
        relaxed = 1e4  # seconds in which any finger has relaxed
        for i in sorted(range(len(ANGLES)), key=lambda i: abs(i - middle)):  # the inner ones first
            table = Loop(self.finger, Flat(ANGLES[i]), deepest=self.deepest, progress=progress)
            row, inner = values[i], values[i + np.sign(middle - i)]
            rotation, place = under(ANGLES[i]), table.prepared.touch
            normal = rotation[:, 2]
            for k in range(light, len(depths)):
                touch = pad.step([(Plane(), rotation, place + depths[k] * normal)], relaxed)
                along = float(touch.wrench[0, :3] @ normal)
                if along == 0.0:
                    continue  # as far as nothing is touched, t is 1
                (_, work), frame = pad._solvers[0], pad._out.frame[0, 0]
                _, _, patch, fullness = pad_gaps.penetration(pad.pad, frame, work)
                row[k, 1:] = np.log(patch), fullness
                if touch.valid:
                    row[k, 0] = np.log(table.rest(relaxed, depth=float(depths[k])).force / along)
                else:  # the pad is stiff at its border: in proportion to the plate further inside
                    row[k, 0] = row[k - 1, 0]
                    row[k, 0] *= inner[k, 0] / inner[k - 1, 0] if inner[k - 1, 0] > 0 else 1.0
            row[:light] = row[light]
            row[:light, 0] *= depths[:light] / depths[light]
            pad.reset()
        return Factors(np.array(ANGLES), depths, values)

    def __repr__(self) -> str:
        """Show finger, friction, depth, taxels and worlds, not the arrays."""
        who = self.finger.subject_name or f"{self.finger.width:g} x {self.finger.thickness:g} mm"
        taxels = f"{self.taxels.rows} x {self.taxels.columns} taxels"
        return (
            f"<TactileFinger: {who}, {self.finger.mesh} mesh of {len(self.pad.areas)} vertices; "
            f"friction {self.friction:g}, to {self.deepest:g} mm, {taxels}, "
            f"{len(self.sites.types)} end organs, {self.worlds} worlds>"
        )

    @cached_property
    def units(self) -> RecordedAfferents:
        """Recorded afferents of the end organs, of one world; see `afferents`."""
        return self.afferents()

    def afferents(self, **options: Any) -> RecordedAfferents:
        """Return units of the end organs, to be stepped with the strain of every step of a world.

        Options as of `neural.streaming.RecordedAfferents`.
        """
        types, unit = self.sites.types, self.sites.unit
        if unit is not None:
            types = tuple(types[i] for i in np.unique(unit, return_index=True)[1])
        return RecordedAfferents(types, self.sites.normals, unit=unit, **options)

    def step(self, objects: Sequence[Pose], dt: float) -> Touch:
        """Move the objects to their poses in `dt` s; return what is felt.

        objects: each a shape, its rotation (3, 3) and place (3,) mm in the frame of the finger, or
        with a leading axis of worlds. Between two steps the objects keep their order in the list.

        Raises
        ------
        InputError
            For poses that are none; with `strict`, for a step that is not valid. The state is then
            as before.
        ConvergenceError
            With `strict`, if no contact is found.
        """
        dt = number("dt", dt, at_least=0, unit="s")
        given = poses(objects, self.worlds)
        shapes = self._packed(given.shapes)
        before = self.state() if self.strict else None
        if len(objects) != self._bodies:
            self._allocate(len(objects))
        self._advance(shapes, given.rotation, given.place, dt)
        if before is not None and (self._out.verdict > 0).any():
            verdict = int(self._out.verdict.max())
            self.restore(before)
            message = f"step: {VERDICTS[verdict]}"
            raise (ConvergenceError if verdict == UNSOLVED else InputError)(message)
        return self._touch(leading=given.leading)

    def _advance(self, shapes: Shapes, rotation: Array, place: Array, dt: float) -> None:
        size = -(-self.worlds // len(self._solvers))
        kept, state, out = self._kept and self.worlds == 1, self._state, self._out
        known, soft = (self._maps.compliance, self.pad), self._soft or pad_worlds.RIGID
        move = Moves(shapes, rotation, place, dt, self.deepest, self._factors)

        def part(number: int) -> None:
            solver, work = self._solvers[number]
            first, last = number * size, min((number + 1) * size, self.worlds)
            if self.friction:
                posed_steps.step_with_friction(
                    solver, *known, move, state, out, work, first, last, self.friction
                )
            else:
                posed_steps.step_without_friction(
                    solver, *known, soft, move, state, out, work, first, last, kept
                )

        together(part, range(len(self._solvers)))
        self._kept = True

    def _touch(self, *, leading: bool) -> Touch:
        out, state, pick = self._out, self._state, slice(None) if leading else 0
        bodies = out.bodies[pick]
        return Touch(
            wrench=bodies[..., :6].copy(),
            depth=bodies[..., pad_worlds.DEPTH].copy(),
            contact_area=bodies[..., pad_worlds.AREA].copy(),
            stick_area=bodies[..., pad_worlds.STICK].copy(),
            pressure=out.pressure[pick].copy(),
            traction=out.traction[pick].copy(),
            slip=out.slip[pick].copy(),
            touched=out.touched[pick].copy(),
            verdict=np.array(out.verdict[pick]),
            error=self._error(bodies[..., pad_worlds.DEPTH].max(axis=-1, initial=0.0)),
            linear=state.linear[pick].copy(),
            frame=out.frame[pick].copy(),
            hit=out.hit[pick].copy(),
            stiffness=np.array(out.stiffness[pick]),
            friction=self.friction,
            maps=self._maps,
            soft=self._soft,
        )

    def _error(self, depth: Array) -> TouchError:
        """Return the errors at penetrations in mm."""
        if self._soft is not None or not self._options["finite_strain"]:
            return TouchError(*(np.full_like(depth, np.nan) for _ in TouchError._fields))
        ends, errors = measured_errors()
        band = np.searchsorted(ends, depth)
        return TouchError(*(np.asarray(np.append(each, np.nan)[band]) for each in errors))

    def _packed(self, shapes: tuple[Shape, ...]) -> Shapes:
        """Return the objects as compiled code reads them, and set their flexibility."""
        if self._made is None or self._made[0] != shapes:
            soft = self._softness(shapes)
            self._made, self._soft = (shapes, packed(shapes)), soft
        return self._made[1]

    def _softness(self, shapes: Sequence[Shape]) -> Softness | None:
        """Return the flexibility of objects of which some are soft; None if all are rigid.

        The flexibility of a body is computed once, in some seconds on the standard mesh.
        """
        bodies = [each.soft_body for each in shapes]
        stacks = list(dict.fromkeys(each for each in bodies if each is not None))
        if not stacks:
            return None
        if self.friction:
            raise InputError(
                "objects: expected rigid ones of a finger with friction, received a soft one; "
                "make the finger with friction=0"
            )
        for stack in stacks:
            if stack not in self._own:
                flexible = one_thread(flexibility)
                self._own[stack] = flexible(kernel(stack), self._facets, len(self.pad.areas))
        number = [-1 if each is None else stacks.index(each) for each in bodies]
        matrix = np.array([self._own[stack] for stack in stacks])
        return Softness(matrix, np.array(number, dtype=np.int64))

    def _allocate(self, bodies: int) -> None:
        """Make room for `bodies` objects; earlier poses are forgotten, the skin's past is not."""
        self._bodies = bodies
        empty = pad_worlds.worlds(self.worlds, self.pad, bodies, 3 if self.friction else 1)
        self._state = self._state._replace(
            rotation=empty.rotation, place=empty.place, stepped=empty.stepped
        )
        self._out = pad_worlds.readings(self.worlds, self.pad, bodies)

    def _rest(self) -> None:
        """Allocate everything at rest."""
        components, n = 3 if self.friction else 1, len(self.pad.areas)
        self._bodies = 0
        self._state = pad_worlds.worlds(self.worlds, self.pad, 0, components)
        self._out = pad_worlds.readings(self.worlds, self.pad, 0)
        self._kept = False
        if not self._solvers:
            for _ in range(min(self.worlds, threads())):
                solver: Any
                if self.friction:
                    solver = PosedCoulomb(self._maps.compliance, self.friction)
                else:
                    solver = active_set.lcp_state(np.zeros((n, n)))
                self._solvers.append((solver, pad_worlds.work(self.pad, components)))

    def state(self) -> TouchState:
        """Return a copy of the state of all worlds."""
        return TouchState(tuple(each.copy() for each in self._state))

    def restore(self, state: TouchState) -> None:
        """Return to a state of this finger; InputError for the state of another."""
        instance("state", state, TouchState, "a state of this finger, as its `state()` gives")
        if [a.shape for a in state.arrays[:5]] != [a.shape for a in self._state[:5]]:
            raise InputError(
                "state: expected one of the same finger, friction and worlds, received arrays of "
                "other shapes; restore it where it was made"
            )
        bodies = state.arrays[-2].shape[1]
        if bodies != self._bodies:
            self._allocate(bodies)
        for now, then in zip(self._state, state.arrays, strict=True):
            now[:] = then
        self._kept = False

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle and copy by recipe: the pad is read again from the cache."""
        return again, (self.finger, self._options), self.state()

    def __setstate__(self, state: TouchState) -> None:
        """Restore a state."""
        self.restore(state)

    def reset(self, worlds: Flags | None = None) -> None:
        """Return to rest: all worlds, or those that are flagged (worlds,).

        InputError for flags that are not one of each world.
        """
        flags = np.ones(self.worlds, bool) if worlds is None else np.asarray(worlds)
        if flags.dtype != bool or flags.shape != (self.worlds,):
            raise InputError(
                f"worlds: expected a flag of each of {self.worlds}, true where it is to be at "
                f"rest, received {flags.dtype} of shape {flags.shape}"
            )
        for each in self._state:
            each[flags] = 0
        self._kept = False


def again(finger: Finger, options: dict[str, Any]) -> TactileFinger:
    """Make a tactile finger from its options."""
    return TactileFinger(finger, **options)

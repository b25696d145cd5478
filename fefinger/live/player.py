"""A finger in time, moved by a hand or by a preset; what is played is recorded.

The hand sets where the object is to be; the object follows as a damped mass would, without
overshoot. A preset is a motion as of a scene, from the present state of the finger. A `Setup` is
what can be chosen on the page: subject, object, mechanics, units.
"""

import math
from array import array
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from functools import partial
from typing import Any, Self

import numpy as np

from fefinger.fem.body import solid
from fefinger.geometry.finger_mesh import SKIN, SUBCUTANEOUS
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.loop_setup import MECHANICS, PRESSED
from fefinger.mechanics.press.mesh_limits import needs_continuation, refinement_location
from fefinger.mechanics.press.sites import end_organ_sites, meshed
from fefinger.mesh.store import load_or_build
from fefinger.neural.stepped import SteppedUnits
from fefinger.results.records import Sites
from fefinger.scene import library
from fefinger.scene.ask import Ask, Scatter
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, direction
from fefinger.scene.indenters import STANDARD, Bar, Cylinder, Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold, RampSinusoid, Trapezoid
from fefinger.scene.samples import Sampled
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import (
    ConvergenceError,
    InputError,
    boolean,
    choice,
    number,
    reject_unknown,
)
from fefinger.support.progress import Progress
from fefinger.support.vocabulary import TYPES, Control


PLATE, BALL, CYLINDER, BAR = OBJECTS = ("plate", "ball", "cylinder", "bar")

ONE, MANY = UNITS = ("4 units", "population")
"""One unit of each type under first touch, or some 300 about it."""

DEEPEST = 1.5
"""Depth in mm to which the finger may be pressed."""

STEEPEST = 45.0
"""Largest angle in degrees of a plate here; contact on the tip of a steeper one is shallow."""

SIZES = (0.5, 20.0)
"""Least and largest radius of a ball or a cylinder, and width of a bar, in mm."""

MODULI = (5.0, 2000.0)
"""Least and largest modulus in kPa of a soft object."""


@dataclass(frozen=True)
class Setup:
    """A choice of the page.

    kind: of the object; angle: degrees of a plate; size: mm, radius of a ball or cylinder, width of
    a bar; along: a cylinder or bar lies along the finger instead of across; modulus: kPa of a soft
    plate, ball or cylinder, None of a rigid one. InputError for a value out of its limits.
    """

    subject: str = "a.h."
    kind: str = PLATE
    angle: float = 30.0
    size: float = 5.0
    along: bool = False
    modulus: float | None = None
    mechanics: str = PRESSED
    units: str = ONE

    def __post_init__(self) -> None:
        """Check every value."""
        choice("subject", self.subject, subjects())
        choice("kind", self.kind, OBJECTS)
        number("angle", self.angle, at_least=0, at_most=STEEPEST, unit="degrees")
        number("size", self.size, at_least=SIZES[0], at_most=SIZES[1], unit="mm")
        boolean("along", self.along)
        if self.modulus is not None:
            number("modulus", self.modulus, at_least=MODULI[0], at_most=MODULI[1], unit="kPa")
        choice("mechanics", self.mechanics, MECHANICS)
        choice("units", self.units, UNITS)

    @classmethod
    def of(cls, table: Mapping[str, object]) -> Self:
        """Read a choice from a message; what it leaves out has its default."""
        reject_unknown("setup", table, [field.name for field in fields(cls)])
        given: dict[str, Any] = dict(table)  # checked in __post_init__
        return cls(**given)

    def to_dict(self) -> dict[str, object]:
        """Convert to plain values."""
        return asdict(self)

    def finger(self, resolution: str) -> Finger:
        """Return the finger on a mesh of this resolution."""
        return Finger.subject(self.subject, resolution=resolution)

    @property
    def indenter(self) -> Indenter:
        """The object."""
        roll = 90.0 if self.along else 0.0
        if self.kind == PLATE:
            return Flat(float(self.angle), modulus=self.modulus)
        if self.kind == BALL:
            return Sphere(float(self.size), modulus=self.modulus)
        if self.kind == CYLINDER:
            return Cylinder(float(self.size), roll, modulus=self.modulus)
        rounded = 0.2  # radius of the corners of a bar over its width
        return Bar(float(self.size), rounded * self.size, roll)

    @property
    def ask(self) -> Ask:
        """What a scene of it asks for."""
        radius = 6.0  # radius in mm of the population
        population = Scatter(radius=radius) if self.units == MANY else None
        return Ask(spikes=TYPES, population=population, mechanics=self.mechanics)

    def loop(self, resolution: str, progress: Progress | None = None) -> Loop:
        """Prepare the loop; errors as of `Loop`."""
        sites = population_sites(self, resolution) if self.units == MANY else None
        return Loop(
            self.finger(resolution),
            self.indenter,
            mechanics=self.mechanics,
            deepest=DEEPEST,
            sites=sites,
            progress=progress,
        )


def subjects() -> tuple[str, ...]:
    """Return the names of the subjects whose fingers were measured."""
    return tuple(library.lumped())


def population_sites(setup: Setup, resolution: str) -> Sites:
    """Return the end organs of the population of a choice, at the places that a run gives them."""
    finger, indenter, ask = setup.finger(resolution), setup.indenter, setup.ask
    touch = refinement_location(indenter) if setup.mechanics == PRESSED else None
    long = needs_continuation(finger, indenter, Ramp(1.0, DEEPEST, corner=0.0))
    mesh = load_or_build(finger, half=True, touch=touch, with_continuation=long)
    body = solid(mesh, (SKIN, SUBCUTANEOUS))
    skin = partial(meshed, body.space.points, body.pad, body.normals, half=True)
    return end_organ_sites(ask, finger.pulp, np.zeros(3), direction(STANDARD), skin)


DT = 1e-3
"""Step in s of the model."""

ABOVE = -0.5
"""Depth in mm of an object that is lifted: off the skin."""

RELAXED = 1e3
"""Time in s after which the force at a held depth falls no more, to some percent."""

TAP, HOLD, FLUTTER, VIBRATE = PRESETS = ("tap", "ramp and hold", "40 Hz", "250 Hz")


def preset(name: str, control: Control, most: float) -> Motion:
    """Return a preset by its name, for a depth of at most `most` mm, or a force of as many N."""
    level, pace = 0.5 * most, control.pace
    slow: dict[str, float] = {control: level, pace: level / 0.2}
    if name == TAP:
        return Trapezoid(**{control: level, pace: level / 0.03}, hold=0.04)
    if name == HOLD:
        return RampHold(**slow, hold=2.0)
    if name == FLUTTER:
        return RampSinusoid(**slow, amplitude=0.1 * level, frequency=40.0, cycles=60)
    return RampSinusoid(**slow, amplitude=0.02 * level, frequency=250.0, cycles=375)


@dataclass
class Take:
    """What was played since a record began at rest: time in s, depth in mm and force in N."""

    setup: Setup
    by_force: bool
    time: "array[float]" = field(default_factory=lambda: array("d", [0.0]))
    depth: "array[float]" = field(default_factory=lambda: array("d"))
    force: "array[float]" = field(default_factory=lambda: array("d", [0.0]))

    @property
    def seconds(self) -> float:
        """Length in s."""
        return self.time[-1]

    @property
    def peak(self) -> float:
        """Largest force in N."""
        return max(self.force)

    def scene(self, name: str, resolution: str) -> Scene:
        """Return the scene that repeats it; InputError where the finger was not touched.

        It prescribes the force if that alone was controlled, and else the depth.
        """
        if self.peak <= 0.0:
            raise InputError(
                "record: expected a touch, received a record without contact; press the finger "
                "while it is recorded"
            )
        time, depth, force = map(tuple, (self.time, self.depth, self.force))
        motion = Sampled(time, force=force) if self.by_force else Sampled(time, depth)
        return Scene(
            name=name,
            finger=self.setup.finger(resolution),
            indenter=self.setup.indenter,
            motion=motion,
            ask=self.setup.ask,
        )


@dataclass(frozen=True)
class Heard:
    """What happened since it was last asked for.

    trace (n, 3): time in s, depth in mm and force in N of each step; spikes: (unit, time in s).
    """

    trace: Array
    spikes: tuple[tuple[int, float], ...]


class Player:
    """A finger of a choice, stepped at DT.

    Attributes
    ----------
    loop, units
        The finger, and its afferent units.
    most
        Largest depth in mm and force in N that can be held.
    control, value
        What the object is moved by, and where it is, in mm or N.
    take
        The record, and whether it goes on in `recording`.
    time, dt
        Time since rest, and length of the next step, in s.
    """

    def __init__(self, setup: Setup, loop: Loop) -> None:
        self.setup, self.loop = setup, loop
        self.units: SteppedUnits = loop.afferents()
        relaxed = loop.rest(RELAXED, depth=DEEPEST).force
        self.most: Mapping[Control, float] = {Control.DEPTH: DEEPEST, Control.FORCE: relaxed}
        self.take: Take | None = None
        self.control, self.recording = Control.DEPTH, False
        self._played: list[float] = []
        self.rest()

    def rest(self) -> None:
        """Lift the object off, and bring finger and units to rest at time 0."""
        self.loop.reset()
        self.units.reset()
        self.time, self._speed, self.dt = 0.0, 0.0, DT
        self._played.clear()
        self._trace, self._spikes = array("d"), list[tuple[int, float]]()
        self.value = self.target = self.control.of(ABOVE, 0.0)
        self._waiting: Motion | None = None

    def move(self, control: Control, value: float) -> None:
        """Have the object follow the hand to a depth in mm or a force in N; a preset ends.

        Values beyond what can be held are taken as the last that can.
        """
        self._switch(control)
        self._stop()
        self.target = min(max(value, control.of(ABOVE, 0.0)), self.most[control])

    def play(self, name: str) -> None:
        """Play a preset once the object has come to first touch."""
        self._stop()
        self._waiting = preset(name, self.control, self.most[self.control])
        self.target = 0.0

    def record(self) -> None:
        """Begin a record, at rest."""
        self.rest()
        self.take, self.recording = Take(self.setup, self.control is Control.FORCE), True
        self.take.depth.append(self.value if self.control is Control.DEPTH else 0.0)

    @property
    def playing(self) -> bool:
        """Whether a preset is played."""
        return bool(self._played) or self._waiting is not None

    def step(self) -> None:
        """Advance by a step.

        InputError or ConvergenceError where the finger cannot: it is then as it was before, and
        the object rests at its depth.
        """
        dt, value = self.dt, self._next()
        try:
            depth, force = self.control.of((value, None), (None, value))
            now = self.loop.step(dt, depth=depth, force=force)
        except (InputError, ConvergenceError):
            self._stop()
            self.control, self._speed = Control.DEPTH, 0.0
            self.value = self.target = self.loop.now.depth
            raise
        self.value = value
        self.time += dt
        if self.units.step(now.strain, dt):
            self._spikes += self.units.fired()
        row = self.time, now.depth, now.force
        self._trace.extend(row)
        if self.recording:
            self._keep(row)

    def heard(self) -> Heard:
        """Return the trace and the spikes since the last call."""
        trace, spikes = np.array(self._trace).reshape(-1, 3), tuple(self._spikes)
        self._trace, self._spikes = array("d"), []
        return Heard(trace, spikes)

    def _keep(self, row: tuple[float, float, float]) -> None:
        take = self.take
        assert take is not None
        take.by_force &= self.control is Control.FORCE
        for column, value in zip((take.time, take.depth, take.force), row, strict=True):
            column.append(value)
        longest = 60.0  # longest record in s
        self.recording = take.seconds < longest

    def _switch(self, control: Control) -> None:
        """Go on by the other control from where the object is."""
        if control is not self.control:
            now = self.loop.now
            self.control, self._speed = control, 0.0
            self.value = self.target = control.of(now.depth, now.force)

    def _stop(self) -> None:
        """End a preset."""
        self._played.clear()
        self._waiting, self.dt = None, DT

    def _next(self) -> float:
        """Return where the object is after the next step."""
        if self._waiting is not None and abs(self.value) < 1e-3 * self.most[self.control]:
            motion, self._waiting = self._waiting, None
            # Least number of steps in a cycle of a vibration, whose steps are shorter.
            per_cycle = 16
            self.dt = min(DT, 1.0 / (per_cycle * (motion.highest_frequency or 1.0)))
            count = math.ceil(motion.duration / self.dt)
            times = np.minimum(self.dt * np.arange(count, 0, -1), motion.duration)
            self._played = np.asarray(motion.value(times)).tolist()
        if not self._played:
            return self._follow()
        value = self._played.pop()
        if not self._played:
            self._stop()
            self._speed, self.target = 0.0, self.control.of(ABOVE, 0.0)
        return max(value, 0.0) if self.control is Control.FORCE else value

    def _follow(self) -> float:
        """Return the place of a critically damped mass that is drawn to the target."""
        away, dt = self.value - self.target, self.dt
        # Rate in 1/s of the damped mass by which the object follows the hand: 90 % of a step in 65
        # ms.
        response = 60.0
        push = self._speed + response * away
        left = math.exp(-response * dt)
        self._speed = (self._speed - response * push * dt) * left
        value = self.target + (away + push * dt) * left
        return max(value, 0.0) if self.control is Control.FORCE else value

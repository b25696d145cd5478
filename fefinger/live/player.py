"""A finger in time, moved by a hand or by a preset; what is played is recorded.

The hand sets where the object is to be; the object follows as a damped mass would, without
overshoot. A preset is a motion as of a scene, from the present state of the finger.
"""

import math
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fefinger.live.setup import DEEPEST, Setup
from fefinger.mechanics.loop import Loop
from fefinger.neural.stepped import SteppedUnits
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold, RampSinusoid, Trapezoid
from fefinger.scene.samples import Sampled
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.vocabulary import Control


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
        for column, number in zip((take.time, take.depth, take.force), row, strict=True):
            column.append(number)
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

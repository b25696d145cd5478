"""The motions of a scene: ramps, holds, sinusoids and samples, of depth in mm or force in N.

How a class moves is in its base, a shape of `motion.py`; a class holds the fields that its
base leaves open, as the name of what is controlled.
"""

from dataclasses import KW_ONLY, dataclass
from typing import Annotated, final

from fefinger.scene.key import Key
from fefinger.scene.motion import (
    AS_LONG_AS_FITS,
    Motion,
    RampHoldMotion,
    RampMotion,
    RampSinusoidMotion,
    SinusoidMotion,
    SweepMotion,
    TrapezoidMotion,
)
from fefinger.scene.samples import SampledMotion
from fefinger.scene.sliding import SampledPathMotion, SlideMotion
from fefinger.support.checks import InputError


MOST_CYCLES = 1_000_000
"""Largest number of cycles of a vibration; far fewer have the time steps that memory holds."""

APPROACH = 10.0
"""Speed in mm/s, or rate in N/s, with which a vibrating probe takes its preload; it has left no
trace when the vibration begins."""

Depths = Annotated[tuple[float, ...], Key("Depths; below 0 the object is off the skin", unit="mm")]
Forces = Annotated[tuple[float, ...], Key("Forces, none below 0", unit="N")]


@final
@dataclass(frozen=True)
class Ramp(RampMotion):
    """A ramp from rest at `speed` mm/s to `depth` mm, which ends while moving."""

    kind = "ramp"

    speed: float
    depth: float
    _: KW_ONLY
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class RampHold(RampHoldMotion):
    """A ramp at `speed` mm/s to `depth` mm, and then a rest of `hold` s."""

    kind = "ramp-hold"

    speed: float
    depth: float
    _: KW_ONLY
    hold: float
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class Trapezoid(TrapezoidMotion):
    """A ramp at `speed` mm/s to `depth` mm, a rest of `hold` s, and the same ramp back to 0."""

    kind = "trapezoid"

    speed: float
    depth: float
    _: KW_ONLY
    hold: float
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class RampSinusoid(RampSinusoidMotion):
    """A ramp at `speed` mm/s to `depth` mm, `settle` s of rest, then a sine about that depth.

    The sine starts upward (`cycles` whole ones of `amplitude` mm at `frequency` Hz); its amplitude
    rises over `corner` s, which keeps the speed continuous, or is there at once if corner is 0.
    An amplitude above `depth` lifts the indenter off the finger.
    """

    kind = "ramp-sinusoid"

    speed: float
    depth: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    cycles: int
    settle: float = 0.0
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class Sinusoid(SinusoidMotion):
    """Depths amplitude (1 - cos(2 pi frequency t)) in mm: from first touch, at rest at both ends.

    `amplitude` in mm is half of the largest depth, `frequency` in Hz, `cycles` whole ones (Pawluk
    1997, Eq. 4.1 and 4.2 as appendix B starts them).
    """

    kind = "sinusoid"


@final
@dataclass(frozen=True)
class Vibration(RampSinusoidMotion):
    """A preload of `preload` mm, held for `held` s, then a sine about it for `seconds`.

    The experiment of vibrotaction: spikes count from the start of the sine, when the units have
    adapted to the preload. The sine (whole cycles of `amplitude` mm at `frequency` Hz, one or more)
    starts upward; its amplitude rises over `corner` s.
    """

    kind = "vibration"

    preload: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    seconds: float = 1.0
    held: float = 120.0
    corner: float = AS_LONG_AS_FITS

    @property
    def level(self) -> float:
        """The preload in mm."""
        return self.preload

    @property
    def ramp_duration(self) -> float:
        """Length of the approach in s."""
        return self.preload / APPROACH

    @property
    def settle_duration(self) -> float:
        """Length of the hold in s."""
        return self.held

    @property
    def n_cycles(self) -> int:
        """Number of cycles: whole ones, nearest to `seconds`."""
        cycles = self.seconds * self.frequency
        if cycles > MOST_CYCLES:
            raise InputError(
                f"motion.frequency: expected at most {MOST_CYCLES:g} cycles in motion.seconds, "
                f"received {self.frequency:g} Hz for {self.seconds:g} s"
            )
        return max(1, round(cycles))

    @property
    def recorded_from(self) -> float:
        """The start of the sine in s."""
        return self.ramp_and_rest(self.held).duration


@final
@dataclass(frozen=True)
class FrequencySweep(SweepMotion):
    """A preload of `depth` mm, and a sine about it from `start` Hz to `stop` Hz in `seconds`.

    `amplitude` in mm; the frequency changes evenly per octave, after a rest of `settle` s. The
    result has the harmonic answer about the preload as well.
    """

    kind = "sweep"

    depth: float
    _: KW_ONLY
    amplitude: float
    start: float
    stop: float
    seconds: float = 2.0
    settle: float = 1.0
    speed: float = APPROACH
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class ForceSweep(SweepMotion):
    """As `FrequencySweep`, with a preload of `force` N and an amplitude in N below it."""

    kind = "force-sweep"
    control = "force"

    force: float
    _: KW_ONLY
    amplitude: float
    start: float
    stop: float
    seconds: float = 2.0
    settle: float = 1.0
    loading_rate: float = APPROACH
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class Sampled(SampledMotion):
    """Depths in mm at times in s, joined by straight lines, rounded only if a corner is given.

    The times start at 0 and increase; below a depth of 0 the indenter is off the finger.
    """

    kind = "sampled"

    depth: Depths


@final
@dataclass(frozen=True)
class ForceRamp(RampMotion):
    """A ramp of the force from 0 at `loading_rate` N/s to `force` N, which ends while rising."""

    kind = "force-ramp"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class ForceRampHold(RampHoldMotion):
    """A ramp of the force at `loading_rate` N/s to `force` N, and then `hold` s at that force."""

    kind = "force-ramp-hold"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    hold: float
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class ForceTrapezoid(TrapezoidMotion):
    """A ramp of the force at `loading_rate` N/s to `force` N, `hold` s there, and back to 0."""

    kind = "force-trapezoid"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    hold: float
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class ForceRampSinusoid(RampSinusoidMotion):
    """As `RampSinusoid`, with a force in N at `loading_rate` N/s; amplitude below the force."""

    kind = "force-ramp-sinusoid"
    control = "force"

    loading_rate: float
    force: float
    _: KW_ONLY
    amplitude: float
    frequency: float
    cycles: int
    settle: float = 0.0
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class ForceSinusoid(SinusoidMotion):
    """As `Sinusoid`, with forces in N: from none to twice the amplitude."""

    kind = "force-sinusoid"
    control = "force"


@final
@dataclass(frozen=True)
class ForceSampled(SampledMotion):
    """Forces in N, none below 0, at times in s, joined by straight lines."""

    kind = "force-sampled"
    control = "force"

    force: Forces


@final
@dataclass(frozen=True)
class Slide(SlideMotion):
    """A press of `depth` mm and `passes` of `distance` mm at `speed` mm/s along `direction`.

    `direction` in degrees: 0 moves the object distally, 90 radially; a second pass returns.
    The press takes `approach` mm/s, and rests for `settle` s before the slide, from which on spikes
    count. All ramps are rounded by `corner` s.
    """

    kind = "slide"

    speed: float
    depth: float
    _: KW_ONLY
    distance: float
    direction: float = 0.0
    passes: int = 1
    settle: float = 0.5
    approach: float = APPROACH
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class ForceSlide(SlideMotion):
    """As `Slide`, under a force of `force` N that is taken at `approach` N/s."""

    kind = "force-slide"
    control = "force"

    speed: float
    force: float
    _: KW_ONLY
    distance: float
    direction: float = 0.0
    passes: int = 1
    settle: float = 0.5
    approach: float = 5.0
    corner: float = AS_LONG_AS_FITS


@final
@dataclass(frozen=True)
class SampledPath(SampledPathMotion):
    """Places x and y in mm across the travel and depths in mm at times in s, joined by lines."""

    kind = "sampled-path"

    depth: Depths


@final
@dataclass(frozen=True)
class ForceSampledPath(SampledPathMotion):
    """Places x and y in mm across the travel and forces in N at times in s, joined by lines."""

    kind = "force-sampled-path"
    control = "force"

    force: Forces


MOTIONS: dict[str, type[Motion]] = {
    motion.kind: motion
    for motion in (
        *(Ramp, RampHold, RampSinusoid, Sinusoid, Trapezoid, Vibration, FrequencySweep, Sampled),
        *(ForceRamp, ForceRampHold, ForceRampSinusoid, ForceSinusoid, ForceTrapezoid),
        *(ForceSweep, ForceSampled, Slide, ForceSlide, SampledPath, ForceSampledPath),
    )
}

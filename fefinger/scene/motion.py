"""The motions of a scene: ramps, holds, sinusoids and samples, of depth in mm or force in N.

Each one is a shape of `shapes.py`; the depth and the force kind share it and its `Trajectory`.
"""

from dataclasses import dataclass

from fefinger.scene.motion_shapes import (
    DepthMotion,
    ForceMotion,
    RampHoldShape,
    RampShape,
    RampSinusoidShape,
    SinusoidShape,
    TrapezoidShape,
)
from fefinger.scene.motion_shapes import Motion as Motion
from fefinger.scene.motion_shapes import SampledMotion as SampledMotion


@dataclass(frozen=True)
class Ramp(RampShape, DepthMotion):
    """A ramp from rest at `speed` mm/s to `depth` mm, which ends while moving."""

    kind = "ramp"


@dataclass(frozen=True)
class RampHold(RampHoldShape, DepthMotion):
    """A ramp at `speed` mm/s to `depth` mm, and then a rest of `hold` s."""

    kind = "ramp-hold"


@dataclass(frozen=True)
class Trapezoid(TrapezoidShape, DepthMotion):
    """A ramp at `speed` mm/s to `depth` mm, a rest of `hold` s, and the same ramp back to 0."""

    kind = "trapezoid"


@dataclass(frozen=True)
class RampSinusoid(RampSinusoidShape, DepthMotion):
    """A ramp at `speed` mm/s to `depth` mm, `settle` s of rest, then a sine about that depth.

    The sine starts upward (`cycles` whole ones of `amplitude` mm at `frequency` Hz); its amplitude
    rises over `corner` s, which keeps the speed continuous, or is there at once if corner is 0.
    An amplitude above `depth` lifts the indenter off the finger.
    """

    kind = "ramp-sinusoid"


@dataclass(frozen=True)
class Sinusoid(SinusoidShape):
    """Depths amplitude (1 - cos(2 pi frequency t)) in mm: from first touch, at rest at both ends.

    `amplitude` in mm is half of the largest depth, `frequency` in Hz, `cycles` whole ones (Pawluk
    1997, Eq. 4.1 and 4.2 as appendix B starts them).
    """

    kind = "sinusoid"
    control = "depth"


@dataclass(frozen=True)
class Sampled(SampledMotion):
    """Depths in mm at times in s, joined by straight lines, rounded only if a corner is given.

    The times start at 0 and increase; below a depth of 0 the indenter is off the finger.
    """

    kind = "sampled"
    control = "depth"

    depth: tuple[float, ...]


@dataclass(frozen=True)
class ForceRamp(RampShape, ForceMotion):
    """A ramp of the force from 0 at `loading_rate` N/s to `force` N, which ends while rising."""

    kind = "force-ramp"


@dataclass(frozen=True)
class ForceRampHold(RampHoldShape, ForceMotion):
    """A ramp of the force at `loading_rate` N/s to `force` N, and then `hold` s at that force."""

    kind = "force-ramp-hold"


@dataclass(frozen=True)
class ForceTrapezoid(TrapezoidShape, ForceMotion):
    """A ramp of the force at `loading_rate` N/s to `force` N, `hold` s there, and back to 0."""

    kind = "force-trapezoid"


@dataclass(frozen=True)
class ForceRampSinusoid(RampSinusoidShape, ForceMotion):
    """As `RampSinusoid`, with a force in N at `loading_rate` N/s; amplitude below the force."""

    kind = "force-ramp-sinusoid"


@dataclass(frozen=True)
class ForceSinusoid(SinusoidShape):
    """As `Sinusoid`, with forces in N: from none to twice the amplitude."""

    kind = "force-sinusoid"
    control = "force"


@dataclass(frozen=True)
class ForceSampled(SampledMotion):
    """Forces in N, none below 0, at times in s, joined by straight lines."""

    kind = "force-sampled"
    control = "force"

    force: tuple[float, ...]


MOTIONS: dict[str, type[Motion]] = {
    motion.kind: motion
    for motion in (
        Ramp,
        RampHold,
        RampSinusoid,
        Sinusoid,
        Trapezoid,
        Sampled,
        ForceRamp,
        ForceRampHold,
        ForceRampSinusoid,
        ForceSinusoid,
        ForceTrapezoid,
        ForceSampled,
    )
}

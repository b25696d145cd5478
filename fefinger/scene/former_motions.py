"""The motions of force before `force=`, for one version: constructors that say what to write."""

import warnings
from collections.abc import Callable
from typing import Any, TypeVar

from fefinger.scene.motion import Motion
from fefinger.scene.motions import (
    FrequencySweep,
    Ramp,
    RampHold,
    RampSinusoid,
    Sinusoid,
    Trapezoid,
)
from fefinger.scene.samples import Sampled
from fefinger.scene.sliding import SampledPath, Slide
from fefinger.support.vocabulary import Control


Made = TypeVar("Made", bound=Motion)


def _former(name: str, motion: type[Made], *order: str, **fixed: Any) -> Callable[..., Made]:
    """Return the constructor of a former class, whose arguments by place have the names `order`."""

    def make(*values: Any, **named: Any) -> Made:
        keys = "control" if fixed else "force"
        warnings.warn(
            f"ff.{name} is ff.{motion.__name__} with {keys}= now, and goes with the next version",
            DeprecationWarning,
            stacklevel=2,
        )
        return motion(**dict(zip(order, values, strict=False)), **named, **fixed)

    return make


RATE_AND_FORCE = ("loading_rate", "force")
ForceRamp = _former("ForceRamp", Ramp, *RATE_AND_FORCE)
ForceRampHold = _former("ForceRampHold", RampHold, *RATE_AND_FORCE)
ForceTrapezoid = _former("ForceTrapezoid", Trapezoid, *RATE_AND_FORCE)
ForceRampSinusoid = _former("ForceRampSinusoid", RampSinusoid, *RATE_AND_FORCE)
ForceSinusoid = _former(
    *("ForceSinusoid", Sinusoid, "amplitude", "frequency", "cycles"), control=Control.FORCE
)
ForceSweep = _former("ForceSweep", FrequencySweep, "force")
ForceSampled = _former("ForceSampled", Sampled, "time", "force")
ForceSlide = _former("ForceSlide", Slide, "speed", "force")
ForceSampledPath = _former("ForceSampledPath", SampledPath, "time", "x", "y", "force")

"""How quasi-static a scene is: the pace of the indenter against that of shear waves in the tissue.

No mechanics has inertia. A layer of thickness h whose surface is moved at the frequency f is off by
1 / cos(2 pi f h / c) - 1, with c the speed of shear waves, and a body moved at the speed v by some
(v / c)²; the limits here keep both to 5 %.
"""

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray


if TYPE_CHECKING:
    from fefinger.scene.finger import Finger
    from fefinger.scene.motion import Motion
    from fefinger.scene.scene import Scene


Array = NDArray[np.float64]

DENSITY = 1e-6
"""kg/mm³ of soft tissue, as that of water."""

FAST = 0.22
"""Speed of the indenter over that of shear waves, beyond which inertia may be 5 % of the force."""

QUICK = 0.05
"""Frequency times the thickness of the tissue over that speed, beyond which it may."""


def wave_speed(finger: "Finger") -> float:
    """Return the speed in mm/s of shear waves in the relaxed subcutaneous tissue, the slowest.

    sqrt(G / density) with G = E / (2 (1 + nu)): 3.39 m/s for E = 34 kPa and nu = 0.48. The kPa are
    1e3 kg / (m s²), or kg / (mm s²).
    """
    tissue = finger.subcutaneous
    return math.sqrt(tissue.modulus / (2 * (1 + tissue.poisson)) / DENSITY)


def jump(motion: "Motion") -> tuple[str, ...]:
    """Return a warning if a motion does not start from first touch."""
    start = float(motion.value(np.zeros(1))[0])
    if start <= 0:
        return ()
    unit = "N" if motion.control == "force" else "mm"
    return (
        f"Warning: the motion starts at {start:.3g} {unit}, which the indenter reaches at once; "
        "let it start from 0.",
    )


def quasistatic(scene: "Scene", time: Array, depth: Array) -> tuple[str, ...]:
    """Return a warning if what moved as depth (n_t,) mm at times (n_t,) s was too fast for statics.

    The speed is that of the answer, so that force control has one too; a jump has none.
    """
    step = np.diff(time)
    moved = np.abs(np.diff(depth)) / np.where(step > 0, step, np.inf)
    speed, wave = float(moved.max(initial=0.0)), wave_speed(scene.finger)
    frequency = getattr(scene.motion, "frequency", 0.0)
    found = []
    if speed > FAST * wave:
        found.append(
            f"speed / wave speed = {1e-3 * speed:.3g} / {1e-3 * wave:.3g} m/s = "
            f"{speed / wave:.2g} > {FAST:g}"
        )
    thick = frequency * scene.finger.pulp
    if thick > QUICK * wave:
        found.append(
            f"frequency x thickness / wave speed = {frequency:g} Hz x {scene.finger.pulp:.3g} mm / "
            f"{1e-3 * wave:.3g} m/s = {thick / wave:.2g} > {QUICK:g}"
        )
    if not found:
        return ()
    return (f"Warning: not quasi-static, {' and '.join(found)}; inertia and waves are left out.",)

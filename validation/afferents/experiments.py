"""The experiments behind the data: finger, probe and end organs, and the drives that they give.

Every experiment is pressed through the mechanics of the package. A macaque fingertip stands for all
of them: 10 mm wide, 8 mm thick, with an effective pad radius of 10 mm: an estimate from the look of
published fingertips (confidence low). End organs of SAI are 0.45 mm deep, at the base of an
epidermis of 0.3 to 0.5 mm (confidence low; of 0.4, 0.45, 0.5 and 0.6 mm, those where the fit, the
edges of a bar and the holds of a wide pin agree), those of FAI 0.5 mm, the others as in people.

All are pressed at finite strain, on tissue that stiffens as that of four measured fingers, with a
skin that is 3 times as stiff as the pulp (`library.macaque`). With this skin rates of SAI under
vibrations have R2 .94 and those under spheres an error of 16 %; with 2.9 times the exponent of the
pulp .90 and 16 %; with the ratios of the calibrated fingers (10 times as stiff, 2.9 times the
exponent) .78 and 17 %. At small strain, on tissue that does not stiffen, a pin 1 mm wide strains
the end organs below it 1.3 to 1.9 times as much from 0.5 to 1.5 mm on, and a sphere or a plate 0.5
to 0.7 times: the gains of probes and of spheres would not be those of one unit.
"""

from functools import cache
from typing import Any

import numpy as np

from fefinger.mechanics import get
from fefinger.neural.drives import DRIVE_BY_NAME
from fefinger.plan import choose, settled
from fefinger.scene.ask import Ask, Places, innervation
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Flat, Pin, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp, RampHold
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


SOFT = Finger(width=10.0, thickness=8.0, tissue="macaque", resolution="coarse")
"""The fingertip. The coarse mesh gives strains under spheres to 4 %, under the probe to 20 %."""

MACAQUE = Finger(
    width=10.0, thickness=8.0, pad_radius=10.0, tissue="maeno1998", resolution="standard"
)
"""The same at small strain, for what finite strain is not at hand for: patterns, and sliding."""

EDGE = 4.5
"""mm across the finger from the middle of the pad, as far as it has end organs."""

DEPTHS = {kind: receptor.depth for kind, receptor in innervation().items()} | {
    "SAI": 0.45,
    "FAI": 0.5,
}
"""Depths in mm of the end organs."""

PROBE = Pin(1.0)
"""The probe of the vibrations: 1 mm wide, its edge rounded to 0.2 mm."""

PRELOAD = 0.5
"""Depth in mm about which the probe vibrates."""

HELD = 120.0
"""Time in s for which the preload was held before: minutes, taken to be two."""

LOADING = 5.0
"""N/s with which a sphere touches down: some 20 to 40 mm/s on this finger."""


BAR = Bar(3.0, 0.2, roll=90.0)
"""The bar of Phillips & Johnson (1981): 3 mm wide; along the finger."""

SLOW = 1.0
"""mm/s of slow presses: strain does not relax under a given depth, so one serves all motions."""


def drives(
    indenter: Indenter,
    motion: Motion,
    distances: Array,
    *,
    drive: str,
    organ: float,
    mechanics: str = "pressed",
    finger: Finger = SOFT,
) -> tuple[Array, Array, Array]:
    """Time (n_t,) s, depth (n_t,) mm and drives (n_t, n) of end organs in an experiment.

    They lie `organ` mm below places at distances (n,) mm across the finger from first touch.
    """
    scene = Scene(
        finger=finger,
        indenter=indenter,
        motion=motion,
        ask=Ask(
            spikes=("SAI",),
            population=Places(places=tuple((0.0, float(y)) for y in distances), branched=False),
            depths={"SAI": organ},
            fields=False,
            pressure=False,
            rel_error=1.0,
        ),
    )
    response = get(mechanics).respond(settled(scene, choose(scene, mechanics)))
    assert response.strain is not None
    assert response.sites is not None
    driven = DRIVE_BY_NAME[drive](response.strain, response.sites.normals)
    return response.time, response.depth, driven


def pressed(indenter: Indenter, depths: Array, distances: Array, **options: Any) -> Array:
    """Drives (n_depths, n) of end organs at depths (n_depths,) mm of a slow press.

    Options as of `drives`.
    """
    motion = Ramp(SLOW, float(np.max(depths)), corner=0.0)
    _, depth, driven = drives(indenter, motion, distances, **options)
    return np.array([np.interp(depths, depth, column) for column in driven.T]).T


@cache
def probe_drive(drive: str, organ: float) -> tuple[float, float]:
    """Drive under the probe at the preload, and its slope per mm there."""
    step = 0.02
    depths = np.array([PRELOAD - step, PRELOAD, PRELOAD + step])
    low, middle, high = pressed(PROBE, depths, np.zeros(1), drive=drive, organ=organ)[:, 0]
    return float(middle), float((high - low) / (2 * step))


def under_sphere(
    curvature: float, force: float, distances: Array, *, drive: str, organ: float
) -> tuple[Array, Array]:
    """Time (n_t,) s and drives (n_t, n) under a sphere of `curvature` 1/m held with `force` N.

    Places beyond EDGE count as there.
    """
    indenter: Indenter = Flat(30) if curvature == 0 else Sphere(1e3 / curvature)
    motion = RampHold(loading_rate=LOADING, force=force, hold=1.0, corner=0.0)
    places, which = np.unique(np.minimum(distances, EDGE), return_inverse=True)
    time, _, driven = drives(indenter, motion, places, drive=drive, organ=organ)
    return time, driven[:, which]

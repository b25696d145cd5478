"""How much of the mean force on raised dots is due to the mesh, while they are scanned."""

from functools import cache

import numpy as np
from scipy.optimize import brentq

from fefinger.mechanics import condensed
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.scene.sliding import Slide
from fefinger.scene.textured import Dots


MESHES = ("coarse", "standard", "fine")
FACETS = (0.87, 0.47, 0.33)  # mm, mean edges within 4 mm of first touch
SCAN = Slide(60, 0.8, distance=12, direction=180, settle=0.1)


@cache
def mean_force(mesh: str) -> float:
    """Return the mean force in N on dots 3 mm apart, over the scan."""
    finger = Finger.subject("a.h.", resolution=mesh, tissue="maeno1998")
    ask = Ask(fields=False, pressure=False, strain=False)
    response = condensed.respond(Scene(finger=finger, indenter=Dots(3.0), motion=SCAN, ask=ask))
    slides = response.time >= SCAN.recorded_from
    time, force = response.time[slides], response.force[slides]
    return float(np.trapezoid(force, time) / (time[-1] - time[0]))


@cache
def extrapolated() -> float:
    """Return the force in N that the forces of the three meshes tend to, with their own order."""
    coarse, standard, fine = map(mean_force, MESHES)
    ratio = (standard - coarse) / (fine - standard)

    def miss(order: float) -> float:
        a, b, c = (facet**order for facet in FACETS)
        return (a - b) / (b - c) - ratio

    order = float(brentq(miss, 0.3, 4.0))
    b, c = (facet**order for facet in FACETS[1:])
    return fine + (fine - standard) / (b - c) * c


def error(mesh: str) -> float:
    """Return the relative error of a mesh."""
    return abs(mean_force(mesh) / extrapolated() - 1)

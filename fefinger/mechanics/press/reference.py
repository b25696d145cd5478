"""The reference press: a small flat press of the same finger that scales strain to displacement."""

import numpy as np

from fefinger.fem.body import Reduced, Solid
from fefinger.fem.contact.complementarity import Complementarity
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.probe import tensors
from fefinger.fem.elements.recovery import recovered_strain_at
from fefinger.mechanics.press import placement
from fefinger.mechanics.press.problem import REACH, Contact, Method
from fefinger.mechanics.press.sites import REFERENCE_DEPTH, sites
from fefinger.neural.reference import Reference
from fefinger.results.records import Sites
from fefinger.scene.indenter import STANDARD
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError


def reference_press(
    finger: Solid, central: Sites, method: Method, reduced: Reduced | None = None
) -> Reference:
    """Press the standard plate a little and return the strain at the sites under it.

    `reduced` is the finger under that plate, with its strain there, where that is at hand.
    """
    if reduced is None:
        touch = placement.obstacle(STANDARD, finger)
        reach = 2 * REACH * REFERENCE_DEPTH
        candidates = patch(finger.space, finger.pad, finger.normals, touch, reach)
        probe = recovered_strain_at(finger.space, central.points, finger.planes)
        reduced = method.reduce(finger, candidates, probe)
    free = reduced.patch.gap - REFERENCE_DEPTH * reduced.patch.travel
    pressure = Complementarity(reduced.flexibility).solve(free)
    if (pressure[reduced.patch.edge] > 0).any():
        message = "reference press: contact left its patch; the pad is much flatter than expected"
        raise ConvergenceError(message)
    strain = tensors((reduced.strain @ pressure).reshape(-1, 6))
    return Reference(REFERENCE_DEPTH, central.types, central.normals, strain)


def reference_of(scene: Scene, finger: Solid, contact: Contact, method: Method) -> Reference | None:
    """Return the reference press of afferents; on the scene's own patch if that is the same."""
    if contact.sites is None or not scene.ask.spikes:
        return None
    touch = placement.obstacle(STANDARD, finger)
    central = sites(scene, touch.origin, touch.axis)
    own = scene.indenter == STANDARD and contact.history.depth.max() >= REFERENCE_DEPTH
    own = own and np.array_equal(contact.sites.points, central.points)
    return reference_press(finger, central, method, contact.reduced if own else None)

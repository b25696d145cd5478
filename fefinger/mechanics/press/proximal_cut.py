"""Whether a plate along the finger reaches the proximal cut, told before anything is solved."""

from fefinger.results.records import Refusal
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Plate, direction
from fefinger.scene.scene import Scene


ALONG = 15.0
"""Degrees up to which a plate may come near the cut: at 10 it is 3.5 mm away from the finger of
a.h. there."""

NEAR, FAR = 0.93, 1.25
"""Depth over the gap at the cut from which contact may have reached it, and beyond which it has: on
fingers of published tissue at 0 and 5 degrees `linear` reached it at 0.94 to 0.99, on six other
coarse meshes of d.p. at 1.05 to 1.15, `solid` at 0.97 to 0.99, on the tissue calibrated_ah at 1.19.
"""


def reached(name: str, scene: Scene) -> tuple[Refusal, ...]:
    """Return the refusal of a mechanics by name, if the plate goes too deep for the finger."""
    flat, motion, finger = scene.indenter.flat, scene.motion, scene.finger
    if flat is None or flat.angle > ALONG:
        return ()
    if motion.control != "depth" or finger.surface is not None:
        return ()
    gap = _gap(finger, flat)
    if motion.peak <= NEAR * gap:
        return ()
    sure = motion.peak > FAR * gap
    reason = (
        f"depth / gap at the proximal cut = {motion.peak:.3g} / {gap:.3g} mm: contact "
        f"{'reaches' if sure else 'may reach'} the cut, behind which there is no finger; press "
        "less, or at a steeper angle"
    )
    return (Refusal(name, "ability" if sure else "accuracy", reason),)


def _gap(finger: Finger, plate: Plate) -> float:
    from fefinger.mesh.first_touch import at_cut
    from fefinger.mesh.recipe import Recipe

    x, y, z = direction(plate).tolist()
    return at_cut(Recipe.of(finger), (x, y, z))

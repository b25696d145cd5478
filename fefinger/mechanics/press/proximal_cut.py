"""Whether a plate along the finger reaches the proximal cut, told before anything is solved."""

from fefinger.mechanics.situation import Situation
from fefinger.results.records import Refusal
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Plate, direction


ALONG = 15.0
"""Degrees up to which a plate may come near the cut: at 10 it is 3.5 mm away from the finger of
a.h. there."""

NEAR, FAR = 0.93, 1.25
"""Depth over the gap at the cut from which contact may have reached it, and beyond which it has: on
fingers of published tissue at 0 and 5 degrees `linear` reached it at 0.94 to 0.99, on six other
coarse meshes of d.p. at 1.05 to 1.15, `solid` at 0.97 to 0.99, on the tissue calibrated_ah at 1.19.
"""


def reached(name: str, case: Situation) -> tuple[Refusal, ...]:
    """Return the refusal of a mechanics by name, if the plate goes too deep for the finger."""
    flat, motion, finger = case.indenter.flat, case.motion, case.finger
    if flat is None or flat.angle > ALONG:
        return ()
    if motion.control != "depth" or finger.surface is not None:
        return ()
    gap = _gap(finger, flat)
    if case.peak <= NEAR * gap:
        return ()
    sure = case.peak > FAR * gap
    reason = (
        f"depth / gap at the proximal cut = {case.peak:.3g} / {gap:.3g} mm: contact "
        f"{'reaches' if sure else 'may reach'} the cut, behind which there is no finger; press "
        "less, or at a steeper angle"
    )
    return (Refusal(name, "ability" if sure else "accuracy", reason, "motion.depth"),)


def _gap(finger: Finger, plate: Plate) -> float:
    from fefinger.mesh.first_touch import at_cut
    from fefinger.mesh.recipe import Recipe

    x, y, z = direction(plate).tolist()
    return at_cut(Recipe.of(finger), (x, y, z))

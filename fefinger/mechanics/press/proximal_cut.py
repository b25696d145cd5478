"""Check, before a solution, whether a plate along the finger reaches its proximal end."""

from fefinger.mechanics.press.discretization import ALONG, NEAR, gap
from fefinger.mechanics.situation import Situation
from fefinger.results.records import Refusal


FAR = 1.25
"""Depth over the gap at the proximal end beyond which contact has reached it; see NEAR."""


def reached(name: str, case: Situation) -> tuple[Refusal, ...]:
    """Return the refusal of a mechanics by name, if the plate goes too deep for the finger.

    The finger is continued behind its cut where that is needed.
    """
    flat, motion, finger = case.indenter.flat, case.motion, case.finger
    if flat is None or flat.angle > ALONG:
        return ()
    if motion.control != "depth" or finger.surface is not None:
        return ()
    if case.peak <= NEAR * gap(finger, flat):
        return ()
    end = gap(finger, flat, continued=True)
    if case.peak <= NEAR * end:
        return ()
    sure = case.peak > FAR * end
    reason = (
        f"depth / gap at the proximal end = {case.peak:.3g} / {end:.3g} mm: contact "
        f"{'reaches' if sure else 'may reach'} the end, behind which there is no finger; press "
        "less, or at a steeper angle"
    )
    return (Refusal(name, "ability" if sure else "accuracy", reason, "motion.depth"),)

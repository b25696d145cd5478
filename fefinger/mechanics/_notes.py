"""Notes that several mechanics leave with their answers."""

from fefinger.scene import Finger
from fefinger.theory.relaxation import Prony


def normalized(prony: Prony) -> tuple[str, ...]:
    """Return the note that published weights do not add up to 1, if they do not."""
    total = sum(prony.c)
    if abs(total - 1) <= 1e-12:
        return ()
    return (f"Published Prony weights sum to {total:.4g}; normalized as in (2.2).",)


def apart(finger: Finger) -> tuple[str, ...]:
    """Return what keeps a mechanics that relaxes all stress with one function from a finger."""
    found = []
    if finger.relaxation != "whole":
        found.append(f"finger.relaxation = {finger.relaxation!r}: it relaxes the whole stress")
    for layer in ("skin", "subcutaneous"):
        if getattr(finger, layer).prony not in (None, finger.prony):
            found.append(f"finger.{layer}.prony: set, but it relaxes all tissue with one function")
    return tuple(found)


def relaxing(finger: Finger) -> tuple[str, ...]:
    """Return what is unusual in how the tissues of a finger relax."""
    found = []
    if finger.relaxation == "deviatoric":
        found.append("Only the deviatoric stress relaxes; the pressure is elastic.")
    for layer in ("skin", "subcutaneous"):
        own = getattr(finger, layer).prony
        if own not in (None, finger.prony):
            found.append(f"The {layer} relaxes with a series of its own.")
            found.extend(normalized(own))
    return tuple(found)

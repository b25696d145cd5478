"""Note on a finger whose tissue set, of a file, was fitted to a finger of another size."""

import math

from fefinger.scene.finger import Finger
from fefinger.scene.library import TISSUE_FILE, tissue_set
from fefinger.support.checks import InputError


SAME = 1e-6
"""Relative difference of two sizes that is rounding."""


def other_size(finger: Finger) -> tuple[str, ...]:
    """Return the note where the file of the tissue has another width or thickness.

    None where the file is gone, as it may be of a result that was saved.
    """
    if not finger.tissue.endswith(TISSUE_FILE):
        return ()
    try:
        fitted = tissue_set(finger.tissue)
    except InputError:
        return ()
    sizes = ((fitted.width, finger.width), (fitted.thickness, finger.thickness))
    if all(was is None or math.isclose(was, now, rel_tol=SAME) for was, now in sizes):
        return ()
    words = zip(sizes, ("wide", "thick"), strict=True)
    was = " and ".join(f"{each:g} mm {word}" for (each, _), word in words if each is not None)
    return (
        f"The tissue of {finger.tissue} was fitted to a finger of another size, {was}; this one is "
        f"{finger.width:g} mm wide and {finger.thickness:g} mm thick. For the fitted finger set "
        "finger.width and finger.thickness.",
    )

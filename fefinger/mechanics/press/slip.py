"""Whether a contact with friction stuck, slipped in part, or slid, in words."""

import numpy as np

from fefinger.support.arrays import Array, Flags


def told(time: Array, area: Array, stick: Array, shift: Array, moving: Flags, cone: float) -> str:
    """Return in words what a contact did, and since when.

    time (n_t,) s; area and stick (n_t,) mm²: of contact, and of what of it sticks; shift (n_t, 2)
    mm of the object; moving (n_t,): when it does; cone: the largest distance of a traction from
    Coulomb's law, over the largest pressure.
    """
    touching = area > 0
    law = f"with a residual of {cone:.1g} of the highest pressure"
    if moving.any():
        touching = touching & moving
        slips = stick[touching] == 0
        onsets = np.flatnonzero(touching)[slips & ~np.append(False, slips[:-1])]
        if len(onsets):
            first, last = time[onsets[[0, -1]]]
            path = np.linalg.norm(shift[onsets[0]] - shift[0])
            often = f"; {len(onsets)} times in all, as some stick in between"
            held = f"{often}, last from {last:.4g} s on" if len(onsets) > 1 else ""
            end = "" if slips[-1] else "; at the end of the path some stick"
            return (
                f"Gross slip: from {first:.4g} s on, with the indenter moved by {path:.3g} mm, "
                f"no vertex sticks{held}{end}, {law}."
            )
    if not touching.any():
        return f"Friction: no contact while the indenter moves, {law}."
    share = float((stick[touching] / area[touching]).min())
    if share < 1:
        return f"Partial slip: at least {100 * share:.0f} % of the contact area sticks, {law}."
    return f"Sticking: no part of the contact slips, {law}."

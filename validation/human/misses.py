"""Numbers that the default finger does not reach: what it gives, and why."""

from typing import Literal


Reason = Literal["first touch", "pulp", "area", "waves", "preload", "pressure"]

REASONS: dict[Reason, str] = {
    "first touch": (
        "the calibration fits stiffness against force, up to 2.5 N; the scatter that the source "
        "leaves, some 0.03 to 0.5 N/mm at every force, is of the size of the stiffness at 0.05 N, "
        "which so had little weight, and the depth at which a force is reached was not fitted"
    ),
    "pulp": (
        "the law measured on a.h. itself (Table 2.1 of the source) gives 0.65 at this speed: the "
        "two published sources disagree, and the finger was fitted to that one"
    ),
    "area": (
        "the published ratio is from a second source, without the angle of its plate; under ours, "
        "at 30 degrees, contact ends at the fingertip and cannot grow distally"
    ),
    "waves": (
        "waves along a finger run in skin and pulp together. The force at light touch fixes the "
        "modulus of the pulp, where they are too slow; the relaxed moduli are those of slow "
        "presses, and published moduli, taken as relaxed, make skin too fast"
    ),
    "preload": (
        "stiffening under the preload raises the speed in skin by 1.13 at 0.5 N and 1.23 at 1 N; "
        "unloaded it is 7.5 m/s"
    ),
    "pressure": (
        "the source's is the peak of a paraboloid that was fitted to the blurred frames of an "
        "array with elements of 2 mm, ours the mean over 1 mm²"
    ),
}

MISSES: dict[str, tuple[float, Reason]] = {
    "force at 2 mm over that of the subject, d.s.": (0.896, "first touch"),
    "force at 2.1 mm over that of the subject, p.w.": (0.741, "first touch"),
    "stiffness at 0.05 N over that of the subject, d.s.": (0.882, "first touch"),
    "stiffness at 0.05 N over that of the subject, p.w.": (0.774, "first touch"),
    "displacement at 1 N over that at 5.2 N, flat plate, a.h.": (0.659, "pulp"),
    "displacement at 1 N over that at 5.2 N, flat plate, means": (0.672, "pulp"),
    "contact area at 1 N over that at 10 N, flat plate, a.h.": (0.669, "area"),
    "contact area at 1 N over that at 10 N, flat plate, means": (0.713, "area"),
    **{
        f"surface wave speed by the {modulus} modulus of {layer} tissue, {name}": (speed, "waves")
        for (name, modulus, layer), speed in {
            ("a.h.", "relaxed", "skin"): 3.81,
            ("a.h.", "relaxed", "subcutaneous"): 1.2,
            ("a.h.", "instantaneous", "subcutaneous"): 2.38,
            ("means", "relaxed", "skin"): 3.73,
            ("means", "relaxed", "subcutaneous"): 1.18,
            ("means", "instantaneous", "subcutaneous"): 2.29,
            ("maeno1998", "relaxed", "skin"): 5.58,
            ("maeno1998", "relaxed", "subcutaneous"): 3.22,
            ("maeno1998", "instantaneous", "skin"): 10.31,
        }.items()
    },
    "surface wave speed in skin under 0.5 N, instantaneous, a.h.": (8.488, "preload"),
    "surface wave speed in skin under 1 N, instantaneous, a.h.": (9.235, "preload"),
    "surface wave speed in skin under 1 N, instantaneous, means": (8.93, "preload"),
    "highest pressure of a held 1.1 N, means": (26.9, "pressure"),
    "highest pressure of a held 2.3 N, means": (59.96, "pressure"),
}

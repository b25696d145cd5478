"""Numbers that the default finger does not reach: what it gives, and why."""

from typing import Literal


Reason = Literal["first touch", "pulp", "area", "waves", "pressure"]

REASONS: dict[Reason, str] = {
    "first touch": (
        "the law of d.p. has the smallest stiffness at first touch (0.092 N/mm) and the steepest "
        "growth of the four; a pad of the radius that its pressures ask for is stiffer there, and "
        "the exponent of the tissue was fitted from 0.3 N on. For p.w. it is the growth of contact "
        "over the first facets"
    ),
    "pulp": (
        "the law measured on a.h. itself (Table 2.1 of the source) gives 0.65 at this speed: the "
        "two published sources disagree, and the finger was fitted to that one"
    ),
    "area": (
        "facets snap over near 6 N, where tissue is pressed to less than half: the ratio is that "
        "to the largest force, not to 10 N"
    ),
    "waves": (
        "the moduli were fitted to presses of seconds and to the relaxation up to 264 1/s; waves "
        "of some 100 Hz run in tissue that is stiffer at that rate, and in skin that is thicker "
        "beside their length. Published moduli taken as relaxed would make skin too fast"
    ),
    "pressure": (
        "the source's peak is that of a paraboloid fitted to an array of 2 mm elements, which "
        "blurs it; skin over softer pulp over bone bears more in the middle than a half-space"
    ),
}

MISSES: dict[str, tuple[float, Reason]] = {
    "stiffness at 0.05 N over that of the subject, d.p.": (1.79, "first touch"),
    "stiffness at 0.1 N over that of the subject, d.p.": (1.525, "first touch"),
    "stiffness at 0.5 N over that of the subject, d.p.": (1.114, "first touch"),
    "stiffness at 0.1 N over that of the subject, p.w.": (1.1, "first touch"),
    "displacement at 1 N over that at 5.2 N, flat plate, a.h.": (0.632, "pulp"),
    "displacement at 1 N over that at 5.2 N, flat plate, means": (0.626, "pulp"),
    "contact area at 1 N over that at 10 N, flat plate, a.h.": (0.797, "area"),
    "contact area at 1 N over that at 10 N, flat plate, means": (0.738, "area"),
    **{
        f"surface wave speed by the {modulus} modulus of {layer} tissue, {name}": (speed, "waves")
        for (name, modulus, layer), speed in {
            ("a.h.", "relaxed", "skin"): 2.05,
            ("a.h.", "relaxed", "subcutaneous"): 1.18,
            ("a.h.", "instantaneous", "skin"): 4.05,
            ("a.h.", "instantaneous", "subcutaneous"): 2.33,
            ("means", "relaxed", "skin"): 2.28,
            ("means", "relaxed", "subcutaneous"): 1.31,
            ("means", "instantaneous", "skin"): 4.42,
            ("means", "instantaneous", "subcutaneous"): 2.55,
            ("maeno1998", "relaxed", "skin"): 5.58,
            ("maeno1998", "relaxed", "subcutaneous"): 3.22,
            ("maeno1998", "instantaneous", "skin"): 10.31,
        }.items()
    },
    "highest pressure of a held 0.54 N, means": (16.6, "pressure"),
    "highest pressure of a held 1.1 N, means": (32.3, "pressure"),
    "highest pressure of a held 2.3 N, means": (53.7, "pressure"),
}

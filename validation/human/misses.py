"""Numbers that the default finger does not reach: what it gives, and why."""

from typing import Literal


Reason = Literal["first touch", "pulp", "area", "waves", "preload", "pressure"]

REASONS: dict[Reason, str] = {
    "first touch": (
        "the calibration fits stiffness against force, up to 2.5 N: the line of d.p. is steep and "
        "begins at 0.092 N/mm, that of its finger at 0.44 N/mm; the depth at which a force is "
        "reached was not fitted. The scatter of its stiffness, 0.45 N/mm at every force, is more "
        "than the stiffness at 0.05 N, which so had no weight. Fitted to relative errors from 0.05 "
        "N on (coarse mesh, exponent 7, pulp 3.1 kPa), it is 1.10 times as stiff there, but 0.85 "
        "times at 2.5 N; with skin 9 times as stiff as pulp in place of 3, 1.03 and 0.91 times; "
        "with a pad radius 0.7 times as large and an exponent of 10, 1.06 and 0.92 times. The "
        "curve alone does not tell these two apart"
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
        "moduli were fitted to presses, with relaxation up to 264 1/s; the waves were of some 100 "
        "Hz and more, at which no modulus was fitted. Published moduli, taken as relaxed, make "
        "skin too fast"
    ),
    "preload": (
        "stiffening under the preload raises the speed of skin by 1.2 at 0.5 N and 1.35 at 1 N, "
        "which is a third to a half of what moduli fitted to presses lack against 7 m/s; moduli "
        "above the fastest fitted rate, 264 1/s, were not measured"
    ),
    "pressure": (
        "the source's is the peak of a paraboloid that was fitted to the blurred frames of an "
        "array with elements of 2 mm, ours the mean over 1 mm²"
    ),
}

MISSES: dict[str, tuple[float, Reason]] = {
    "force at 1.5 mm over that of the subject, d.p.": (2.546, "first touch"),
    "force at 2 mm over that of the subject, d.s.": (0.82, "first touch"),
    "force at 2.1 mm over that of the subject, p.w.": (0.889, "first touch"),
    "stiffness at 0.05 N over that of the subject, d.p.": (1.79, "first touch"),
    "stiffness at 0.1 N over that of the subject, d.p.": (1.525, "first touch"),
    "stiffness at 0.5 N over that of the subject, d.p.": (1.114, "first touch"),
    "stiffness at 0.1 N over that of the subject, p.w.": (1.1, "first touch"),
    "displacement at 1 N over that at 5.2 N, flat plate, a.h.": (0.632, "pulp"),
    "displacement at 1 N over that at 5.2 N, flat plate, means": (0.626, "pulp"),
    "contact area at 1 N over that at 10 N, flat plate, a.h.": (0.698, "area"),
    "contact area at 1 N over that at 10 N, flat plate, means": (0.678, "area"),
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
    "surface wave speed in skin under 0.5 N, instantaneous, a.h.": (4.925, "preload"),
    "surface wave speed in skin under 1 N, instantaneous, a.h.": (5.492, "preload"),
    "surface wave speed in skin under 0.5 N, instantaneous, means": (5.222, "preload"),
    "highest pressure of a held 0.54 N, means": (16.6, "pressure"),
    "highest pressure of a held 1.1 N, means": (32.3, "pressure"),
    "highest pressure of a held 2.3 N, means": (53.7, "pressure"),
}

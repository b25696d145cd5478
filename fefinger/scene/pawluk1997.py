"""Tables of the source thesis on its subjects: lumped force, relaxation, quasi-static pressure."""

from dataclasses import dataclass
from functools import cache

from fefinger.theory.relaxation import Prony


SOURCE = "Pawluk (1997), A Viscoelastic Model of the Human Fingerpad, PhD thesis, Harvard"


MEANS = "means"
"""Row of the tables for whom Pawluk (1997) did not measure."""


@dataclass(frozen=True)
class Lumped:
    """A row of Table 2.1: T(x) = (b/m) [exp(m (x - x0)) - 1], and its relaxation function.

    width and thickness of the fingertip in mm, m 1/mm, b N/mm; VAF_k and VAF_G: variance accounted
    for in stiffness and relaxation.
    """

    width: float
    thickness: float
    m: float
    b: float
    prony: Prony
    vaf: tuple[float, float]


@dataclass(frozen=True)
class Quasistatic:
    """A row of Table 3.2: effective radius R mm, m 1/mm and b kPa/mm of t(u) (Eq. 3.11).

    `b` is the printed value, most likely c0 b, the steady-state value (the text says that c0 b was
    fitted, and tables 2.1 and 3.2 agree only in that reading).
    """

    radius: float
    m: float
    b: float


@cache
def lumped() -> dict[str, Lumped]:
    """Table 2.1 of Pawluk (1997): lumped force at 60 mm/s, per subject (confidence high)."""
    rows = {
        "d.p.": (12, 9.5, 3.2, 0.092, (0.22, 0.45, 0.15, 0.18), (253, 14, 0.66), (0.98, 0.99)),
        "d.s.": (14, 11.5, 1.6, 0.28, (0.29, 0.40, 0.19, 0.13), (183, 11, 0.77), (0.97, 0.85)),
        "a.h.": (14, 10, 2.1, 0.18, (0.25, 0.40, 0.19, 0.16), (224, 14, 0.63), (0.98, 0.88)),
        "p.w.": (17, 13, 1.6, 0.22, (0.29, 0.38, 0.20, 0.13), (264, 22, 0.69), (0.96, 0.77)),
        "means": (14, 11, 2.1, 0.19, (0.26, 0.41, 0.18, 0.15), (231, 15, 0.69), (0.97, 0.87)),
    }
    return {name: Lumped(*row[:4], Prony(*row[4:6]), row[6]) for name, row in rows.items()}


def relaxation() -> dict[str, Prony]:
    """Table 3.1 of Pawluk (1997): relaxation of the pressure, per subject (confidence high)."""
    return {
        "d.p.": Prony((0.33, 0.44, 0.13, 0.10), (163, 2.8, 0.31)),
        "d.s.": Prony((0.33, 0.42, 0.16, 0.08), (256, 9.7, 0.91)),
        "a.h.": Prony((0.29, 0.47, 0.13, 0.10), (226, 8.6, 0.61)),
        "p.w.": Prony((0.33, 0.42, 0.16, 0.08), (238, 20.5, 0.79)),
        "f.c.": Prony((0.29, 0.49, 0.11, 0.10), (175, 8.2, 0.59)),
        "means": Prony((0.31, 0.45, 0.14, 0.09), (212, 10.0, 0.64)),
    }


def quasistatic() -> dict[str, Quasistatic]:
    """Table 3.2 of Pawluk (1997): quasi-static pressure, per subject (confidence high).

    The mean radius is 14.6 mm, the mean of the column; the thesis prints 14.
    """
    return {
        "d.p.": Quasistatic(15, 2.1, 2.3),
        "d.s.": Quasistatic(12, 1.1, 6.1),
        "a.h.": Quasistatic(14, 1.9, 1.9),
        "p.w.": Quasistatic(17, 1.1, 3.6),
        "f.c.": Quasistatic(15, 1.7, 3.8),
        "means": Quasistatic(14.6, 1.6, 3.5),
    }


def subjects() -> tuple[str, ...]:
    """Names of the subjects of Pawluk (1997); f.c. has no width and thickness."""
    return tuple(name for name in relaxation() if name != MEANS)

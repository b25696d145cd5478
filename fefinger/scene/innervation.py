"""End organs and nerve fibers of the fingertip, as published: depths, densities, branches."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Innervation:
    """Innervation of the fingertip by one afferent type.

    depth: mm of the end organs under the surface of the skin. density: units per cm². organs:
    smallest and largest number of end organs of a unit. field: diameter in mm of the disc over
    which they are spread; None for one end organ. velocity: m/s of the impulses in the nerve.
    """

    depth: float
    density: float
    organs: tuple[int, int]
    field: float | None
    velocity: float


def innervation() -> dict[str, Innervation]:
    """Innervation of the fingertip by the four afferent types.

    Depths: Merkel cells under the epidermis, at the base of the intermediate ridges (SAI, 0.7 to
    1.0 mm are quoted), Ruffini corpuscles in the deep dermis (SAII, 1.0 to 1.5), Meissner
    corpuscles in the dermal papillae just below the epidermis (FAI, 0.5), Pacinian corpuscles under
    the dermis (FAII, 2.0 to 3.0). We know no primary measurement of them in the human fingertip, so
    each is a parameter of the user (`ask.depths`) with confidence medium at best, low for SAII. The
    effective depths of TouchSim (SAI 0.3, FAI 1.6, FAII 2.0 mm) are fits of a half-space model, not
    anatomy.

    Densities of SAI, FAI and FAII: TouchSim (Saal et al. 2017, constants.py), confidence medium.
    Johansson & Vallbo (1979), J Physiol 286:283, give 241 per cm² for all types together; the rest,
    6, is assigned to SAII, which TouchSim lacks: an inference, confidence low. Numbers of end
    organs: Pawluk (1997), 1.1.2, from zones of maximal sensitivity, confidence medium. Fields: 2 to
    8 mm in diameter there, about 4 mm in a page that cites Johansson (1978); the skin spreads
    strain beyond the end organs, so their disc is narrower by a guess, confidence low. Velocities
    of FAI and FAII: means of Knibestol (1973), PMC1350502, confidence high; of SAI and SAII: taken
    to be as of the fast type with like fields, a guess, confidence low.
    """
    return {
        "SAI": Innervation(0.8, 70.0, (4, 7), 3.0, 55.3),
        "SAII": Innervation(1.25, 6.0, (1, 1), None, 46.9),
        "FAI": Innervation(0.5, 140.0, (12, 17), 3.0, 55.3),
        "FAII": Innervation(2.5, 25.0, (1, 1), None, 46.9),
    }

"""Suite `neural`: membranes, end organs, gains and populations, and the claims of chapters 4 and 5.

A claim is a number between two limits, which fail where it is not reproduced; its name begins with
the section, figure or equation of Pawluk (1997) that makes it.
"""

from fefinger.validation.case import joined
from fefinger.validation.neural import (
    drawings,
    filters,
    gains,
    membrane,
    phases,
    ramps,
    sinusoids,
    skin,
)


cases = joined(membrane, sinusoids, phases, filters, ramps, gains, skin)
figures = drawings.figures

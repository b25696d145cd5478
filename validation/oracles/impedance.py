"""Small-signal impedance of the lumped fingerpad about a preload (Pawluk 1997, Eq. 2.6 to 2.13)."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


Complex = NDArray[np.complex128]


def relaxation_spectrum(prony: Prony, frequency: ArrayLike) -> Complex:
    """Return G(s) = c0/s + sum ci/(s + vi) in s at s = 2 pi i `frequency`, in Hz and above 0."""
    frequency = np.asarray(frequency, float)
    if not np.all((frequency > 0) & np.isfinite(frequency)):
        msg = "relaxation_spectrum: expected frequencies > 0 Hz; at 0 Hz G(s) is infinite"
        raise ValueError(msg)
    s = 2j * np.pi * frequency
    rates = np.array((0.0, *prony.v))
    spectrum: Complex = (1.0 / np.add.outer(s, rates)) @ np.array(prony.weights)
    return spectrum


def operating_stiffness(
    spring: Spring, prony: Prony, preload: ArrayLike, *, printed: bool = False
) -> Array:
    """Return the instantaneous stiffness K_x in N/mm about a relaxed preload P0 >= 0 in N.

    Notes
    -----
    Eq. 2.7 starts from the steady state, where P0 = c0 T, so K_x = (m / c0) P0 + b. Eq. 2.12 prints
    m P0 + b, as if P0 had not relaxed: 3.4 to 3.8 times lower for the subjects. `printed`
    selects that form.
    """
    preload = np.asarray(preload, float)
    return spring.stiffness(preload if printed else preload / prony.long_time)


def impedance(
    spring: Spring,
    prony: Prony,
    frequency: ArrayLike,
    preload: float,
    *,
    printed: bool = False,
) -> Complex:
    """Return Z = P / (s X) = K_x G(s) in N s/mm at frequencies in Hz (Eq. 2.9).

    1 N s/mm is 1000 N s/m. `printed` takes K_x as Eq. 2.12 prints it. The model has no mass: the
    thesis compares the magnitude up to 200 Hz and the phase up to 30 Hz.
    """
    stiffness = operating_stiffness(spring, prony, preload, printed=printed)
    return stiffness * relaxation_spectrum(prony, frequency)


def decibel(z: ArrayLike) -> Array:
    """Return 20 log10 |Z| (Eq. 2.10, with the modulus that the print leaves out)."""
    return 20.0 * np.log10(np.abs(z))


def phase(z: ArrayLike) -> Array:
    """Return the phase in degrees."""
    return np.degrees(np.angle(np.asarray(z)))

"""Figure of the harmonic answer of a finger: dynamic stiffness, phase, strain and losses."""

from typing import Any

import numpy as np

from fefinger.results.harmonic import Harmonic
from fefinger.view.figures import INK, STEEL, figure, style


SIZE = (8.4, 4.6)  # inches


def harmonic(answer: Harmonic, types: tuple[str, ...]) -> Any:
    """Draw stiffness, phase of the impedance, strain per mm at the end organs, and energy lost."""
    with style():
        drawn = figure(*SIZE)
        (stiffness, phase), (strain, lost) = drawn.subplots(2, 2, sharex=True)
        frequency = answer.frequency
        stiffness.loglog(frequency, np.abs(answer.stiffness), color=INK)
        stiffness.set_ylabel("dynamic stiffness / (N/mm)")
        phase.semilogx(frequency, np.degrees(np.angle(answer.impedance)), color=INK)
        phase.set_ylabel("phase of the impedance / °")
        for kind in dict.fromkeys(types):
            members = np.flatnonzero(np.array(types) == kind)
            largest = np.abs(answer.strain[:, members]).max(axis=(1, 2, 3))
            strain.loglog(frequency, largest, label=kind)
        if types:
            strain.legend()
        strain.set_ylabel("largest strain / (1/mm)")
        lost.loglog(frequency, answer.lost(0.01), color=STEEL)
        lost.set_ylabel("lost per cycle of 10 µm / µJ")
        for axis in (strain, lost):
            axis.set_xlabel("frequency / Hz")
    return drawn

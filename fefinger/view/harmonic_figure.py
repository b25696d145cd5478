"""Figure of the harmonic answer of a finger: dynamic stiffness, phase, strain and losses."""

from typing import Any

import numpy as np

from fefinger.results.harmonic import Harmonic
from fefinger.view.figures import INK, STEEL, figure, style


SIZE = (8.4, 4.6)  # inches

WIDE = 4.0
"""Largest over smallest value from which on an axis is logarithmic."""


def harmonic(answer: Harmonic, types: tuple[str, ...]) -> Any:
    """Draw stiffness, phase of the impedance, strain per mm at the end organs, and energy lost."""
    with style():
        drawn = figure(*SIZE)
        (stiffness, phase), (strain, lost) = drawn.subplots(2, 2, sharex=True)
        frequency = answer.frequency
        stiffness.plot(frequency, np.abs(answer.stiffness), color=INK)
        stiffness.set_ylabel("dynamic stiffness / (N/mm)")
        phase.plot(frequency, np.degrees(np.angle(answer.impedance)), color=INK)
        phase.set_ylabel("phase of the impedance / °")
        for kind in dict.fromkeys(types):
            members = np.flatnonzero(np.array(types) == kind)
            largest = np.abs(answer.strain[:, members]).max(axis=(1, 2, 3))
            strain.plot(frequency, largest, label=kind)
        if types:
            strain.legend()
        strain.set_ylabel("largest strain / (1/mm)")
        lost.plot(frequency, answer.dissipated_energy(0.01), color=STEEL)
        lost.set_ylabel("lost per cycle of 10 µm / µJ")
        for axis in (strain, lost):
            axis.set_xlabel("frequency / Hz")
        for scale in (stiffness.xaxis, stiffness.yaxis, strain.yaxis, lost.yaxis):
            _logarithmic(scale)
    return drawn


def _logarithmic(axis: Any) -> None:
    """Make an axis logarithmic, with plain numbers at 1, 2 and 5 of a decade; from 0 if narrow."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    low, high = axis.get_data_interval()
    if not 0 < WIDE * low < high:
        axis.axes.set(**{f"{axis.axis_name}lim": (0, 1.1 * high)})
        return
    axis.axes.set(**{f"{axis.axis_name}scale": "log"})
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())

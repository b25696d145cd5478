"""Figures of suite `condensed`: a half-space pressed and left, and a finger that is stepped."""

from typing import Any

from fefinger.validation.panels import panels

from fefinger.support.arrays import Array
from fefinger.view.figures import INK, STEEL


ORANGE = "#D55E00"
SIZE = (6.2, 3.6)  # inches; two stand side by side


def half_space(time: Array, depth: Array, computed: Array, exact: Array) -> Any:
    """Draw a press in and out, s and mm: the force in mN that was found, and the exact one."""
    drawn, (left, right) = panels(*SIZE, 1, 2, sharey=True)
    for axis, x, label in ((left, time, "time / s"), (right, 1e3 * depth, "depth / um")):
        axis.plot(x[::5], exact[::5], "o", ms=3, color=ORANGE, label="Hertz and Ting")
        axis.plot(x, computed, color=INK, lw=1.2, label="condensed")
        axis.set_xlabel(label)
    left.set_ylabel("force / mN")
    left.legend()
    return drawn


def steps(time: Array, depth: Array, force: Array) -> Any:
    """Draw depths in mm and the forces in N of steps at times in s."""
    drawn, (top, bottom) = panels(*SIZE, 2, 1, sharex=True, height_ratios=(1, 2))
    top.plot(time, depth, color=STEEL, lw=0.8)
    top.set_ylabel("depth / mm")
    bottom.plot(time, force, color=INK, lw=0.8)
    bottom.set(xlabel="time / s", ylabel="force / N")
    return drawn

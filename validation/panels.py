"""Figures of one or more empty panels, and what their axes share."""

from collections.abc import Sequence
from typing import Any

from fefinger.support.arrays import Array
from fefinger.view.figures import figure


def panel(width: float, height: float, **options: Any) -> tuple[Any, Any]:
    """Return a figure in inches and its axes; options as of `Axes.set`."""
    drawn = figure(width, height)
    axis = drawn.subplots()
    axis.set(**options)
    return drawn, axis


def panels(width: float, height: float, rows: int, columns: int, **options: Any) -> tuple[Any, Any]:
    """Return a figure in inches and its rows and columns of axes; options as `subplots`."""
    drawn = figure(width, height)
    return drawn, drawn.subplots(rows, columns, **options)


def label_outside(axes: Any, xlabel: str, ylabel: str) -> None:
    """Label a row, or rows, of axes below the lowest and left of the first ones alone."""
    rows = axes.reshape(-1, axes.shape[-1])
    for axis in rows[-1]:
        axis.set_xlabel(xlabel)
    for axis in rows[:, 0]:
        axis.set_ylabel(ylabel)


def ticks_at(axis: Any, values: Sequence[float] | Array) -> None:
    """Mark an axis along x at these values alone."""
    axis.set_xticks(values, [f"{value:g}" for value in values])
    axis.minorticks_off()

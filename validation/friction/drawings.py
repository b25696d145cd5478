"""Figures of suite `friction`."""

from typing import Any

import numpy as np
from fefinger.validation.friction import dots, finger, layers, sheared
from fefinger.validation.friction.sheared import Body
from fefinger.validation.panels import panel, panels

from fefinger.view.figures import COLORS, INK, STEEL


SIZE = (8.6, 3.0)  # inches
SCANS = ((dots.scanned, "o", "computed"), (layers.scanned, "x", "on exact layers"))
THINNED = 12  # steps of a curve from one drawn point to the next


def cycle(body: Body, size: int) -> Any:
    """Draw the first loading and a cycle against Mindlin, and the traction at half of mu P."""
    first, run = sheared.loaded(body, size), sheared.cycled(body, size)
    theory, unit = run.theory, sheared.limit()
    peak = float(run.tangential[sheared.STEPS - 1])
    force = np.linspace(-peak, peak, 200)
    drawn, (loop, inside) = panels(*SIZE, 1, 2)
    loop.plot(first.path / unit, theory.force_at(first.path) / theory.most, color=STEEL)
    for sign in (1, -1):
        back = sign * theory.back(force, peak) / unit
        loop.plot(back, sign * force / theory.most, color=STEEL)
    loop.plot(first.path / unit, first.tangential / theory.most, ".", ms=3, color=INK)
    loop.plot(run.path / unit, run.tangential / theory.most, ".", ms=3, color=COLORS["FAI"])
    loop.set(xlabel="displacement / that of full slip", ylabel="tangential force / μP")
    on = sheared.contact(body, size)
    k = int(np.argmin(np.abs(first.tangential - theory.most / 2)))
    r, distance = np.linspace(0, theory.radius, 200), np.hypot(*on.places.T)
    exact = theory.traction(r, float(first.tangential[k]))
    inside.plot(r, exact, color=STEEL, label="Mindlin")
    inside.plot(distance, first.traction[k, 0], ".", ms=3, color=INK, label="computed")
    inside.plot(distance, sheared.MU * first.pressure[k], ".", ms=2, color=COLORS["SAI"])
    inside.set(xlabel="distance from the axis / a", ylabel="traction, and μ p (blue) / kPa")
    inside.legend()
    return drawn


def stick() -> Any:
    """Draw the part of the contact that sticks on the finger, by sphere theory and as recorded."""
    q, part = (each[::THINNED] for each in finger.stick_curve(finger.FINGER))
    line = np.linspace(0, 1, 200)
    drawn, axis = panel(
        4.6, 3.2, xlabel="tangential force / its largest", ylabel="stick area / contact area"
    )
    axis.plot(line, 1 - line, color=COLORS["SAI"], label="recorded: about linear")
    axis.plot(line, np.cbrt(1 - line) ** 2, color=STEEL, label="Mindlin, sphere")
    axis.plot(q, part, ".", ms=3, color=INK, label="finger, 1 N")
    axis.legend()
    return drawn


def rates() -> Any:
    """Draw the rates over scanned dots beside the recorded ones."""
    drawn, axes = panels(*SIZE, 1, len(dots.recorded()))
    for axis, (kind, (spacing, rate)) in zip(axes, dots.recorded().items(), strict=True):
        axis.plot(spacing, rate, color=STEEL, label="recorded, monkey")
        color = COLORS.get(kind, INK)
        for scan, mark, what in SCANS:
            rates = dots.computed(scan)[kind]
            axis.plot(dots.SPACINGS, rates, mark, color=color, label=what)
        axis.set(title=kind, xlabel="spacing / mm", ylim=(0, None))
    axes[0].set_ylabel("mean rate / Hz")
    axes[0].legend()
    return drawn

"""Figures of Pawluk (1997), chapters 2 and 5, drawn from the equations in the thesis's own axes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.oracles.impedance import decibel, impedance, phase, relaxation_spectrum
from fefinger.validation.panels import panel, panels
from fefinger.validation.thesis.lumped import OFFSETS, finger, sinusoid, vibrated

from fefinger.theory.lumped.spring import constant_velocity
from fefinger.view.figures import INK, STEEL


SIZE = (5.6, 3.6)  # inches; two stand side by side
COLORS = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9", INK)
SPEEDS = (0.2, 8.0, 16.0, 32.0, 48.0, 64.0, 80.0)  # mm/s
SUBJECTS = ("d.p.", "d.s.", "a.h.", "p.w.")
MODEL = "The model alone: no data of the thesis can be read off its text."


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure in the order of the thesis."""
    yield f"Figures 2-2 and 5-1. Force at constant velocity, a.h. {MODEL}", _velocities()
    yield "Figure 2-3. Relaxation of p.w. after a ramp at 60 mm/s to 2.5 N.", _relaxation()
    yield (
        "Figure 2-4. A ramp at 20 mm/s, then 4 Hz, a.h. Below zero Eq. 2.3 pulls: the finger "
        "would lose contact there.",
        _sinusoid(),
    )
    yield "Figure 2-5. Stiffness against force, Eq. 2.4, with Table 2.1.", _stiffness()
    yield (
        "Figures 2-6 and 2-7. |Z| of the means at two preloads: with the relaxed preload "
        "corrected (lines), and by Eq. 2.12 as printed (dashes). Parallel, as the thesis says.",
        _magnitude(),
    )
    yield "Figure 2-8. Phase of the relaxation function, means.", _phase()
    yield from _energy()


def canvas(xlabel: str, ylabel: str, **limits: Any) -> tuple[Any, Any]:
    """Return an empty figure and its axes."""
    drawn, axis = panel(*SIZE, xlabel=xlabel, ylabel=ylabel, **limits)
    return drawn, axis


def _velocities() -> Any:
    spring, prony = finger("a.h.")
    drawn, axis = canvas("position / mm", "force / N", xlim=(0, 2.5), ylim=(0, 3))
    position = np.linspace(0.0, 2.5, 300)
    for speed, color in zip(SPEEDS, COLORS, strict=True):
        pressed = constant_velocity(spring, prony, position, speed)
        axis.plot(position, pressed, color=color, label=f"{speed:g} mm/s")
    for name, factor in (("T", 1.0), ("c0 T", prony.long_time)):
        axis.plot(position, factor * spring.force(position), "--", color=STEEL, lw=1, label=name)
    axis.legend()
    return drawn


def _relaxation() -> Any:
    from fefinger.validation.oracles.synthetic import ramp_and_hold

    spring, prony = finger("p.w.")
    trial = ramp_and_hold(spring, prony, peak_force=2.5, seed=3)
    exact = ramp_and_hold(spring, prony, peak_force=2.5, seed=None)
    start = int(np.argmax(exact.force))
    drawn, axis = canvas("time in the hold / s", "force / N", xscale="log", xlim=(1e-4, 6))
    time = exact.time[start:] - exact.time[start] + 1e-4
    chosen = np.unique(np.geomspace(1, len(time), 500).astype(int)) - 1
    axis.plot(time[chosen], trial.force[start:][chosen], ".", color=STEEL, ms=3, label="with noise")
    axis.plot(time[chosen], exact.force[start:][chosen], color=INK, label="model")
    axis.legend()
    return drawn


def _sinusoid() -> Any:
    time, pressed = sinusoid()
    drawn, axis = canvas("time / s", "force / N", xlim=(0, 1.35))
    axis.axhline(0, color=STEEL, lw=0.8)
    ramp = np.linspace(0.0, 0.075, 60)
    spring, prony = finger("a.h.")
    rising = constant_velocity(spring, prony, 20 * ramp, 20.0)
    axis.plot(np.append(ramp, time[1:]), np.append(rising, pressed[1:]), color=INK)
    return drawn


def _stiffness() -> Any:
    drawn, axis = canvas("force / N", "stiffness / N/mm", xlim=(0, 3), ylim=(0, 10))
    forces = np.array([0.0, 3.0])
    for subject, color in zip(SUBJECTS, COLORS, strict=False):
        axis.plot(forces, finger(subject)[0].stiffness(forces), color=color, label=subject)
    axis.legend()
    return drawn


def _magnitude() -> Any:
    spring, prony = finger("means")
    tones = np.geomspace(1, 1000, 200)
    drawn, axis = canvas(
        "frequency / Hz", "|Z| / dB re 1 N s/m", xscale="log", xlim=(1, 1000), ylim=(-20, 80)
    )
    for preload, color in ((1.0, COLORS[0]), (5.6, COLORS[1])):
        for printed, line in ((False, "-"), (True, "--")):
            z = impedance(spring, prony, tones, preload, printed=printed)
            label = "_" if printed else f"{preload:g} N"
            axis.plot(tones, decibel(1e3 * z), line, color=color, label=label)
    axis.legend()
    return drawn


def _phase() -> Any:
    tones = np.geomspace(1, 1000, 200)
    drawn, axis = canvas(
        "frequency / Hz", "phase / degrees", xscale="log", xlim=(1, 1000), ylim=(-95, -60)
    )
    axis.plot(tones, phase(relaxation_spectrum(finger("means")[1], tones)), color=INK)
    return drawn


def _energy() -> Iterator[tuple[str, Any]]:
    tones = (1, 2, 4, 8, 16, 30)
    first = {
        "steady state": [vibrated(1.5, 0.28, f).steady for f in tones],
        "initial transient": [vibrated(1.5, 0.28, f).transient for f in tones],
    }
    yield (
        "Figure 2-10 (a). Power and dissipated share, 0.28 mm about 1.5 mm, a.h.",
        _dissipation(tones, first),
    )
    names = [f"{size:g} mm about {offset:g} mm" for offset, size in OFFSETS]
    second = {
        name: [vibrated(offset, size, f).steady for f in tones]
        for name, (offset, size) in zip(names, OFFSETS, strict=True)
    }
    yield "Figure 2-10 (b). The same in the steady state.", _dissipation(tones, second)


def _dissipation(tones: tuple[int, ...], rows: dict[str, list[Any]]) -> Any:
    drawn, (top, bottom) = panels(*SIZE, 2, 1, sharex=True)
    for (name, works), color in zip(rows.items(), COLORS, strict=False):
        top.plot(tones, [work.power for work in works], "o-", ms=3, color=color)
        share = [100 * work.fraction for work in works]
        bottom.plot(tones, share, "o-", ms=3, color=color, label=name)
    top.set(ylabel="power / mW", xscale="log", yscale="log")
    bottom.set(xlabel="frequency / Hz", ylabel="dissipated / %", ylim=(0, 60))
    bottom.legend(ncols=2, loc="upper left")
    bottom.set_xticks(tones, [str(tone) for tone in tones])
    bottom.minorticks_off()
    return drawn

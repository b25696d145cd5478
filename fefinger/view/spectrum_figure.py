"""Spectra of what drives the units and of their spikes, while a texture slides at one velocity."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fefinger.neural.spectra import signal_spectrum, spike_spectrum
from fefinger.results.result_record import ResultRecord
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.view.figures import COLORS, INK, STEEL, WIDE, figure, of_each, strongest, style


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PERIODS = 5
"""Least number of periods in the span of a spectrum."""

PERIOD, RIDGES = "speed / period", "speed / ridge pitch"
"""Names of the frequencies at which the object repeats, and at which it meets ridges."""


class EvenSlide(NamedTuple):
    """The span in s in which an object slides at one velocity (2,) mm/s, and marked frequencies.

    marks: Hz by what meets what, of which the span has PERIODS or more.
    """

    start: float
    stop: float
    velocity: Array
    marks: dict[str, float]


def even_slide(result: ResultRecord) -> EvenSlide | None:
    """Return the longest even slide while spikes count; None where no frequency can be marked."""
    spikes, scene = result.spikes, result.scene
    if spikes is None or not scene.motion.slides:
        return None
    low, high = max(spikes.t_start, spikes.time[0]), min(spikes.t_stop, spikes.time[-1])
    clipped = ((max(a, low), min(b, high)) for a, b in scene.motion.even_spans)
    start, stop = max(clipped, key=lambda span: span[1] - span[0], default=(0.0, 0.0))
    velocity = scene.motion.velocity((start + stop) / 2)
    found = meetings(scene, velocity).items()
    marks = {what: each for what, each in found if each * (stop - start) >= PERIODS}
    return EvenSlide(float(start), float(stop), velocity, marks) if marks else None


def meetings(scene: Scene, velocity: Array) -> dict[str, float]:
    """Return the frequencies in Hz of the period of the object, and of the ridges of the skin."""
    turn = np.radians(scene.indenter.turn)
    own = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) @ velocity
    along, across = (np.abs(own) / scene.indenter.repeats).tolist()
    found = {PERIOD: max(along, across)}
    # Along a diagonal both are the same; where it runs along one of them, rounding is left.
    if 1e-6 < min(along, across) / max(along, across, 1e-9) < 1 - 1e-6:
        found = {f"{PERIOD} along x": along, f"{PERIOD} along y": across}
    ridges = scene.finger.raised_ridges
    if ridges is not None and not scene.indenter.profile.plane:
        turn = np.radians(ridges.direction)
        across = abs(float(velocity @ [np.cos(turn), np.sin(turn)]))
        met = across if ridges.shape == "straight" else float(np.hypot(*velocity))
        found[RIDGES] = met / ridges.pitch
    return found


def caption(slide: EvenSlide) -> str:
    """Return the caption of the figure."""
    text = (
        f"Amplitudes while the object slides at {np.hypot(*slide.velocity):.3g} mm/s, from "
        f"{slide.start:.3g} to {slide.stop:.3g} s, with a Hann window: of the input of the end "
        "organs, of the unit of each type with the largest current; and of the firing rate, as the "
        "root mean square over all units of each type, to which spikes at any time add a level "
        "floor."
    )
    if any(what.startswith(PERIOD) for what in slide.marks):
        text += f" An object that repeats has lines at multiples of {PERIOD} alone (dotted)."
    if RIDGES in slide.marks:
        text += f" Ridges of the skin raise what lies about {RIDGES}."
    return text


def draw(result: ResultRecord, slide: EvenSlide) -> "Figure":
    """Draw the spectra of input and spikes by type against frequency, with the marks."""
    trains = result.spikes
    assert trains is not None
    span = slide.start, slide.stop
    limit = 2.5 * max(slide.marks.values())  # in Hz, to multiples of what is marked
    chosen = strongest(trains.current, trains.types)
    frequency, inputs = signal_spectrum(trains.time, 1e3 * trains.x_in[:, chosen], *span)
    with style():
        drawn = figure(WIDE, 4.6)
        axes = drawn.subplots(2, 1, sharex=True)
        kinds = of_each(trains.types).items()
        for (kind, units), unit, each in zip(kinds, chosen, inputs.T, strict=True):
            color = COLORS.get(kind, INK)
            axes[0].semilogy(frequency, each, color=color, label=trains.names[unit])
            rate = spike_spectrum([trains.at_end_organs(i) for i in units.tolist()], *span)
            axes[1].plot(*rate, color=color, label=f"{len(units)} {kind}")
        shown = inputs[frequency <= limit]
        axes[0].set_ylim(max(1e-4 * shown.max(), 0.5 * shown.min()), 2 * shown.max())
        axes[0].set_ylabel("end-organ input / µm")
        axes[1].set(
            ylabel="firing rate / Hz", xlabel="frequency / Hz", xlim=(0, limit), ylim=(0, None)
        )
        for axis in axes:
            axis.grid(visible=False, axis="x")
            _mark(axis, slide.marks, named=axis is axes[0])
            # Above the axes and right of every mark.
            place: Any = {"bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
            axis.legend(loc="lower right", ncols=len(kinds), **place)
        return drawn


def _mark(axis: "Axes", marks: dict[str, float], *, named: bool) -> None:
    """Draw lines at the marked frequencies, with their names above, and at multiples of periods."""
    thin: Any = {"color": STEEL, "zorder": 0}
    for what, frequency in marks.items():
        axis.axvline(frequency, linestyle="--", linewidth=1.0, **thin)
        if named:
            text = f"{what}\n{frequency:.3g} Hz"
            place: Any = {"transform": axis.get_xaxis_transform(), "ha": "center", "va": "bottom"}
            axis.text(frequency, 1.02, text, fontsize=8, **place)
        if what.startswith(PERIOD):
            for multiple in np.arange(2 * frequency, axis.get_xlim()[1], frequency):
                axis.axvline(multiple, linestyle=":", linewidth=0.9, **thin)

"""Figures of chapters 4 and 5 of Pawluk (1997), drawn from the models in the thesis's own axes."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.neural import gains, ramps, skin
from fefinger.validation.neural.filters import SLOW, same_rate
from fefinger.validation.neural.sweep import MODELS, SLOWED, STANDARD, impulses, swing
from fefinger.validation.panels import ticks_at

from fefinger.neural.endorgans import END_ORGANS, GAINS, PoleZero, saturating
from fefinger.neural.membranes import HodgkinHuxley
from fefinger.support.arrays import Array
from fefinger.view.figures import COLORS, INK, STEEL, figure


SIZE = (5.6, 3.6)  # inches; two stand side by side
SHADES = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9", INK)
LEVELS = 7
"""Amplitudes drawn of each model, the largest first."""

RESPONSES = (
    ("spring, 6.3 C", "Figure 4-4b. Spring, membrane at 6.3 C."),
    ("damper, 6.3 C", "Figure 4-5b. Damper, membrane at 6.3 C."),
    (
        "second derivative, 6.3 C",
        "Section 4.2.2. Second derivative, membrane at 6.3 C (not drawn).",
    ),
    ("spring", "Figure 4-8. Spring, rates / 6."),
    ("damper", "Figure 4-9. Damper, rates / 6, from 0.125 Hz."),
    ("SAI", "Figure 4-10a. SAI: zero 0.1, pole 1 Hz."),
    ("SAII", "Figure 4-10b. SAII: zero 0.5, pole 5 Hz."),
    ("FAI", "Figure 4-11a. FAI: poles 1 and 10 Hz."),
    ("FAII", "Figure 4-11b. FAII: poles 100 and 1000 Hz; beyond 9000 uA/cm² nothing is fired."),
    ("spring, A current", "Section 4.4.2. Spring, membrane with a fast transient K current."),
)

COURSES = (
    ("spring", "Figure 4-13. Spring, rates / 6"),
    ("SAI", "Figure 4-14a. SAI"),
    ("SAII", "Figure 4-14b. SAII"),
    ("damper", "Figure 4-16. Damper, closed by a pole at 100 Hz"),
    ("FAI", "Figure 4-17. FAI"),
    ("FAII", "FAII, left open in 4.3.5"),
)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure in the order of the thesis."""
    yield (
        "Figure 4-2. Seven FAI units, 1 mm peak to peak: gains drawn with a spread of 0.5 in "
        "their logarithm (seed 0). The spread is a choice: the thesis gives no number.",
        _seven(),
    )
    yield (
        "Figure 4-3. Spring, 6.3 C, 200 uA/cm² peak to peak at 2 Hz, second half: the response "
        "spans phi1 to phi2; near the crest the peaks stay below 40 mV.",
        _trace(),
    )
    for name, caption in RESPONSES:
        yield f"{caption} 0 dB is the largest input; zeros are left out.", _response(name)
    yield (
        "Figures 4-6a and 4-7a. Impulses per second over frequency at one amplitude of each "
        "model: the slope tells the order.",
        _rates(),
    )
    yield (
        "Section 4.3.4. Moving zero and pole: impulses per cycle (above) hardly change, the "
        "phase (below) does.",
        _sensitivity(),
    )
    for name, caption in COURSES:
        yield f"{caption}. Position, impulses and instantaneous rate at 8 mm/s.", _course(name)
    yield (
        "Section 4.4.1, Figure 4-18. Step of force: serial chain (dashes), with a parallel "
        "spring as stiff as the nerve (lines).",
        _force(),
    )
    yield (
        "Figure 5-3. Change of amplitude that keeps the impulses per cycle, spring, rates / 6.",
        _same_rate(),
    )
    yield (
        "Gains. SA rates in a hold at the default gains, with the acceptance bands; dashes: "
        "the linear generator, until it blocks.",
        _gains(),
    )
    yield (
        "Sections 3.6 and 5.2. SAI across the finger under a plate and spheres at 0.1 N, on "
        "`layered`: input of the end organs, and rates.",
        _population(),
    )


def _axes(rows: int = 1, **options: Any) -> tuple[Any, Any]:
    drawn = figure(*SIZE)
    return drawn, drawn.subplots(rows, 1, **options)


def _response(name: str) -> Any:
    from matplotlib import colormaps

    model, table = MODELS[name], impulses(name)
    shown = np.flatnonzero(np.nan_to_num(table).max(axis=0) > 0)
    shown = shown[np.unique(np.linspace(0, len(shown) - 1, LEVELS).astype(int))]
    levels = 20.0 * np.log10(model.amplitudes / model.largest)
    drawn, axis = _axes()
    shades = colormaps["viridis"](np.linspace(0.0, 0.88, len(shown)))  # large to small
    for i, color in zip(shown, shades, strict=True):
        curve = np.where(table[:, i] > 0, table[:, i], np.nan)
        label = f"{levels[i]:.0f}"
        axis.plot(model.frequencies, curve, "o-", ms=3, lw=1.3, color=color, label=label)
    axis.set(xscale="log", yscale="log", xlabel="frequency / Hz", ylabel="impulses / cycle")
    ticks_at(axis, model.frequencies)
    axis.legend(ncols=1 + len(shown) // 8, fontsize=7, title="amplitude / dB", title_fontsize=7)
    return drawn


def _seven() -> Any:
    tones = tuple(2.0**k for k in range(-1, 9))
    factors = np.exp(0.5 * np.random.default_rng(0).normal(size=7))
    drawn, axis = _axes()
    rows = []
    for tone in tones:
        turn = np.arange(int(4 * max(tone, 1.0)) * 100 + 1) / 100
        wave = 0.5 * (1.0 - np.cos(2 * np.pi * turn))
        organ = np.maximum(END_ORGANS["FAI"].respond(turn / tone, wave), 0.0)
        driven = saturating(organ[:, None], GAINS["FAI"] * factors)
        firing = SLOWED.fire(turn / tone, driven, stimulus_driven=False)
        cycles = turn[-1] / 2
        rows.append([np.sum(t * tone > cycles) / cycles for t in firing.times])
    table = np.where(np.array(rows) > 0, rows, np.nan)
    axis.plot(tones, table, "o-", ms=3, lw=1.2)
    axis.set(xscale="log", yscale="log", xlabel="frequency / Hz", ylabel="impulses / cycle")
    ticks_at(axis, tones)
    return drawn


def _trace() -> Any:
    from scipy.integrate import solve_ivp

    from fefinger.neural.membranes.equations import slope

    def rise(t: float, y: Array) -> tuple[float, ...]:
        current = 100.0 * (1.0 - np.cos(2e-3 * np.pi * 2.0 * t))
        return slope(y[0], y[1], y[2], y[3], current, 1.0, 1.0)

    at = np.linspace(1000.0, 2000.0, 8001)
    start = HodgkinHuxley(1.0).rest()
    solution = solve_ivp(
        rise, (0.0, 2000.0), start, "DOP853", at, rtol=1e-8, atol=1e-8, max_step=1.0
    )
    phases = np.concatenate(swing(MODELS["spring, 6.3 C"].organ, STANDARD, 2.0, 100.0).phases)
    drawn, (top, bottom) = _axes(2, sharex=True, height_ratios=[3, 1])
    top.plot(1e-3 * at, solution.y[0], color=INK, lw=0.8)
    top.axhline(40.0, color=STEEL, lw=0.8, ls="--")
    for k in (0, 1):
        for phase in (phases.min(), phases.max()):
            bottom.axvline(1.0 + 0.5 * (k + phase / 360.0), color=SHADES[1], lw=1.0)
    bottom.plot(1e-3 * at, 100.0 * (1.0 - np.cos(2e-3 * np.pi * 2.0 * at)), color=STEEL)
    top.set(ylabel="V / mV", title=f"phi1 {phases.min():.0f}, phi2 {phases.max():.0f} degrees")
    bottom.set(xlabel="time / s", ylabel="I / µA/cm²")
    return drawn


def _rates() -> Any:
    drawn, axis = _axes()
    for (name, column), color in zip(
        (("spring", 2), ("damper", 6), ("second derivative", 8), ("SAI", 3), ("FAII", 10)),
        SHADES,
        strict=False,
    ):
        tones = np.array(MODELS[name].frequencies)
        rate = tones * impulses(name)[:, column]
        axis.plot(tones, np.where(rate > 0, rate, np.nan), "o-", ms=3, color=color, label=name)
    axis.set(xscale="log", yscale="log", xlabel="frequency / Hz", ylabel="impulses / s")
    axis.legend()
    return drawn


def _sensitivity() -> Any:
    drawn, (top, bottom) = _axes(2, sharex=True)
    organs = {
        "0.1, 1": PoleZero((0.1,), (1.0,)),
        "0.2, 1": PoleZero((0.2,), (1.0,)),
        "0.1, 2": PoleZero((0.1,), (2.0,)),
        "0.5, 5": PoleZero((0.5,), (5.0,)),
    }
    for (name, organ), color in zip(organs.items(), SHADES, strict=False):
        amplitude = 50.0 / abs(organ.frequency_response(4.0) - organ.frequency_response(0.0))
        impulses = [swing(organ, SLOWED, tone, amplitude).impulses[0] for tone in SLOW]
        top.plot(SLOW, impulses, "o-", ms=3, color=color, label=f"zero, pole {name} Hz")
        lead = np.degrees(np.angle(organ.frequency_response(np.array(SLOW))))
        bottom.plot(SLOW, lead, "o-", ms=3, color=color)
    top.set(yscale="log", ylabel="impulses / cycle")
    bottom.set(xscale="log", xlabel="frequency / Hz", ylabel="lead / degrees")
    ticks_at(bottom, SLOW)
    top.legend(fontsize=7)
    return drawn


def _course(name: str) -> Any:
    course_ = ramps.course(name, 8.0)
    color = COLORS.get(name, INK)
    drawn, (top, middle, bottom) = _axes(3, sharex=True, height_ratios=[1.2, 0.5, 1.6])
    top.plot(course_.time, course_.depth, color=STEEL)
    top.set(ylabel="position\n/ mm")
    middle.eventplot(course_.spikes, colors=color, linewidths=0.9)
    middle.set(yticks=[], ylim=(0.4, 1.6))
    middle.grid(visible=False)
    if len(course_.spikes) > 1:
        bottom.stairs(1.0 / np.diff(course_.spikes), course_.spikes, color=color, baseline=None)
    bottom.set(xlabel="time / s", ylabel="rate / Hz", ylim=(0, 32), xlim=(0, course_.time[-1]))
    return drawn


def _force() -> Any:
    from fefinger.validation.oracles.chains import under_force

    drawn, axis = _axes()
    after = np.geomspace(1e-3, 10.0, 300)
    for kind, color in COLORS.items():
        for parallel, line in ((1.0, "-"), (0.0, "--")):
            organ = under_force(END_ORGANS[kind], nerve=1.0, parallel=parallel)
            out = organ.respond([0.0, 20.0], [1.0, 1.0], after)
            axis.plot(after, out, line, color=color, label=kind if parallel else "_", lw=1.3)
    axis.set(xscale="log", xlabel="time after the step / s", ylabel="x nerve per force / mm/mN")
    axis.legend()
    return drawn


def _same_rate() -> Any:
    drawn, axis = _axes()
    tones = tuple(2.0**k for k in range(-1, 8))
    for k, color in zip(range(4), SHADES, strict=False):
        widths = [same_rate(tone, 50.0 / 2**k) for tone in tones]
        axis.plot(tones, widths, "o-", ms=3, color=color, label=f"{-6 * k} dB")
    axis.set(xscale="log", xlabel="frequency / Hz", ylabel="range with the same rate / dB")
    ticks_at(axis, tones)
    axis.legend()
    return drawn


def _gains() -> Any:
    drawn, axis = _axes()
    depths = np.array([0.1, 0.15, 0.2, 0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 3.0])
    for kind in ("SAI", "SAII"):
        rates = [gains.hold_rate(kind, float(d)) for d in depths]
        axis.plot(depths, rates, "o-", ms=3, color=COLORS[kind], label=kind)
        linear = [gains.hold_rate(kind, float(d), "linear") for d in depths]
        axis.plot(depths, linear, "--", lw=1.0, color=COLORS[kind])
    for (kind, depth), (low, high, _) in gains.BANDS.items():
        axis.plot([depth, depth], [low, high], color=COLORS[kind], lw=7, alpha=0.25)
    axis.plot([1.5, 1.5], [21.7, 45.0], color=COLORS["SAI"], lw=7, alpha=0.25)
    axis.set(xlabel="depth of the hold / mm", ylabel="rate / Hz", ylim=(-1, 46))
    axis.legend()
    return drawn


def _population() -> Any:
    drawn, (top, bottom) = _axes(2, sharex=True)
    for curvature, color in zip((skin.FLAT, *skin.CURVATURES), SHADES, strict=False):
        profile = skin.profile("layered", curvature, skin.FORCES[1])
        top.plot(profile.place, profile.drive, color=color, label=f"{curvature:g} 1/m")
        bottom.plot(profile.place, profile.rate, "o-", ms=3, lw=1.0, color=color)
    top.set(ylabel="input / mm")
    bottom.set(xlabel="y (radial) / mm", ylabel="rate / Hz")
    top.legend()
    return drawn

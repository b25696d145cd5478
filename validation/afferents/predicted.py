"""Responses of the fitted units that were not fitted: holds, profiles, surround, bursts, jitter."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from fefinger.validation.afferents import data, experiments, patterns
from fefinger.validation.afferents.experiments import BAR, DEPTHS, PRELOAD, PROBE, pressed
from fefinger.validation.afferents.vibration import Probed

from fefinger.mechanics import get
from fefinger.neural.drives import DRIVE_BY_NAME
from fefinger.neural.recorded import fitted, simulate_recorded
from fefinger.neural.statistics import interval_variation
from fefinger.neural.variation import Variation
from fefinger.plan import choose, settled
from fefinger.scene.ask import Ask, Places
from fefinger.scene.indenters import Pin
from fefinger.scene.motions import Ramp, Trapezoid
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


TRIALS = 20
"""Repeated presses of a pin or an array of probes, each with noise of its own."""

DEPTH = np.linspace(0.0, 1.5, 31)
"""Depths in mm at which the drive under a pin is tabulated."""

PIN_DEPTHS = (0.2, 0.5, 1.0, 1.5)
"""mm: depths of the holds under a pin."""

PIN_BANDS = {
    1.0: ((0.0, 13.3), (11.7, 31.7), (35.0, 61.7), (51.7, 90.0)),
    2.0: ((-1.0, 1.0), (0.0, 15.0), (10.0, 30.0), (21.7, 45.0)),
}
"""Hz of SAI in them, by the width of the pin in mm: the least and the most of the four models of
units of TouchSim, whose pins have radii of 0.5 and 1 mm, 0.3 to 0.9 s after the start."""


def inputs(kind: str, driven: Array) -> Array:
    """Convert drives of a type to inputs in mm."""
    return fitted()[kind].length * driven


def fire(kind: str, time: Array, x: Array, *, factor: float = 1.0) -> list[Array]:
    """Spike times of units of a type with inputs x (n_t, n_units) mm."""
    unit = fitted()[kind]
    parameters = {kind: replace(unit, gain=factor * unit.gain)}
    types = (kind,) * x.shape[1]
    return list(simulate_recorded(time, x, types=types, parameters=parameters, check=False).times)


def between(times: Array, start: float, stop: float) -> float:
    """Rate in Hz of spikes between two times in s."""
    return float(np.count_nonzero((times >= start) & (times < stop)) / (stop - start))


@cache
def pin_table(kind: str, width: float = PROBE.width) -> Array:
    """Return the inputs in mm of a unit under a pin, some mm wide, at the depths DEPTH."""
    drive = fitted()[kind].drive
    below = pressed(Pin(width), DEPTH[1:], np.zeros(1), drive=drive, organ=DEPTHS[kind])[:, 0]
    return np.concatenate([[0.0], inputs(kind, below)])


def under_pin(kind: str, time: Array, depth: Array) -> Array:
    """Spike times of a unit under a pin that follows a depth (n_t,) mm."""
    x = np.interp(depth, DEPTH, pin_table(kind))
    return fire(kind, time, x[:, None])[0]


def population_under_pin(kind: str, time: Array, depth: Array, count: int = 8) -> list[Array]:
    """Spike times of units of a type with the fitted spread under a pin that follows a depth."""
    x = np.tile(np.interp(depth, DEPTH, pin_table(kind))[:, None], count)
    vary = Variation(seed=1, spread=None, noise=None)
    return list(
        simulate_recorded(time, x, types=(kind,) * count, variation=vary, check=False).times
    )


def trapezoid(depth: float, speed: float, hold: float) -> tuple[Array, Array]:
    """Time in s and depth in mm of a ramp, a hold and a retreat, and a rest of 0.3 s."""
    motion = Trapezoid(speed, depth, hold=hold)
    time = np.arange(0.0, motion.duration + 0.3, 5e-4)
    moved = motion.value(np.minimum(time, motion.duration))
    return time, np.where(time < motion.duration, moved, 0.0)


@cache
def pin_hold(width: float, factor: float = 1.0) -> Array:
    """SAI rates (4,) in Hz at PIN_DEPTHS of a pin, 0.3 to 0.9 s after the start.

    Means of TRIALS presses of the median unit, each with noise of its own.
    """
    out = []
    for depth in PIN_DEPTHS:
        time, moved = trapezoid(depth, 20.0, 1.2)
        x = np.interp(moved, DEPTH, pin_table("SAI", width))
        trials = fire("SAI", time, np.tile(x[:, None], TRIALS), factor=factor)
        out.append(np.mean([between(each, 0.3, 0.9) for each in trials]))
    return np.array(out)


@cache
def pin_factor() -> float:
    """Factor on the gain of SAI with which the deepest hold of the pin 2 mm wide is in mid-band."""
    factors = np.geomspace(0.1, 1.0, 25)
    rates = np.array([pin_hold(2.0, float(factor))[-1] for factor in factors])
    return float(np.exp(np.interp(np.mean(PIN_BANDS[2.0][-1]), rates, np.log(factors))))


def sustained(depth: float) -> float:
    """SAI rate in the fifth minute of a hold, over that in its first second."""
    time = np.linspace(0.0, 300.0, 6001)
    times = under_pin("SAI", time, np.minimum(time, depth))
    return between(times, 240.0, 300.0) / between(times, depth, depth + 1.0)


def crept(kind: str) -> int:
    """Impulses of a unit as the pin goes 1.5 mm deep at 0.01 mm/s and stays for a minute."""
    time = np.linspace(0.0, 210.0, 2101)
    return len(under_pin(kind, time, np.minimum(0.01 * time, 1.5)))


REACH = 1.0
"""mm on either side of a unit's middle over which its end organs lie: a field of some 4 mm
(Johansson 1978) less the millimeter on either side over which skin spreads strain."""


@cache
def spheres() -> tuple[Array, Array]:
    """SAI impulses and recorded rates (n,) by curvature and distance, in the order of the data.

    A unit has end organs in its middle and REACH away on either side; the best of them drives it.
    """
    points = data.table("curvature_distance_SAI")
    computed = np.empty(len(points))
    for curvature in np.unique(points[:, 0]):
        of = points[:, 0] == curvature
        organs = np.abs(points[of, 1] + np.array([[0.0], [-REACH], [REACH]]))
        time, driven = experiments.under_sphere(
            curvature, 0.147, organs.ravel(), drive="compressive", organ=DEPTHS["SAI"]
        )
        best = driven.reshape(len(time), *organs.shape).max(axis=1)
        times = fire("SAI", time, inputs("SAI", best))
        computed[of] = [np.count_nonzero(each < 1.0) for each in times]
    return computed, points[:, 2]


@cache
def bar_profile() -> tuple[Array, Array]:
    """Places in mm from the middle of the bar, and SAI rates in Hz in the first second of hold."""
    places = np.arange(-4.0, 4.01, 0.2)
    across = np.column_stack([places, np.zeros_like(places)])
    half = patterns.driven(
        patterns.heights(BAR.profile), 1.0, across, drive="compressive", organ=DEPTHS["SAI"]
    )
    time = np.concatenate([np.linspace(0, 0.05, 51), np.linspace(0.05, 1.05, 101)[1:]])
    x = np.outer(np.minimum(time / 0.05, 1.0), inputs("SAI", half))
    return places, np.array([between(each, 0.05, 1.05) for each in fire("SAI", time, x)])


def bar_recorded() -> tuple[Array, Array]:
    """Return the recorded places, from the middle of the bar, and rates."""
    points = data.table("bar_SAI")
    return points[:, 0] - 4.55, points[:, 1]


@dataclass(frozen=True)
class Edges:
    """Peaks in Hz on either side of a bar's middle, and the trough between them."""

    left: float
    right: float
    trough: float

    @property
    def ratio(self) -> float:
        """Trough over the mean of the peaks."""
        return self.trough / (0.5 * (self.left + self.right))


def edges(places: Array, rates: Array) -> Edges:
    """Find peaks and trough of a profile across the bar."""
    left, right = (rates[(side * places > 0.3) & (side * places < 2.2)].max() for side in (-1, 1))
    return Edges(float(left), float(right), float(rates[np.abs(places) < 0.8].min()))


BACKGROUND, DEEPER, RISE = 1.6, 2.4, 0.1
"""mm: depths of the array in the skin, and the height to which probes then rise out of it."""

TIP, PITCH, PROBES = Pin(0.5), 0.889, 73
"""A probe, whose width is an estimate; mm between neighbors; and their number: 73 sites on 50 mm²
(abstract)."""


@cache
def sites() -> Array:
    """Return the places (PROBES, 2) in mm of probes, a hexagonal lattice from the middle on."""
    first, second = (each.ravel() for each in np.mgrid[-8:9, -8:9])
    lattice = PITCH * np.column_stack([first + 0.5 * second, np.sqrt(0.75) * second])
    apart = np.round(np.linalg.norm(lattice, axis=1), 6)
    return np.asarray(lattice[np.argsort(apart, kind="stable")][:PROBES])


def array(count: int) -> patterns.Shape:
    """Return the shape of an array out of which `count` probes rise: the middle one first.

    The skin is free between the probes. On a plate without gaps the neighbors that rest hold the
    skin down about one that rises, and a further probe takes a third as much of its strain away.
    """
    lift, tip = (RISE if count else 0.0), patterns.heights(TIP.profile)

    def shape(at: Array) -> Array:
        apart = np.linalg.norm(at[..., None, :] - sites(), axis=-1)
        along = apart.min(axis=-1)
        end = tip(np.stack([along, np.zeros_like(along)], axis=-1))
        return np.asarray(end + np.where(apart.argmin(axis=-1) < count, 0.0, lift))

    return shape


@cache
def under_array(drive: str, organ: float, count: int, background: float = BACKGROUND) -> float:
    """Drive of an end organ below the middle of an array `background` mm deep; `count` rise."""
    deep = background + (RISE if count else 0.0)
    return float(patterns.driven(array(count), deep, np.zeros((1, 2)), drive=drive, organ=organ)[0])


def impulses(kind: str, rest: float, pressed_to: Array) -> Array:
    """Mean impulses (n,) of the median unit as its input in mm rises from rest to other values.

    The array has rested on the skin; probes rise at 20 mm/s and stay for 0.2 s.
    """
    time = np.concatenate([np.linspace(0.0, 0.005, 26), np.linspace(0.005, 0.2, 196)[1:]])
    way = np.minimum(time / 0.005, 1.0)[:, None]
    x = rest + way * (np.repeat(pressed_to, TRIALS) - rest)
    probed = Probed(kind, fitted()[kind], rest)
    counts = [len(each) for each in probed.fire(time, x, np.ones(x.shape[1]))]
    return np.reshape(counts, (-1, TRIALS)).mean(axis=1)


@cache
def surround(kind: str) -> Array:
    """Impulses (7,) of a unit under one to seven probes that rise out of an array."""
    drive, organ = fitted()[kind].drive, DEPTHS[kind]
    rest, *probes = inputs(kind, np.array([under_array(drive, organ, n) for n in range(8)]))
    return impulses(kind, float(rest), np.array(probes))


def suppression(kind: str) -> float:
    """Mean fall of the response by each further probe, from one to seven."""
    return _each(*surround(kind)[[0, -1]])


def strain_suppression(drive: str, organ: float, background: float) -> float:
    """Mean fall of what the probes add to a drive by each further one, from one to seven."""
    rest, one, seven = (under_array(drive, organ, count, background) for count in (0, 1, 7))
    return _each(one - rest, seven - rest)


def _each(one: float, seven: float) -> float:
    """Fall by each further probe, in proportion, between the responses to one and to seven."""
    return float(1.0 - (seven / one) ** (1 / 6))


@dataclass(frozen=True)
class Bursts:
    """Impulses of a unit at the onset, late in the hold and at the release of a pin."""

    onset: int
    hold: int
    release: int
    peak: float
    """Highest rate in Hz within the onset: one over the shortest interval."""


def bursts(kind: str, depth: float, speed: float) -> Bursts:
    """Impulses of a unit as a pin comes, stays for 1 s and goes."""
    time, moved = trapezoid(depth, speed, 1.0)
    times = under_pin(kind, time, moved)
    ramp = depth / speed + 0.02
    onset = times[times < ramp + 0.05]
    leaves = ramp + 1.0 - 0.02
    return Bursts(
        len(onset),
        int(np.count_nonzero((times > ramp + 0.2) & (times < leaves - 0.05))),
        int(np.count_nonzero(times > leaves - 0.02)),
        float(1.0 / np.diff(onset).min()) if len(onset) > 1 else 0.0,
    )


SPEEDS = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0])
"""mm/s of ramps."""


def onset_rates(kind: str, depth: float = 0.7) -> Array:
    """Mean rates (n,) in Hz within ramps at SPEEDS: impulses over the time of the ramp."""
    rates = []
    for speed in SPEEDS:
        time, moved = trapezoid(depth, speed, 0.5)
        times = under_pin(kind, time, moved)
        rates.append(np.count_nonzero(times < depth / speed + 0.02) / (depth / speed))
    return np.array(rates)


def log_tanh(rates: Array) -> float:
    """R² of the best a tanh(b log(1 + v / c)) through the rates at SPEEDS."""
    from scipy.optimize import curve_fit

    def law(v: Array, a: float, b: float, c: float) -> Array:
        return np.asarray(a * np.tanh(b * np.log1p(v / c)))

    best, _ = curve_fit(
        law, SPEEDS, rates, p0=(rates.max(), 0.5, 4.0), bounds=(0.0, np.inf), maxfev=20000
    )
    rest = rates - law(SPEEDS, *best)
    return float(1.0 - np.sum(rest**2) / np.sum((rates - rates.mean()) ** 2))


@cache
def field_width(kind: str, depth: float, part: float, units: int = 6) -> float:
    """Mean width in mm across the finger within which a branched unit has a part of its best input.

    The pin stays, units lie at places around it, with their published end organs.
    """
    places = np.arange(-4.0, 4.01, 0.25)
    widths = []
    for seed in range(units):
        scene = Scene(
            finger=experiments.SOFT,
            indenter=PROBE,
            motion=Ramp(1.0, depth, corner=0.0),
            ask=Ask(
                afferents="recorded",
                spikes=(kind,),
                population=Places(
                    places=tuple((0.0, float(y)) for y in places), branched=True, seed=seed
                ),
                depths={"SAI": DEPTHS["SAI"]},
                fields=False,
                pressure=False,
                rel_error=1.0,
            ),
        )
        response = get("pressed").respond(settled(scene, choose(scene, "pressed")))
        assert response.strain is not None
        assert response.sites is not None
        assert response.sites.unit is not None
        driven = DRIVE_BY_NAME[fitted()[kind].drive](response.strain[-1:], response.sites.normals)
        first = np.searchsorted(response.sites.unit, np.arange(len(places)))
        largest = np.maximum.reduceat(driven[0], first)
        widths.append(0.25 * np.count_nonzero(largest >= part))
    return float(np.mean(widths))


def jitter(kind: str, frequency: float, amplitude: float) -> float:
    """Compute the standard deviation in ms of the phase of spikes, one per cycle."""
    unit = fitted()[kind]
    probed = Probed(kind, unit, preload(kind))
    (times,) = probed.times(frequency, np.array([amplitude]), np.ones(1), 1.0)
    phase = np.exp(2j * np.pi * frequency * times[times > 0.1])
    return float(1e3 * np.sqrt(-2.0 * np.log(abs(phase.mean()))) / (2 * np.pi * frequency))


def preload(kind: str) -> float:
    """Input in mm of a unit under the probe at its preload."""
    return float(np.interp(PRELOAD, DEPTH, pin_table(kind)))


def variation(depth: float = 1.0) -> float:
    """Coefficient of variation of SAI intervals late in a hold under the pin."""
    time, moved = trapezoid(depth, 20.0, 6.0)
    times = under_pin("SAI", time, moved)
    return float(interval_variation(times[(times > 1.0) & (times < 6.0)]))


def stretched(size: float, seconds: float) -> Array:
    """Spike times of the SAII unit whose skin is stretched by a size within some seconds."""
    time = np.linspace(0.0, 2.0, 2001)
    x = inputs("SAII", size * np.minimum(time / seconds, 1.0))
    return fire("SAII", time, x[:, None])[0]


def stretch_threshold() -> float:
    """Smallest slow stretch at which the SAII unit fires."""
    sizes = np.arange(0.0005, 0.02, 0.0005)
    return float(next((size for size in sizes if len(stretched(size, 0.5))), np.nan))


def stretch_rate() -> float:
    """Rate in Hz of the SAII unit in the last half of a stretch by 6.4 % at 64 %/s."""
    return between(stretched(0.064, 0.1), 0.05, 0.1)

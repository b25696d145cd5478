"""Summary numbers of a result with their expected errors, for the terminal and the report."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from fefinger.results.candidate import MECHANICS
from fefinger.results.pressure import highest
from fefinger.results.records import Harmonic
from fefinger.results.result_record import QUANTITIES, WIDE, ResultRecord, range_text
from fefinger.scene.cautions import missing, unusual
from fefinger.scene.finger import RESOLUTIONS, STANDARD, other_size
from fefinger.scene.scene import Scene
from fefinger.support.text import percent


REFERENCE = "solid"
"""Mechanics against which errors are stated."""


SWINGS, OF_NOISE = 0.02, 5.0
"""Largest force below 0, over the peak and over the noise, of which no caution is needed."""


class KeyNumber(NamedTuple):
    """A number of a result: name, value with unit, relative error, rank and when or where.

    `error` is nan where it is not known, None for a prescribed or counted number. Numbers of low
    `rank` are shown where not all are.
    """

    name: str
    value: str
    error: float | None
    rank: int
    about: str = ""

    @property
    def within(self) -> str:
        """The error in words, as the range of the true value if it is large; "" without error."""
        if self.error is None:
            return ""
        if math.isnan(self.error):
            return "error not known"
        if self.error <= WIDE:
            return f"within {percent(self.error)}"
        answer, _, unit = self.value.partition(" ")
        return range_text(self.error, float(answer), unit)


def key_numbers(result: ResultRecord) -> Iterator[KeyNumber]:
    """Yield the numbers of the requested quantities, in the order that they are shown in."""
    rung = result.plan.chosen
    errors = {"force": rung.error, **rung.errors}
    by_force = result.scene.motion.by_force
    if result.force is not None:
        step = int(np.argmax(result.force))
        end = f"at {format_instant(result.time[step])}; {result.force[-1]:.3g} N at the end"
        error, rank, about = (None, 7, "prescribed") if by_force else (errors["force"], 1, end)
        yield KeyNumber("peak force", f"{result.force[step]:.3g} N", error, rank, about)
    deepest = int(np.argmax(result.depth))
    error = errors.get("depth", math.nan) if by_force else None
    rank = 1 if by_force else 7
    when = f"at {format_instant(result.time[deepest])}"
    yield KeyNumber("largest depth", f"{result.depth[deepest]:.3g} mm", error, rank, when)
    if result.lateral is not None:
        lateral = np.linalg.norm(result.lateral.force, axis=1)
        when = f"at {format_instant(result.time[np.argmax(lateral)])}"
        yield KeyNumber("largest lateral force", f"{lateral.max():.3g} N", math.nan, 3, when)
    if result.contact_area is not None and np.isfinite(result.contact_area).any():
        value = f"{np.nanmax(result.contact_area):.3g} mm²"
        yield KeyNumber("largest contact area", value, errors.get("area", math.nan), 4)
    if result.pressure is not None and result.pad is not None:
        pressure, (x, y, _) = highest(result.pad, result.pressure)
        error, where = errors.get("pressure", math.nan), f"at x = {x:z.1f} mm, y = {y:z.1f} mm"
        yield KeyNumber("highest pressure over 1 mm²", f"{pressure:.3g} kPa", error, 6, where)
    if result.strain is not None and result.sites is not None and result.strain.size:
        yield _strain(result, errors.get("strain", math.nan))
    if result.harmonic is not None:
        yield _impedance(result.harmonic)
    if result.spikes is not None:
        total, units = int(result.spikes.count().sum()), len(result.spikes)
        name = f"spikes of {units} unit{'s' if units > 1 else ''}"
        yield KeyNumber(name, str(total), None, 2, result.spikes.summary(result.unmodeled))


def rows(result: ResultRecord) -> list[tuple[str, str]]:
    """Return (name, text) of every number with its error, of friction, spikes and cautions."""
    lines = [("caution", caution) for caution in _unresolved(result)]
    for number in key_numbers(result):
        about = ", ".join(filter(None, (number.within, number.about)))
        if not number.name.startswith("spikes"):
            lines.append((number.name, f"{number.value}{f' ({about})' if about else ''}"))
    if result.lateral is not None and result.lateral.outcome:
        lines.append(("friction", result.lateral.outcome))
    if result.spikes is not None:
        fired = f"{result.spikes.summary(result.unmodeled)} (afferents: {result.spikes.family})"
        lines.append(("spikes", fired))
    lines += [("measured", misfit)] if (misfit := beside_record(result)) else []
    return [*lines, *(("caution", caution) for caution in cautions(result))]


def beside_record(result: ResultRecord) -> str:
    """Compare the answer with the quantity recorded beside its motion; "" without one."""
    motion = result.scene.motion
    measured = motion.beside(result.time)
    answer = result.depth if motion.by_force else result.force
    if measured is None or answer is None or not measured.max() > 0:
        return ""
    other = motion.control.other
    top = measured.max()
    misfit = float(np.sqrt(np.mean((answer - measured) ** 2)) / top)
    return (
        f"{other} of at most {top:.3g} {other.unit} in the record, of {answer.max():.3g} "
        f"{other.unit} in the answer, which is {percent(misfit)} of the peak off (root mean square)"
    )


def cautions(result: ResultRecord) -> list[str]:
    """Return sentences on what may mislead: large errors, noise or gaps, a finger's other size."""
    of_finger = map(_inner, other_size(result.scene.finger))
    found = [*_far_off(result), *_beyond_small(result), *_without_cause(result)]
    return [*found, *unusual(result.scene), *_record(result.scene), *of_finger]


def _unresolved(result: ResultRecord) -> list[str]:
    """Return sentences on an object that the mesh does not resolve, which stand before all else."""
    refusals = result.plan.overridden
    return [each.reason for each in refusals if each.field == "finger.resolution"]


def _without_cause(result: ResultRecord) -> list[str]:
    """Return a sentence on types of units that the mechanics gives no cause to fire, if any."""
    return [
        f"{kind} are not modeled here: without inertia they fire at the corners of the motion, as "
        "often at any speed, and neither at slip nor far from the object (--mechanics modal has "
        "inertia)"
        for kind in result.unmodeled
    ]


def _beyond_small(result: ResultRecord) -> list[str]:
    """Return a sentence on strain at end organs that is not small where it counts as small."""
    if result.strain is None or result.response.finite:
        return []
    low, high = result.principal
    largest = float(max(-low.min(initial=0.0), high.max(initial=0.0)))
    # Principal strain from which on small strain is cautioned of: its square is no longer small.
    not_small = 0.4
    if largest <= not_small:
        return []
    finite = ", ".join(name for name, traits in MECHANICS.items() if traits.finite)
    return [
        f"strain at an end organ reaches {percent(largest)}, which {result.response.mechanics} "
        f"computes as small strain; of finite strain are {finite} (--mechanics)"
    ]


def _record(scene: Scene) -> list[str]:
    """Return sentences on noise, gaps and forces below 0 in the samples of a motion."""
    found, motion = [], scene.motion
    if motion.pulling > max(SWINGS * motion.peak, OF_NOISE * motion.noise):
        found.append(
            f"the force of the record goes down to {-motion.pulling:.2g} N, which counts as 0: the "
            "swing of the probe, or a drift, may be in the readings of the press too"
        )
    if motion.noise and "FAII" in scene.ask.spikes:
        found.append(
            f"the samples of the motion have noise of {motion.noise:.2g} {motion.unit} (root mean "
            "square), which FAII may answer; filter it before you count their spikes"
        )
    return [*found, *map(_inner, missing(motion))]


def _inner(sentence: str) -> str:
    """Return a sentence without its capital letter and full stop."""
    return f"{sentence[0].lower()}{sentence[1:].removesuffix('.')}"


def _far_off(result: ResultRecord) -> list[str]:
    """Return a sentence on requested quantities with large errors, if any, and how to reduce them.

    The force is left out, whose error the scene limits.
    """
    chosen, ask = result.plan.chosen, result.scene.ask
    pressure, strain = ask.wants("pressure"), ask.wants("strain")
    wanted = {"pressure": pressure, "area": pressure, "strain": strain}
    far = [name for name, wish in wanted.items() if wish and chosen.errors.get(name, 0.0) > WIDE]
    if not far:
        return []
    worst = max(far, key=lambda name: chosen.errors[name])
    others = [rung for rung in result.plan.rungs if worst in rung.errors]
    best = min(others, key=lambda rung: rung.errors[worst])
    better = "no mechanics states less"
    # A mechanics is suggested where it states clearly less.
    if best.errors[worst] < 0.8 * chosen.errors[worst]:
        better = f"{best.candidate.on} states {percent(best.errors[worst])}"
        ways = [f"--mechanics {best.mechanics}"] * (best.mechanics != chosen.mechanics)
        if best.resolution not in (None, chosen.resolution, STANDARD):
            ways.append(f"--set finger.resolution={best.resolution}")
        better = f"{better} ({' '.join(ways)})" if ways else better
    elif chosen.resolution == RESOLUTIONS[0]:
        better = f"finger.resolution = {STANDARD!r} may help"
    elif REFERENCE not in {rung.mechanics for rung in result.plan.rungs}:
        better = f"the reference is {REFERENCE} (--mechanics {REFERENCE})"
    *first, last = (QUANTITIES[name] for name in far)
    names = f"{', '.join(first)} and {last}" if first else last
    why = ", as ask.rel_error limits the force alone" if chosen.error <= ask.rel_error else ""
    return [f"{names} may be far off{why}; for the {QUANTITIES[worst]}, {better}"]


def leading(result: ResultRecord, count: int) -> list[KeyNumber]:
    """Return the `count` numbers of lowest rank, in the order of `key_numbers`."""
    numbers = list(key_numbers(result))
    ranks = sorted(number.rank for number in numbers)[:count]
    return [number for number in numbers if number.rank in ranks][:count]


def _impedance(harmonic: Harmonic) -> KeyNumber:
    ends = " and ".join(f"{abs(each):.3g}" for each in harmonic.impedance[[0, -1]])
    low, high = harmonic.frequency[[0, -1]]
    return KeyNumber("impedance", f"{ends} N s/m", math.nan, 0, f"at {low:.3g} and {high:.3g} Hz")


def _strain(result: ResultRecord, error: float) -> KeyNumber:
    """Return the largest compressive principal strain at an end organ, of all and by type."""
    assert result.strain is not None
    assert result.sites is not None
    types, depths = result.sites.types, result.sites.depths
    by_site = -100 * result.principal[0].min(axis=0)
    largest = {
        kind: max(by_site[site] for site, each in enumerate(types) if each == kind)
        for kind in dict.fromkeys(types)
    }
    about = ", ".join(f"{kind} {each:.3g} %" for kind, each in largest.items() if kind)
    if len(largest) == 1:
        about = f"{depths[np.argmax(by_site)]:.3g} mm deep"
    name = "largest compressive strain at an end organ"
    return KeyNumber(name, f"{by_site.max():.3g} %", error, 5, about)


def format_instant(seconds: float) -> str:
    """Return a time in ms or s."""
    return f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.4g} s"

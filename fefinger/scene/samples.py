"""Motions of samples: straight lines between them, the band of their vibration, noise and gaps."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Self, cast, final

import numpy as np
from numpy.typing import ArrayLike

from fefinger.scene.key import Key, table
from fefinger.scene.motion import Motion
from fefinger.scene.oscillation import (
    BROAD,
    FAINT,
    FEWEST_SAMPLES,
    about_mean,
    noise,
    to_and_fro,
    white_noise,
)
from fefinger.scene.trajectory import Trajectory
from fefinger.support import recording_files
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number, reject_unknown
from fefinger.support.inputs import read_wave
from fefinger.support.recordings import Recording, Way
from fefinger.support.vocabulary import Control
from fefinger.theory.lumped.ramp_hold import free_samples


GAP = 5.0
"""Distance of two samples over the median from which on samples are missing between them."""

WAVE_NEEDS = ("amplitude", "preload")
"""Fields that a WAV file needs: its full scale, and what it vibrates about."""

WAVE_OPTIONS = (*WAVE_NEEDS, "settle")
"""Options of a motion from a WAV file; the last has a default."""

RECORD_OPTIONS = ("corner", "columns")
"""Options of a motion from another file."""

COLUMNS = Way("motion.columns", "columns = {{{name} = {column!r}}} in [motion]")
""""Where a scene says which column is which."""

FARTHEST = 1e3
"""Largest distance in mm of the object from the skin: more is another unit, or no number."""

SETTLE = 0.2
"""Time in s of the approach to a preload before a waveform from a file, and of the rest after."""


Times = Annotated[tuple[float, ...], Key("Times, rising; the first one counts as 0", unit="s")]
Depths = Annotated[
    tuple[float, ...] | None,
    Key("Depths; below 0 the object is off the skin", unit="mm", control=Control.DEPTH),
]
Forces = Annotated[
    tuple[float, ...] | None,
    Key("Forces; those below 0 count as 0", unit="N", control=Control.FORCE),
]
Measured = Annotated[
    tuple[float, ...] | None,
    Key("Forces that belong to the depths, or depths to the forces, to compare", unit="N or mm"),
]


class SampledMotion(Motion):
    """Times in s, and depths or forces, with straight lines between them."""

    time: tuple[float, ...]
    corner: float
    measured: tuple[float, ...] | None

    @property
    def prescribed(self) -> tuple[float, ...]:
        """Depths in mm, or forces in N."""
        return cast(tuple[float, ...], getattr(self, self.control))

    @cached_property
    def _since(self) -> Array:
        """Times (n,) in s since the first sample."""
        return np.array(self.time) - self.time[0]

    @cached_property
    def _course(self) -> Array:
        """Depths (n,) in mm, or forces in N without the reading before contact."""
        return np.array(self.prescribed) - self.tare

    @cached_property
    def tare(self) -> float:
        """Mean reading in N before contact, where it is below 0, which no contact is; else 0."""
        return min(_rest(np.array(self.prescribed)), 0.0) if self.by_force else 0.0

    @property
    def begins(self) -> float:
        """Time in s of the first sample, which counts as 0."""
        return self.time[0]

    def beside(self, t: ArrayLike) -> Array | None:
        """Interpolate the force in N or depth in mm recorded beside the motion; None without one.

        t (...,) s. A force has no reading before contact.
        """
        if self.measured is None:
            return None
        values = np.array(self.measured)
        values -= 0.0 if self.by_force else _rest(values)
        return np.asarray(np.interp(np.asarray(t, float), self._since, values))

    @cached_property
    def sample_rate(self) -> float | None:
        """Samples per s between the gaps of a record; None of few samples."""
        steps = np.diff(self._since)
        if len(steps) < FEWEST_SAMPLES:
            return None
        return float(1 / steps[steps <= GAP * np.median(steps)].mean())

    @property
    def highest_frequency(self) -> float | None:
        """Highest frequency in Hz with which the samples go to and fro; None if they do not.

        Noise does not count.
        """
        return None if self._colored_noise else self._band

    @property
    def oscillation_amplitude(self) -> float:
        """Largest distance of the samples from their mean over two cycles."""
        return float(np.abs(self._vibrating).max()) if self.highest_frequency else self.peak

    @property
    def noise(self) -> float:
        """Root mean square in mm or N of what is taken for noise; 0 without any."""
        return self._colored_noise or self._white_noise

    @cached_property
    def _white_noise(self) -> float:
        """Root mean square of white noise that would count as a vibration; 0 without."""
        if self.sample_rate is None:
            return 0.0
        time, values = self._even
        every = to_and_fro(time, values, white=False)
        return white_noise(values) if every is not None and every != self._band else 0.0

    @cached_property
    def _colored_noise(self) -> float:
        """Root mean square of what goes to and fro and is noise; 0 without."""
        if self._band is None or self.sample_rate is None:
            return 0.0
        broad = BROAD if self.by_force else FAINT
        return noise(self._vibrating, self.sample_rate / self._band, self.peak, broad)

    @property
    def missing(self) -> tuple[tuple[float, float], ...]:
        """Times (start, stop) in s of gaps in a record, vibrating or not; a level rest is none."""
        if self.sample_rate is None:
            return ()
        columns = [getattr(self, name) for name in (self.control, *self._columns)]
        time, moved = self._since, np.diff(columns).any(axis=0)
        wide = (np.diff(time) > GAP / self.sample_rate) & moved
        return tuple(zip(time[:-1][wide].tolist(), time[1:][wide].tolist(), strict=True))

    @property
    def pulling(self) -> float:
        """Largest force in N below 0 among the samples, which counts as 0; 0 without any."""
        return max(-float(self._course.min()), 0.0) if self.by_force else 0.0

    @property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Times (start, stop) in s of gaps in a vibration that hide half a cycle or more."""
        if self.highest_frequency is None or self.sample_rate is None:
            return ()
        time, values = self._since, self._course
        longest = max(GAP / self.sample_rate, 0.5 / self.highest_frequency)
        least = FAINT * self.oscillation_amplitude
        hidden = (np.diff(time) > longest) & (np.abs(np.diff(values)) > least)
        return tuple(zip(time[:-1][hidden].tolist(), time[1:][hidden].tolist(), strict=True))

    def vibration(self, t: ArrayLike) -> Array:
        """Return the distance of the samples from their mean over two cycles, at times `t` in s."""
        return np.asarray(np.interp(np.asarray(t, float), self._even[0], self._vibrating))

    @cached_property
    def _even(self) -> tuple[Array, Array]:
        """Times (n,) and values (n,) of the motion, evenly at the rate of the samples."""
        return self.evenly(self.control)

    def evenly(self, column: str) -> tuple[Array, Array]:
        """Return times (n,) and values (n,) of a column, evenly at the rate of the samples."""
        time = self._since
        values = self._course if column == self.control else np.array(getattr(self, column))
        steps = np.diff(time)
        uneven = 1e-3  # relative difference of the times between samples that counts as none
        if self.sample_rate is None or np.ptp(steps) <= uneven * steps.mean():
            return time, values
        # Largest number of even samples that the spectrum of uneven ones is taken from.
        most_even = 2**20
        count = min(most_even, 1 + round(time[-1] * self.sample_rate))
        even = np.linspace(0.0, time[-1], count)
        return even, np.interp(even, time, values)

    @cached_property
    def _band(self) -> float | None:
        """Frequency in Hz with which the samples go to and fro, noise or not."""
        return None if self.sample_rate is None else to_and_fro(*self._even)

    @cached_property
    def _vibrating(self) -> Array:
        """Distance (n,) of the even samples from their mean over two cycles; 0 without a band."""
        time, values = self._even
        if self._band is None:
            return np.zeros_like(values)
        return about_mean(values, 1 / (self._band * float(np.diff(time).mean())))

    @cached_property
    def steady_level(self) -> float:
        """Median of the samples above 0, the preload of a vibration, or else the largest."""
        if self.highest_frequency is None:
            return self.peak
        return float(np.median(self._course[self._course > 0]))

    @cached_property
    def trajectory(self) -> Trajectory:
        """The lines; InputError for times or values that are none of a motion."""
        self._check_samples()
        return self._through(np.maximum(self._course, 0.0) if self.by_force else self._course)

    def _through(self, values: ArrayLike) -> Trajectory:
        return Trajectory.through(self._since, values, corner=self.corner, stop=False)

    @property
    def _columns(self) -> tuple[str, ...]:
        """Names of the columns besides time and depth or force."""
        return ()

    def _check_samples(self) -> None:
        beside = ("measured",) if self.measured is not None else ()
        for name in (self.control, *self._columns, *beside):
            count = len(getattr(self, name))
            if len(self.time) != count or count < 2:
                raise InputError(
                    f"motion.{name}: expected as many values as times, at least 2, "
                    f"received {count} values and {len(self.time)} times"
                )
        late = np.flatnonzero(np.diff(self._since) <= 0)
        if late.size:
            i = int(late[0]) + 1
            raise InputError(
                f"motion.time[{i}]: expected a time above {self.time[i - 1]!r} s, received "
                f"{self.time[i]!r}; sort the samples and keep one of each time"
            )
        values, low, high = self._course, float(self._course.min()), float(self._course.max())
        if not self.by_force and _upside_down(float(values[0]), low, high):
            raise InputError(
                f"motion.depth: expected a press, received {values[0]:g} mm first and values down "
                f"to {low:g} mm; depth grows into the finger: change the sign"
            )
        if not self.by_force and low < -FARTHEST:
            raise InputError(
                f"motion.depth: expected depths of at least {-FARTHEST:g} mm, received {low:g} mm; "
                "below 0 the object is off the skin: check the unit, or cut off what is no press"
            )
        if high <= 0:
            raise InputError(
                f"motion.{self.control}: expected a value above 0, received at most "
                f"{high:g}; so the indenter never touches the finger"
            )
        # Largest force below 0 over the peak that counts as 0: after a release that of the swinging
        # probe is up to a tenth, of a record with another sign all of it.
        released = 0.25
        if self.by_force and self.pulling > released * high:
            raise InputError(
                f"motion.force: expected forces of at least 0 N, as a contact cannot pull, "
                f"received {low:g} to {high:g} N; change the sign if forces grow downward, or cut "
                f"off what is not the press. Down to {-100 * released:g} % of the peak values "
                "count as 0"
            )

    @classmethod
    def from_file(cls, file: str | Path, *, control: str = Control.DEPTH, **options: Any) -> Self:
        """Read a motion from a record, or from a WAV file with the `options` of `from_wav`.

        `control` is "depth" or "force", whichever the samples are. Others are read by `from_csv`.
        """
        if Path(file).suffix.lower() == ".wav":
            reject_unknown("motion", options, WAVE_OPTIONS)
            for name in WAVE_NEEDS:
                if name not in options:
                    msg = f"motion.{name}: missing; a WAV file needs {' and '.join(WAVE_NEEDS)}"
                    raise InputError(msg)
            return cls.from_wav(file, control=control, **options)
        reject_unknown("motion", options, RECORD_OPTIONS)
        return cls.from_csv(file, control=control, **options)

    @classmethod
    def from_wav(
        cls,
        file: str | Path,
        *,
        amplitude: float,
        preload: float,
        settle: float = SETTLE,
        control: str = Control.DEPTH,
    ) -> Self:
        """Read a waveform, as a vibration about a preload.

        Its full scale is `amplitude` in mm or, with control = "force", in N; the preload is reached
        within `settle` s, and held as long. Of several channels the first is taken.

        Raises InputError for no WAV file, or one without sound.
        """
        amplitude = number("motion.amplitude", amplitude, above=0)
        preload = number("motion.preload", preload, above=0)
        settle = number("motion.settle", settle, above=0, unit="s")
        rate, wave = read_wave("motion.file", Path(file))
        ramp = int(np.ceil(settle * rate))
        way = np.minimum(np.arange(2 * ramp) / ramp, 1.0)
        approach = preload * (1 - np.cos(np.pi * way)) / 2
        values = np.concatenate([approach, preload + amplitude * wave])
        times = np.arange(len(values)) / rate
        return cls(**{"time": tuple(times.tolist()), Control(control): tuple(values.tolist())})

    @classmethod
    def from_csv(
        cls,
        file: str | Path,
        *,
        control: str = Control.DEPTH,
        corner: float = 0.0,
        columns: Mapping[str, str] | None = None,
    ) -> Self:
        """Read time (s) and depth (mm) or force (N), as `control` says, from the file of a record.

        A text such as CSV, LabVIEW's `.lvm`, `.mat` or HDF5; columns are found by names and units.
        `columns`: headers of those that cannot be told, as {"force": "channel 2 in mN"}. A force
        beside depths, or depths beside a force, is `measured`.

        Raises InputError for a file that cannot be read, or a column that cannot be told.
        """
        record = recording_files.read(f"motion.file: {str(file)!r}", file)
        given_columns = table("motion.columns", columns or {}, "force = 'channel 2 in mN'")
        named = {name: str(header) for name, header in given_columns.items()}
        names = (*cls._read_columns(record, named), Control(control))
        values = record.pick(names, named, also=Control(control).other, say=COLUMNS)
        names = (*names, "measured")[: values.shape[1]]
        given: dict[str, Any] = {
            name: tuple(column.tolist()) for name, column in zip(names, values.T, strict=True)
        }
        return cls(**given | {"corner": corner})

    @classmethod
    def _read_columns(cls, record: Recording, named: Mapping[str, str]) -> tuple[str, ...]:
        """Names of the columns of a record that are read besides depth or force."""
        return ("time",)


@final
@dataclass(frozen=True)
class Sampled(SampledMotion):
    """Depths in mm or forces in N at times in s, joined by straight lines.

    They are rounded only if a corner is given. The times increase, from the first one on; below a
    depth of 0 the indenter is off the finger, and so it is where a force is below 0.
    """

    shape = "sampled"

    time: Times
    corner: float = field(default=0.0, kw_only=True)
    depth: Depths = None
    force: Forces = field(default=None, kw_only=True)
    measured: Measured = field(default=None, kw_only=True)


def _rest(values: Array) -> float:
    """Return the mean of readings (n,) before contact; 0 if it is none for certain."""
    free = free_samples(values)
    fewest_free = 5  # readings before contact from which on their mean is known
    if not fewest_free <= free < len(values):
        return 0.0
    mean, scatter = float(values[:free].mean()), float(values[:free].std())
    certain = 3.0  # standard deviations of a mean from which on it is below 0
    return mean if abs(mean) > certain * scatter / np.sqrt(free) else 0.0


def _upside_down(first: float, low: float, high: float) -> bool:
    """Whether depths fall from where they start: the sign of a press is the other one.

    Those that rise from far off the skin, or leave it after a press, are a motion.
    """
    falls = first > high / 2 or (high < FAINT * -low and first > low / 2)
    return -low > high and falls

"""Whether even samples go to and fro, how fast, and what of that is noise of a recorder."""

import numpy as np

from fefinger.support.arrays import Array


FEWEST_SAMPLES = 64
"""Samples from which on a motion has a spectrum."""

SAMPLED = 10.0
"""Samples per cycle below which straight lines between them change the force by more than 2 %."""

FAINT = 0.01
"""Amplitude over the peak below which a vibration of few samples is noise of a record."""

BROAD = 0.1
"""Amplitude over the peak below which a force may be noise of its sensor, which has some percent
under a light touch."""


def to_and_fro(time: Array, values: Array, *, white: bool = True) -> float | None:
    """Frequency in Hz with which even samples (n,) go to and fro; None if they do not.

    Below it lies all but a hundredth of the power of the speed, halved as often as a slower
    course with sharp corners needs: corners alone are no vibration. white: whether white noise is
    left out, whose spectrum has no end.
    """
    step = float(np.diff(time).mean())
    speed = np.diff(values) / step
    power = np.abs(np.fft.rfft(speed)) ** 2
    if white:
        spectrum = _spectrum(values)
        # Power over that of white noise from which on a frequency is more than noise, which reaches
        # it at one in half a billion frequencies.
        above = 20.0
        power[spectrum < above * _floor(spectrum)] = 0.0
    power = np.cumsum(power)
    # Share of the power of the speed beyond the highest frequency of samples.
    neglected_power = 1e-2
    place = int(np.searchsorted(power, (1 - neglected_power) * power[-1]))
    frequency = float(np.fft.rfftfreq(len(speed), step)[place])
    while frequency * time[-1] >= 1:
        if _alternates(about_mean(values, 1 / (frequency * step)), frequency * step):
            return frequency
        frequency /= 2
    return None


def white_noise(values: Array) -> float:
    """Return the root mean square of the white noise in even values (n,)."""
    return float(np.sqrt(_floor(_spectrum(values)) / (len(values) - 1)))


def noise(vibrating: Array, per_cycle: float, peak: float, broad: float = FAINT) -> float:
    """Root mean square of a vibration (n,) that is noise of a recorder; 0 for another one.

    Noise is faint, and has few samples per cycle or is there from the start. What is there from the
    start may be larger, up to `broad` of the peak, where no frequency stands out.
    """
    size = float(np.sqrt(np.mean(vibrating**2)))
    # The mean over two cycles is not that of a ramp before the second one.
    first_cycles = 4  # number of cycles that tell how a vibration starts
    begin, count = int(per_cycle) + 1, max(int(first_cycles * per_cycle), FEWEST_SAMPLES // 4)
    first = np.abs(vibrating[begin : begin + count])
    # Median of a vibration in its first cycles over its size, from which on it is there from the
    # start: that of noise is 0.67, or 0.45 of noise about 0 whose values below are set to 0.
    at_start = 0.25
    from_start = first.size > 0 and float(np.median(first)) > at_start * size
    part = np.sqrt(2) * size / peak
    if part < FAINT:
        return size if per_cycle < SAMPLED or from_start else 0.0
    return size if from_start and part < broad and not _has_lines(vibrating, per_cycle) else 0.0


def about_mean(values: Array, cycle: float) -> Array:
    """Distance of samples (n,) from their mean over two cycles, of `cycle` samples each."""
    return np.asarray(values - _mean(values, min(int(cycle), (len(values) - 1) // 2)))


def _mean(values: Array, half: int) -> Array:
    """Return the running mean (n,) of values, of `half` samples on either side."""
    total = np.cumsum(np.pad(values, (half + 1, half), mode="edge"))
    return np.asarray((total[2 * half + 1 :] - total[: -2 * half - 1]) / (2 * half + 1))


def _spectrum(values: Array) -> Array:
    """Return the powers of all but the last of even values (n,), in a window of mean square 1."""
    window = np.sqrt(8 / 3) * np.hanning(len(values) - 1)
    return np.asarray(np.abs(np.fft.rfft(window * (values - values.mean())[:-1])) ** 2)


def _floor(spectrum: Array) -> float:
    """Return the mean power of white noise, by the median in the upper half, which no line moves.

    Its powers are distributed exponentially, with the median ln 2.
    """
    return float(np.median(spectrum[len(spectrum) // 2 :]) / np.log(2))


def _has_lines(vibrating: Array, per_cycle: float) -> bool:
    """Whether a twentieth of the frequencies of a vibration (n,) hold half of its power.

    Of noise in a band they hold a fifth.
    """
    inside = _spectrum(vibrating)[: int(len(vibrating) / per_cycle) + 2]
    strongest = np.sort(inside)[-max(len(inside) // 20, 1) :]
    return bool(strongest.sum() > inside.sum() / 2)


def _alternates(vibrating: Array, cycles: float) -> bool:
    """Whether values (n,) go to and fro, with `cycles` per sample, other than at single corners.

    They are taken as means over a quarter of a cycle, which leaves noise out.
    """
    vibrating = _mean(vibrating, int(0.125 / cycles))
    strong = np.flatnonzero(np.abs(vibrating) > np.sqrt(np.mean(vibrating**2)) / 2)
    turns = strong[1:][np.diff(np.sign(vibrating[strong])) != 0]
    # Changes of sign about the mean from which on a motion vibrates: those of two cycles.
    fewest_turns = 3
    # Cycles of a frequency between two changes from which on a motion does not vibrate with it.
    longest_turn = 2.0
    return len(turns) >= fewest_turns and bool(np.median(np.diff(turns)) * cycles < longest_turn)

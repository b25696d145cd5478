"""Waveforms from WAV files."""

import warnings
from pathlib import Path

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


def read_wave(name: str, file: Path) -> tuple[int, Array]:
    """Return samples per s and the samples (n,) of the first channel, from -1 to 1.

    Raises
    ------
    InputError
        No WAV file, or one that is silent; `name` is the field that names it.
    """
    from scipy.io import wavfile

    check_input(name, file, "a WAV file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)  # chunks that hold no sound
            rate, samples = wavfile.read(file)
    except Exception as error:  # the reader raises whatever it meets, as UnboundLocalError
        raise InputError(f"{name}: expected a WAV file, received {str(file)!r}: {error}") from None
    first = samples if samples.ndim == 1 else samples[:, 0]
    if len(first) < 2:
        message = f"{name}: expected at least 2 samples, received {len(first)} in {str(file)!r}"
        raise InputError(message)
    wave = first.astype(np.float64)
    if first.dtype == np.uint8:
        wave = (wave - 128.0) / 128.0
    elif np.issubdtype(first.dtype, np.integer):
        wave = wave / -float(np.iinfo(first.dtype).min)
    if not (np.isfinite(wave).all() and np.abs(wave).max() <= 1.0):
        raise InputError(f"{name}: expected samples from -1 to 1, received others in {str(file)!r}")
    if not wave.any():
        message = f"{name}: expected a WAV file with sound, received {str(file)!r}, which is silent"
        raise InputError(message)
    return int(rate), wave

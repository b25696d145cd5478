"""Indenters and motions that a scene reads from files, and the keys that say how."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from fefinger.scene.key import Key, KeyField
from fefinger.scene.samples import RECORD_OPTIONS, WAVE_OPTIONS, Sampled
from fefinger.scene.sliding import SampledPath
from fefinger.scene.textured import Relief
from fefinger.support.vocabulary import Control


class FileReader(NamedTuple):
    """Reader of an indenter or motion from a file: function, format, other keys of the table."""

    read: Callable[..., Any]
    format: str
    keys: tuple[str, ...]


RECORD = "CSV, LVM, MAT, HDF5"
"""Formats of records."""


def _beside_file(text: str, hint: object = float, **facts: Any) -> KeyField:
    return KeyField(Key(text, **facts), hint, None, needed=False)


SAMPLES = (*RECORD_OPTIONS, *WAVE_OPTIONS)
"""Other keys of a motion from a file: the first ones of a record, the others of WAV."""

FILE_KEYS = {
    "pitch": _beside_file("Spacing of the samples of an image or a surface", unit="mm", above=0),
    "height": _beside_file("Height of white over black in an image", unit="mm", above=0),
    "center": _beside_file("Whether the middle of the file lies under first touch", bool),
    "columns": _beside_file(
        "Headers or numbers of columns that cannot be told, as 'channel 2 in mN'",
        Mapping[str, str],
        free=True,
    ),
    "amplitude": _beside_file("Full scale of a WAV file", unit="mm or N", above=0),
    "preload": _beside_file("Value that a WAV file vibrates about", unit="mm or N", above=0),
    "settle": _beside_file(
        "Time of the approach to the preload, and of the rest after", unit="s", above=0
    ),
}
"""Keys that say how a file is read, besides those of the record that it is read to."""

FROM_FILE = {
    Relief.kind: FileReader(
        Relief.from_file,
        "CSV, NPZ, PNG or STL",
        ("pitch", "height", "center", "angle", "tilt", "roll", "friction", "friction_kinetic"),
    ),
    **{
        kind: FileReader(partial(read, control=Control.of_kind(kind)), written, others)
        for kind, read, written, others in (
            ("sampled", Sampled.from_file, f"{RECORD} or WAV", SAMPLES),
            ("force-sampled", Sampled.from_file, f"{RECORD} or WAV", SAMPLES),
            ("sampled-path", SampledPath.from_csv, RECORD, RECORD_OPTIONS),
            ("force-sampled-path", SampledPath.from_csv, RECORD, RECORD_OPTIONS),
        )
    },
}
"""Kinds of indenters and motions that can be read from the `file` of their table."""

"""Reader of relief files: heights on a rectangular grid, as CSV, NPZ, PNG or STL."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.geometry.height_map import MOST, height_map
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number
from fefinger.support.csv_columns import is_numeric, read_columns, read_matrix, read_table
from fefinger.support.inputs import check_input


if TYPE_CHECKING:
    from numpy.lib.npyio import NpzFile


MEANING = {
    "pitch": "the distance in mm of the pixels of a PNG, the samples of an STL or the numbers of a "
    "CSV file of heights alone, as 0.1",
    "height": "the height in mm of white over black in a PNG, as 0.5",
}
COLUMNS = ("x", "y", "height")


def read_relief(
    file: Path, pitch: float | None, height: float | None, *, center: bool = False
) -> tuple[Any, Any, Any]:
    """Read x (n_x,), y (n_y,) and heights (n_x, n_y) in mm from a file.

    center: whether the middle of x and y becomes 0.

    A CSV file begins with the line "x,y,height" and has one row per place of a full grid, in any
    order; or, with a `pitch`, it holds heights in mm alone, which lie as the pixels of a PNG. An
    NPZ archive has arrays x (n_x,), y (n_y,) and height (n_x, n_y). A PNG has `pitch` mm
    between its pixels, x to the right and y upward about its middle, and `height` mm from black to
    white. An STL (mm, z toward the finger) is sampled every `pitch` mm from its first corner on.

    Raises InputError if the file cannot be read or used, its places do not fill a grid, or pitch or
    height are missing, or one too many.
    """
    check_input("indenter.file", file, "a file of heights")
    kind = file.suffix.lower()
    needs = {".png": ("pitch", "height"), ".stl": ("pitch",)}.get(kind, ())
    for name, value in (("pitch", pitch), ("height", height)):
        if name in needs and value is None:
            raise InputError(f"indenter.{name}: missing; {str(file)!r} needs {MEANING[name]}")
        allowed = (*needs, "pitch") if kind == ".csv" else needs
        if name not in allowed and value is not None:
            message = (
                f"indenter.{name}: expected none with {str(file)!r}, received {value!r}; it is"
            )
            raise InputError(f"{message} {MEANING[name]}")
    if kind == ".png" or (kind == ".csv" and pitch is not None):
        step = number("indenter.pitch", pitch, above=0, unit="mm")
        if kind == ".png":
            values = _picture(file) * number("indenter.height", height, above=0, unit="mm")
        else:
            values = _turned(read_matrix(f"indenter.file: {str(file)!r}", file, MOST))
        x, y = (step * (np.arange(n) - (n - 1) / 2) for n in values.shape)
    elif kind == ".stl":
        x, y, values = height_map(file, number("indenter.pitch", pitch, above=0, unit="mm"))
    else:
        x, y, values = _archive(file) if kind == ".npz" else _table(file)
    if values.shape != (len(x), len(y)):
        raise InputError(
            f"indenter.file: expected heights of shape (x, y) = ({len(x)}, {len(y)}) in "
            f"{str(file)!r}, received {values.shape}"
        )
    if values.size > MOST:
        raise InputError(
            f"indenter.file: expected at most {MOST} heights in {str(file)!r}, received "
            f"{len(x)} x {len(y)}; take a coarser grid, or the part that the finger meets"
        )
    if center:
        x, y = (lines - (lines[0] + lines[-1]) / 2 for lines in (x, y))
    return x.tolist(), y.tolist(), values.tolist()


def _picture(file: Path) -> Array:
    """Read the gray values (n_x, n_y) of a picture, from 0 to 1."""
    from matplotlib.image import imread

    with open(file, "rb") as opened:
        header = opened.read(24)  # which ends with width and height
    width, height = (int.from_bytes(header[k : k + 4], "big") for k in (16, 20))
    if (
        header.startswith(b"\x89PNG") and width * height > MOST
    ):  # before they are unpacked: black is a small file
        raise InputError(
            f"indenter.file: expected at most {MOST} pixels in {str(file)!r}, received "
            f"{width} x {height}; take a coarser picture, or the part that the finger meets"
        )
    try:
        pixels = np.asarray(imread(file, format="png"), dtype=np.float64)
    except (OSError, ValueError, SyntaxError) as error:
        raise InputError(f"indenter.file: cannot read the picture {str(file)!r}: {error}") from None
    gray = pixels if pixels.ndim == 2 else pixels[..., : min(3, pixels.shape[2])].mean(axis=2)
    return _turned(gray)


def _turned(rows: Array) -> Array:
    """Heights (n_x, n_y) of rows that are seen from above, x to the right and y upward."""
    return np.ascontiguousarray(rows[::-1].T)


def _archive(file: Path) -> tuple[Array, ...]:
    """Read x, y and heights from an NPZ archive."""
    try:
        # Opened here: numpy leaves a damaged file open.
        with open(file, "rb") as opened, np.load(opened, allow_pickle=False) as archive:
            x, y, height = (_numbers(archive, name) for name in COLUMNS)
    except Exception as error:  # the readers raise whatever they meet
        msg = f"indenter.file: expected arrays x, y and height in {str(file)!r}: {error}"
        raise InputError(msg) from None
    return x.ravel(), y.ravel(), height


def _numbers(archive: "NpzFile", name: str) -> Array:
    """Read an array of real numbers; zeros of any number are a small file."""
    assert archive.zip is not None  # it is open
    # The longest number is a long double of 16 bytes.
    if archive.zip.getinfo(f"{name}.npy").file_size > 16 * MOST:
        raise ValueError(f"{name} has more than {MOST} numbers")
    values = archive[name]
    if values.dtype.kind not in "fiu":
        raise ValueError(f"{name} has other values than real numbers: {values.dtype}")
    return np.asarray(values, dtype=np.float64)


def _table(file: Path) -> tuple[Array, ...]:
    """Read x, y and heights from a CSV file."""
    first = read_table(f"indenter.file: {str(file)!r}", file).header
    if is_numeric(first):
        raise InputError(
            f"indenter.pitch: missing; {str(file)!r} has no first line 'x,y,height', and heights "
            "alone need the distance in mm between them, as 0.1"
        )
    across, along, heights = map(np.array, read_columns("indenter.file", file, COLUMNS, MOST))
    x, i = np.unique(across, return_inverse=True)
    y, j = np.unique(along, return_inverse=True)
    places = np.zeros(len(heights), bool)
    if len(heights) == len(x) * len(y):
        places[i * len(y) + j] = True
    if not places.all():
        raise InputError(
            f"indenter.file: expected one row for each place of a grid in {str(file)!r}, received "
            f"{len(heights)} rows for {len(x)} x {len(y)} places"
        )
    grid = np.empty((len(x), len(y)))
    grid[i, j] = heights
    return x, y, grid

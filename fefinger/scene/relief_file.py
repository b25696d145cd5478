"""Reader of relief files: heights on a rectangular grid, as CSV, NPZ, PNG or STL."""

from pathlib import Path

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number
from fefinger.support.csv_columns import read_columns
from fefinger.support.outputs import check_input


Numbers = tuple[float, ...]
MEANING = {
    "pitch": "the distance in mm of the pixels of a PNG or the samples of an STL, as 0.1",
    "height": "the height in mm of white over black in a PNG, as 0.5",
}
COLUMNS = ("x", "y", "height")


def read_relief(
    file: Path, pitch: float | None, height: float | None
) -> tuple[Numbers, Numbers, tuple[Numbers, ...]]:
    """Read x, y and heights (n_x, n_y) in mm from a file of any format.

    CSV and NPZ hold their grid, see `read_heights`. A PNG has `pitch` mm between its pixels, x to
    the right and y upward about its middle, and `height` mm from black to white. An STL (mm, z
    towards the finger) is sampled every `pitch` mm from its first corner on.

    Raises
    ------
    InputError
        The file cannot be read or used, or pitch or height are missing, or one too many.
    """
    kind = file.suffix.lower()
    needs = {".png": ("pitch", "height"), ".stl": ("pitch",)}.get(kind, ())
    for name, value in (("pitch", pitch), ("height", height)):
        if name in needs and value is None:
            raise InputError(f"indenter.{name}: missing; {str(file)!r} needs {MEANING[name]}")
        if name not in needs and value is not None:
            message = (
                f"indenter.{name}: expected none with {str(file)!r}, received {value!r}; it is"
            )
            raise InputError(f"{message} {MEANING[name]}")
    check_input("indenter.file", file, "a file of heights")
    if not needs:
        return read_heights(file)
    step = number("indenter.pitch", pitch, above=0, unit="mm")
    if kind == ".png":
        values = _picture(file) * number("indenter.height", height, above=0, unit="mm")
        lines = [step * (np.arange(n) - (n - 1) / 2) for n in values.shape]
    else:
        from fefinger.geometry.height_map import height_map

        *lines, values = height_map(file, step)
    rows = tuple(map(tuple, values.tolist()))
    return tuple(lines[0].tolist()), tuple(lines[1].tolist()), rows


def _picture(file: Path) -> Array:
    """Read the gray values (n_x, n_y) of a picture, from 0 to 1."""
    from matplotlib.image import imread

    try:
        pixels = np.asarray(imread(file, format="png"), dtype=np.float64)
    except (OSError, ValueError, SyntaxError) as error:
        raise InputError(f"indenter.file: cannot read the picture {str(file)!r}: {error}") from None
    gray = pixels if pixels.ndim == 2 else pixels[..., : min(3, pixels.shape[2])].mean(axis=2)
    return np.ascontiguousarray(gray[::-1].T)


def read_heights(file: Path) -> tuple[Numbers, Numbers, tuple[Numbers, ...]]:
    """Read x (n_x,), y (n_y,) and heights (n_x, n_y) in mm from a file.

    A CSV file begins with the line "x,y,height" and has one row per place of a full grid, in any
    order. An NPZ archive has arrays x (n_x,), y (n_y,) and height (n_x, n_y).

    Raises
    ------
    InputError
        The file cannot be read, or its places do not fill a grid.
    """
    x, y, height = _archive(file) if file.suffix.lower() == ".npz" else _table(file)
    if height.shape != (len(x), len(y)):
        raise InputError(
            f"indenter.file: expected heights of shape (x, y) = ({len(x)}, {len(y)}) in "
            f"{str(file)!r}, received {height.shape}"
        )
    rows = tuple(tuple(row) for row in height.tolist())
    return tuple(x.tolist()), tuple(y.tolist()), rows


def _archive(file: Path) -> tuple[Array, ...]:
    """Read x, y and heights from an NPZ archive."""
    try:
        with np.load(file, allow_pickle=False) as archive:
            x, y, height = (np.asarray(archive[name], dtype=np.float64) for name in COLUMNS)
    except (OSError, ValueError, KeyError, EOFError) as error:
        msg = f"indenter.file: expected arrays x, y and height in {str(file)!r}: {error}"
        raise InputError(msg) from None
    return x.ravel(), y.ravel(), height


def _table(file: Path) -> tuple[Array, ...]:
    """Read x, y and heights from a CSV file."""
    across, along, heights = map(np.array, read_columns("indenter.file", file, COLUMNS))
    x, i = np.unique(across, return_inverse=True)
    y, j = np.unique(along, return_inverse=True)
    grid = np.full((len(x), len(y)), np.nan)
    grid[i, j] = heights
    if np.isnan(grid).any() or len(heights) != grid.size:
        raise InputError(
            f"indenter.file: expected one row for each place of a grid in {str(file)!r}, received "
            f"{len(heights)} rows for {len(x)} x {len(y)} places"
        )
    return x, y, grid

"""Heights of a surface mesh over a plane: the upper side of an object, as a relief."""

from pathlib import Path

import numpy as np

from fefinger.geometry.finger_mesh import barycentric
from fefinger.geometry.surface_load import FARTHEST
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


MARGIN = 1e-9
"""Barycentric coordinate by which a place may lie outside a triangle, for those on its edge."""


MOST = 1_000_000
"""Largest number of heights: on all of the pad, a tenth of the edges of a mesh apart."""


def height_map(file: Path, pitch: float) -> tuple[Array, Array, Array]:
    """Return x (n_x,), y (n_y,) and the largest z (n_x, n_y) in mm of a surface file.

    The places are `pitch` mm apart and cover the surface from its smallest x and y on.

    Raises InputError if the file cannot be read, or its surface has a hole as seen along z.
    """
    import trimesh

    try:
        with np.errstate(over="ignore", invalid="ignore"):
            mesh = trimesh.load_mesh(file)
        corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.faces]
    except Exception as error:  # the readers raise whatever they meet
        raise InputError(f"indenter.file: cannot read the surface {str(file)!r}: {error}") from None
    if len(corners) == 0:
        raise InputError(f"indenter.file: expected triangles in {str(file)!r}, received none")
    if not (np.abs(corners) < FARTHEST).all():
        raise InputError(
            f"indenter.file: expected finite coordinates, below {FARTHEST:g} mm, in {str(file)!r}"
        )
    low, high = corners[..., :2].min(axis=(0, 1)), corners[..., :2].max(axis=(0, 1))
    counts = np.floor((high - low) / pitch * (1 + MARGIN)).astype(int) + 1
    if counts.prod(dtype=float) > MOST:
        raise InputError(
            f"indenter.pitch: expected at most {MOST} samples of {str(file)!r}, received "
            f"{counts[0]} x {counts[1]}; take a larger one"
        )
    x, y = (low[k] + pitch * np.arange(counts[k]) for k in (0, 1))
    heights = np.full(counts, -np.inf)
    _raise(heights, corners, low, pitch)
    if not np.isfinite(heights).all():
        share = float(np.isinf(heights).mean())
        raise InputError(
            f"indenter.file: expected a surface in {str(file)!r} that covers its box of "
            f"{' x '.join(f'{size:.3g}' for size in high - low)} mm as seen along z, received one "
            f"that leaves {100 * share:.0f} % of it open; cut it to a rectangle or put it on a "
            "plate, and check that it is in mm"
        )
    return x, y, heights


def _raise(heights: Array, triangles: Array, low: Array, pitch: float) -> None:
    """Raise the heights (n_x, n_y) to triangles (n, 3, 3); vertical ones have no places under them.

    low: x and y of the first place.
    """
    across = triangles[:, 1:, :2] - triangles[:, :1, :2]
    flat = np.square(across).max(axis=(1, 2), initial=0.0)
    triangles = triangles[np.abs(np.linalg.det(across)) > MARGIN * flat]
    ends = (triangles[..., :2].min(axis=1), triangles[..., :2].max(axis=1))
    first, last = ((end - low) / pitch for end in ends)
    # Part of a spacing, or of a triangle, by which a place may lie beyond a triangle that it is on.
    slack = 1e-6
    begin = np.maximum(np.ceil(first - slack).astype(int), 0)
    counts = np.minimum(np.floor(last + slack).astype(int) + 1, heights.shape) - begin
    counts = np.maximum(counts, 0)
    total = np.cumsum(counts.prod(axis=1))
    together = 500_000  # places in the boxes of triangles that are looked at together
    parts = np.searchsorted(total, np.arange(together, total[-1] if len(total) else 0, together))
    for part in np.split(np.arange(len(triangles)), np.unique(parts)):
        # Every place in the box of a triangle, one after another.
        sizes = counts[part].prod(axis=1)
        which = np.repeat(part, sizes)
        number = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        places = begin[which] + np.column_stack(np.divmod(number, counts[which, 1]))
        weights = barycentric(triangles[which, :, :2], low + pitch * places)
        inside = weights.min(axis=-1) >= -slack
        level = np.sum(weights * triangles[which, :, 2], axis=-1)[inside]
        np.maximum.at(heights, tuple(places[inside].T), level)

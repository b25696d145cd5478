"""Heights of a surface mesh over a plane: the upper side of an object, as a relief."""

from pathlib import Path

import numpy as np

from fefinger.geometry.locate import barycentric
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
    for triangle in corners:
        _raise(heights, x, y, triangle, pitch)
    if not np.isfinite(heights).all():
        share = float(np.isinf(heights).mean())
        raise InputError(
            f"indenter.file: expected a surface in {str(file)!r} that covers its box of "
            f"{' x '.join(f'{size:.3g}' for size in high - low)} mm as seen along z, received one "
            f"that leaves {100 * share:.0f} % of it open; cut it to a rectangle or put it on a "
            "plate, and check that it is in mm"
        )
    return x, y, heights


def _raise(heights: Array, x: Array, y: Array, triangle: Array, pitch: float) -> None:
    """Raise the heights under a triangle (3, 3) to it; a vertical one has no places under it."""
    across = triangle[1:, :2] - triangle[0, :2]
    if abs(np.linalg.det(across)) <= MARGIN * np.square(across).max(initial=0.0):
        return
    low, high = triangle[:, :2].min(axis=0), triangle[:, :2].max(axis=0)
    slack = 1e-6 * pitch
    part = tuple(
        slice(
            np.searchsorted(lines, low[k] - slack), np.searchsorted(lines, high[k] + slack, "right")
        )
        for k, lines in enumerate((x, y))
    )
    places = np.stack(np.meshgrid(x[part[0]], y[part[1]], indexing="ij"), axis=-1)
    if places.size == 0:
        return
    weights = barycentric(triangle[None, None, :, :2], places)
    inside = weights.min(axis=-1) >= -1e-6
    level = np.where(inside, weights @ triangle[:, 2], -np.inf)
    heights[part] = np.maximum(heights[part], level)

"""Triangulated halves of shells: closed input surfaces for the mesher."""

import numpy as np

from fefinger.mesh.shell import Shell
from fefinger.support.arrays import Array, Integers


Triangles = tuple[Array, Integers]
"""Vertices (n, 3) in mm and triangles (m, 3), oriented outward."""


def half(shell: Shell, step: float, *, overhang: float = 0.0) -> Triangles:
    """Return the closed half y >= 0 of a shell with facets of about `step` mm.

    It begins `overhang` mm behind the cut.

    Rings of constant x run to a pole at the tip; a strip of columns closes the medial plane and a
    fan closes the cut.
    """
    rings = _stations(shell, step, shell.cut - overhang)
    girth = np.pi / 2 * max(float(np.max(part)) for part in shell.heights(rings))
    count = 2 * max(int(np.ceil(girth / step)), 6) + 1
    angle = np.linspace(0.0, np.pi, count)
    wide, low, high = (part[:, None] for part in shell.heights(rings))
    z = shell.middle - np.cos(angle) * np.where(angle < np.pi / 2, low, high)
    y = wide * np.sin(angle)
    y[:, [0, -1]] = 0.0
    outer = np.stack(np.broadcast_arrays(rings[:, None], y, z), axis=-1).reshape(-1, 3)
    axis = np.column_stack([rings, 0.0 * rings, np.full(len(rings), shell.middle)])
    pole = np.array([[shell.tip, 0.0, shell.middle]])
    points = np.concatenate([outer, axis, pole])
    index = np.arange(len(outer)).reshape(len(rings), count)
    column = len(outer) + np.arange(len(rings))
    last = len(points) - 1
    faces = [
        _strip(index.T, closed_by=None),
        _fan(index[-1], last)[:, ::-1],
        _strip(np.stack([column, index[:, 0]]), closed_by=last),
        _strip(np.stack([index[:, -1], column]), closed_by=last),
        _fan(index[0], column[0]),
    ]
    return points, np.concatenate(faces)


def without_caps(part: Triangles) -> Triangles:
    """Return a half surface without its medial plane and cut."""
    points, faces = part
    corners = points[faces]
    caps = np.all(corners[:, :, 1] == 0.0, axis=1)
    caps |= np.all(corners[:, :, 0] == points[0, 0], axis=1)
    return points, faces[~caps]


def ribbon(rows: Array) -> Triangles:
    """Return the surface through neighboring rows of points, (rows, count, 3) mm."""
    index = np.arange(rows[..., 0].size).reshape(rows.shape[:2])
    return rows.reshape(-1, 3), _strip(index, closed_by=None)


def volume(surface: Triangles) -> float:
    """Return the volume inside a closed outward surface, mm^3 (divergence theorem)."""
    corners = surface[0][surface[1]]
    return float(np.linalg.det(corners).sum() / 6.0)


def _stations(shell: Shell, step: float, start: float) -> Array:
    """Return x of the rings from the cut to the last one before the pole, even along the palm."""
    fine = shell.tip - (shell.tip - start) * np.linspace(1.0, 0.0, 2000) ** 2
    wide, low, _ = shell.heights(fine)
    arc = [np.hypot(np.diff(fine), np.diff(part)).cumsum() for part in (wide, low)]
    travel = np.concatenate([[0.0], np.maximum(*arc)])
    count = max(int(np.ceil(travel[-1] / step)), 8)
    return np.interp(np.linspace(0.0, travel[-1], count + 1)[:-1], travel, fine)


def _strip(rows: Integers, *, closed_by: int | None) -> Integers:
    """Return triangles between neighboring rows of vertices, with an end vertex if given."""
    a, b, c, d = rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]
    quads = [np.stack([a, c, b], axis=-1), np.stack([a, d, c], axis=-1)]
    parts = [quad.reshape(-1, 3) for quad in quads]
    if closed_by is not None:
        end = np.full(len(rows) - 1, closed_by)
        parts.append(np.column_stack([rows[:-1, -1], rows[1:, -1], end]))
    return np.concatenate(parts)


def _fan(ring: Integers, center: int) -> Integers:
    """Return triangles between a ring of vertices and a center."""
    return np.column_stack([ring[:-1], np.full(len(ring) - 1, center), ring[1:]])

"""How the surface of a finger lies in its file: turned about which axis, and by how much.

A finger is about symmetric in its medial plane, however it was cut: the plane in which a surface is
nearest to its mirror image gives yaw and roll. In that plane a finger is thinnest across its axis,
which gives the pitch; its narrower end is the tip, and that is nearer to the nail than to the pad.

The limits come from the parametric fingers of the five subjects, of 1.1, 1.5 and 1.7 to 2 widths of
length, cut squarely and 20 degrees askew about y or z, without noise and with 0.1 mm of it at every
vertex (120 scans), and from copies turned about x, y and z by 10 to 180 degrees.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from fefinger.support.checks import InputError


Array = NDArray[np.float64]

COUNT = 6000
"""Points that stand for a surface, even in area, so that no density of vertices counts."""

EVERY = 6
"""One of so many of them is mirrored and looked for among all."""

KEPT = 0.8
"""Part of the mirrored points that counts, the nearest: not those of an oblique cut."""

DISTAL = 24.0
"""mm from the tip that are looked at: a longer scan may bend at its joints."""

STEP = 15.0
"""Degrees between the planes from which the medial one is looked for."""

CLEARLY = 0.7
"""Another plane than that near y = 0 is the medial one if the surface is so much nearer to its
image in it. In good scans the next plane leaves it 1.04 to 4 times as far as the medial one."""

NEAR, NEARER = 20.0, 0.9
"""Degrees beyond which the plane near y = 0 is another one anyhow, and what then is enough."""

STOUT = 0.9
"""Length over width that a finger has at least, in what may be its medial plane."""

ALIKE = 0.012
"""Mean distance from the mirror image, over the diagonal of the box, up to which another plane may
be the medial one; good scans come to 0.0105 in theirs."""

LOPSIDED = 0.02
"""The same, from which not even the plane near y = 0 is taken for the medial one."""

LYING = 0.2
"""Part by which a finger on its side has to be the nearer to its mirror image: an egg is none."""

TRIALS = 80
"""Evaluations by which a plane is brought to where the surface is nearest to its mirror image."""

OUTSIDE = 0.005
"""Part of the points at either end that an extent leaves out, against noise."""

SLENDER, SHORT_PITCH = 1.4, 30.0
"""Length over width from which the pitch counts; in shorter pieces only beyond so many degrees.
Good scans of 1.5 widths show up to 10 degrees, those of 1.1 widths up to 21, of 0.95 up to 26."""

WIDER = 1.05
"""Girth of an end over that of the other from which that is the tip: 0.67 to 0.93 in good scans."""

UPRIGHT, UNSURE = 0.42, 0.48
"""Least height of the tip over the thickness behind it, and below what it is worth a note. It is
0.55 to 0.77 in good scans that are slender, and 0.23 to 0.45 in those with their nail down."""

TIP = 0.03
"""Part of the length at the tip whose mean height counts, against noise."""

REFUSED = 25.0
"""Degrees by which a scan is turned for sure. Good ones come to 10 at most, and to 1.3 about x or z
alone; copies turned by 20 about x or z come to 20, about y to 15 to 22 (d.p. cut at 1.5 widths: 11,
as its pad slopes). No scan of a real finger is among them, so that up to here it is a note."""

NOTED = 11.0
"""Degrees from which it is worth a note."""


@dataclass(frozen=True)
class Lie:
    """How a finger lies in its file, as far as its shape tells.

    Attributes
    ----------
    axes : unit vectors (3, 3) in the file's frame, distal, radial and dorsal, as rows; near those
        of the file where the shape does not say which way is ahead or up.
    rise : height of the tip above the lowest point behind it, over the thickness there.
    slender : length over width.

    """

    axes: Array
    rise: float
    slender: float

    @property
    def turned(self) -> float:
        """Degrees by which the finger is turned out of the frame."""
        return float(np.degrees(np.arccos(np.clip((np.trace(self.axes) - 1.0) / 2.0, -1.0, 1.0))))

    @property
    def back(self) -> str:
        """What turns it into the frame: about one axis, or about z, y and x in this order."""
        from scipy.spatial.transform import Rotation

        back = Rotation.from_matrix(self.axes)
        turns = np.round(back.as_rotvec(degrees=True))
        order = "xyz"
        if np.sort(np.abs(turns))[1] > NOTED / 2.0:
            turns, order = np.round(back.as_euler("zyx", degrees=True)), "zyx"
        else:
            turns = np.where(np.abs(turns) == np.abs(turns).max(), turns, 0.0)
        steps = [
            f"{axis} by {turn:.0f} degrees" for axis, turn in zip(order, turns, strict=True) if turn
        ]
        return ", then about ".join(steps)


def check(mesh: Any, name: str) -> tuple[str, ...]:
    """Return notes on how the finger of a closed surface may be turned out of the frame.

    Raises InputError if it is turned for sure, with what turns it back.
    """
    found = lie(mesh)
    if found.turned >= REFUSED:
        message = (
            f"{name} is turned by {found.turned:.0f} degrees, as its plane of symmetry, its axis "
            "and its tip show; expected x distal, y radial and z dorsal: turn it about "
            f"{found.back}"
        )
        raise InputError(message)
    notes = []
    if found.turned >= NOTED:
        notes.append(
            f"{name} may be turned: to bring its symmetry and its axis into the frame x distal, y "
            f"radial and z dorsal, turn it about {found.back}."
        )
    if found.slender >= SLENDER and found.rise < UNSURE:
        notes.append(
            f"{name} has its tip at {found.rise:.0%} of its thickness above its lowest point: if "
            "its nail faces down (-z), turn it about x by 180 degrees."
        )
    return tuple(notes)


def lie(mesh: Any) -> Lie:
    """Return how the finger of a closed surface lies, in about half a second."""
    points = _distal(_sampled(mesh))
    radial = _medial_normal(points)
    axis, along = _axis(points, radial)
    slender = _slender(points, radial)
    # A short piece does not tell its axis: what follows has to hold with either.
    distal = axis if slender >= SLENDER or abs(_degrees(axis, along)) > SHORT_PITCH else along
    if _ahead(points, distal) > WIDER:
        distal, axis, along = -distal, -axis, -along
    dorsal = np.cross(distal, radial)
    if dorsal[2] < 0.0:
        radial, dorsal = -radial, -dorsal
    rise = max(_rise(points, each, np.cross(each, radial)) for each in (distal, axis))
    if rise < UPRIGHT:
        radial, dorsal, rise = -radial, -dorsal, 1.0 - rise
    return Lie(np.array([distal, radial, dorsal]), rise, slender)


def _sampled(mesh: Any) -> Array:
    """Return COUNT points of a surface, even in area, the same ones each time, (COUNT, 3) mm."""
    random = np.random.default_rng(0)
    corners = mesh.vertices[mesh.faces]
    sides = corners[:, 1:] - corners[:, :1]
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).cumsum()
    face = np.searchsorted(area, (np.arange(COUNT) + 0.5) / COUNT * area[-1])
    u, v = random.random((2, COUNT, 1))
    u = np.sqrt(u)
    return np.asarray(corners[face, 0] + u * ((1 - v) * sides[face, 0] + v * sides[face, 1]))


def _distal(points: Array) -> Array:
    """Return the points within DISTAL of the narrower end, if the surface is much longer."""
    axis = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    along = points @ axis
    if np.ptp(along) < 1.5 * DISTAL:
        return points
    low, high = along.min(), along.max()
    girth = [
        np.linalg.det(np.cov(points[np.abs(along - at) < 0.3 * DISTAL].T)) for at in (low, high)
    ]
    return points[along < low + DISTAL if girth[0] < girth[1] else along > high - DISTAL]


class Mirror:
    """How near points (n, 3) are to their mirror images in planes."""

    def __init__(self, points: Array) -> None:
        self._middle = points.mean(axis=0)
        self._tree = cKDTree(points)
        self._some = points[::EVERY] - self._middle

    def away(self, normal: Array, shift: float = 0.0) -> float:
        """Return the mean distance in mm of the nearest part of the points from their images."""
        height = self._some @ normal - shift
        images = self._some - 2.0 * height[:, None] * normal + self._middle
        distance = np.sort(self._tree.query(images)[0])
        return float(distance[: int(KEPT * len(distance))].mean())

    def nearest(self, start: Array) -> tuple[Array, float]:
        """Return the normal (3,) near a start where the distance is least, and the distance."""
        from scipy.optimize import minimize

        one, other = np.linalg.svd(start[None])[2][1:]

        def normal(found: Array) -> Array:
            turned = start + found[0] * one + found[1] * other
            return np.asarray(turned / np.linalg.norm(turned))

        simplex = np.array([[0, 0, 0], [0.15, 0, 0], [0, 0.15, 0], [0, 0, 0.5]], dtype=float)
        best = minimize(
            lambda found: self.away(normal(found), float(found[2])),
            simplex[0],
            method="Nelder-Mead",
            options={"initial_simplex": simplex, "maxfev": TRIALS, "xatol": 5e-3, "fatol": 1e-3},
        )
        return normal(best.x), float(best.fun)


def _medial_normal(points: Array) -> Array:
    """Return the unit normal (3,) of the medial plane."""
    mirror, radial = Mirror(points), np.array([0.0, 1.0, 0.0])
    near, away = mirror.nearest(radial)
    if _slender(points, near) < STOUT:
        away = np.inf
    best, least = _best(points, mirror)
    enough = CLEARLY if _degrees(near, radial) < NEAR else NEARER
    box = float(np.linalg.norm(np.ptp(points, axis=0)))
    found = radial if away > LOPSIDED * box else near
    if least < min(enough * away, ALIKE * box):
        found = best
    side = next(part for part in (found[1], found[2], found[0]) if abs(part) > 0.2)
    return np.asarray(np.sign(side) * found)


def _best(points: Array, mirror: Mirror) -> tuple[Array, float]:
    """Return the normal and distance of the plane that may be medial and mirrors the points best.

    The plane across a finger leaves it about as near, but wider than it is long.
    """
    starts = _starts()
    distances = np.array([mirror.away(start) for start in starts])
    distances *= 1.0 + LYING * np.abs(starts[:, 2])
    for _ in range(2):
        best, least = mirror.nearest(starts[int(np.argmin(distances))])
        if _slender(points, best) >= STOUT:
            return best, least
        distances[np.abs(starts @ best) > np.cos(np.radians(3.0 * STEP))] = np.inf
    return best, np.inf


def _starts() -> Array:
    """Return normals (n, 3) of planes, STEP apart, one of each opposite pair."""
    polar = np.radians(np.arange(0.0, 90.0 + STEP / 2, STEP))
    found = []
    for angle in polar:
        count = max(round(360.0 / STEP * float(np.sin(angle))), 1)
        turn = 2.0 * np.pi * np.arange(count) / count
        x, z = np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn)
        found.append(np.column_stack([x, np.full(count, np.cos(angle)), z]))
    return np.concatenate(found)


def _axis(points: Array, normal: Array) -> tuple[Array, Array]:
    """Return the direction (3,) of a finger in its medial plane, and the file's one nearest to it.

    It is thinnest across its axis; where that and the longest principal axis differ, as they do for
    a short piece or an oblique cut, the nearer to the file's is taken, or that if it is between.
    """
    file = np.array([1.0, 0.0, 0.0])
    if _degrees(normal, file) < 30.0:
        file = np.array([0.0, 1.0, 0.0])
    along = file - normal @ file * normal
    along /= np.linalg.norm(along)
    up = np.cross(along, normal)
    plane = np.column_stack([points @ along, points @ up])
    turns = np.radians(np.arange(-89.0, 91.0))
    heights = plane @ np.stack([-np.sin(turns), np.cos(turns)])
    first = float(turns[int(np.argmin(_extent(heights)))])
    x, z = np.linalg.eigh(np.cov(plane.T))[1][:, 1]
    second = float(np.arctan2(np.sign(x) * z, np.abs(x)))
    if abs(first - second) > np.pi / 2.0:
        second += np.sign(first - second) * np.pi
    pitch = min(first, second, key=abs) if first * second > 0.0 else 0.0
    return np.asarray(np.cos(pitch) * along + np.sin(pitch) * up), along


def _slender(points: Array, normal: Array) -> float:
    """Return the length of a finger with this medial plane over its width."""
    axis, _ = _axis(points, normal)
    return float(_extent(points @ axis) / _extent(points @ normal))


def _ahead(points: Array, distal: Array) -> float:
    """Return the girth of the distal third of a finger over that of the proximal one."""
    along = points @ distal
    first, last = np.quantile(along, [OUTSIDE, 1.0 - OUTSIDE])
    third = (last - first) / 3.0
    across = points - along[:, None] * distal
    ends = (across[along < first + third], across[along > last - third])
    behind, ahead = (float(np.sqrt(np.trace(np.cov(end.T)))) for end in ends)
    return ahead / behind


def _rise(points: Array, distal: Array, dorsal: Array) -> float:
    """Return the height of the tip above the lowest point behind it, over the thickness there."""
    along, up = points @ distal, points @ dorsal
    front = float(along.max())
    low, high = np.quantile(up[along > front - _extent(up)], [OUTSIDE, 1.0 - OUTSIDE])
    tip = up[along > front - TIP * _extent(along)].mean()
    return float((tip - low) / (high - low))


def _extent(heights: Array) -> Any:
    """Return how far heights (n, ...) reach, without the outermost."""
    low, high = np.quantile(heights, [OUTSIDE, 1.0 - OUTSIDE], axis=0)
    return high - low


def _degrees(one: Array, other: Array) -> float:
    """Return the angle between two lines."""
    return float(np.degrees(np.arccos(min(abs(float(one @ other)), 1.0))))

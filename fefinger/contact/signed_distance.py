"""Signed distances of rigid objects, compiled: negative inside, with the outward unit gradient.

Every object has a frame of its own, with its center at the origin and its axis, if any, along z.
The distance of an ellipsoid is to first order; its surface and its normals are exact.
"""

from typing import NamedTuple

import numpy as np

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


SPHERE, BOX, CAPSULE, CYLINDER, ELLIPSOID, PLANE, SAMPLED = range(7)
"""Kinds of object; the numbers are indices of `KINDS`."""

CLOSE = 1e-4  # mm of the surface from which one more step of Newton's method is exact to 1e-9
STEEP = 0.3  # cosine between ray and normal from which Newton's method is safe
GRAZING = 0.1  # least cosine between ray and normal of a hit: skin that faces the object
STEPS = 48  # along a ray


class One(NamedTuple):
    """One of several objects, in numbers alone: compiled code passes them on at no cost.

    Its kind; the four numbers of its size; of sampled distances: index of its first sample, counts
    along x, y and z, first point and pitch.
    """

    kind: int
    p: float
    q: float
    r: float
    edge: float
    start: int
    nx: int
    ny: int
    nz: int
    x: float
    y: float
    z: float
    pitch: float


Ray = tuple[float, float, float, float, float, float]
"""A point and a direction, in the frame of an object."""


class Shapes(NamedTuple):
    """Several objects, in mm.

    kind (b,); size (b, 4): radius; half sides and radius of the edges; radius and half length;
    radius, half length and radius of the edges; semi-axes; none. Of sampled distances: samples
    (n,), one grid after the other, start (b,) of each, counts (b, 3) along x, y and z, low (b, 3)
    mm of its first point, pitch (b,) mm.
    """

    kind: Integers
    size: Array
    samples: Array
    start: Integers
    counts: Integers
    low: Array
    pitch: Array


@njit(cache=True)
def _box(x: float, y: float, z: float, a: float, b: float, c: float) -> tuple[float, ...]:
    qx, qy, qz = abs(x) - a, abs(y) - b, abs(z) - c
    sx, sy, sz = np.copysign(1.0, x), np.copysign(1.0, y), np.copysign(1.0, z)
    mx, my, mz = max(qx, 0.0), max(qy, 0.0), max(qz, 0.0)
    outside = np.sqrt(mx * mx + my * my + mz * mz)
    if outside > 0.0:
        return outside, sx * mx / outside, sy * my / outside, sz * mz / outside
    if qx >= qy and qx >= qz:
        return qx, sx, 0.0, 0.0
    if qy >= qz:
        return qy, 0.0, sy, 0.0
    return qz, 0.0, 0.0, sz


@njit(cache=True)
def _ball(x: float, y: float, z: float, radius: float) -> tuple[float, ...]:
    far = np.sqrt(x * x + y * y + z * z)
    if far == 0.0:
        return -radius, 0.0, 0.0, 1.0
    return far - radius, x / far, y / far, z / far


@njit(cache=True)
def _cylinder(x: float, y: float, z: float, radius: float, half: float) -> tuple[float, ...]:
    """Distance of a cylinder, as of a rectangle in the plane of the axis."""
    r = np.sqrt(x * x + y * y)
    ux, uy = (x / r, y / r) if r > 0.0 else (1.0, 0.0)
    d, gr, _, gz = _box(r, 0.0, z, radius, np.inf, half)
    return d, ux * gr, uy * gr, gz


@njit(cache=True)
def _ellipsoid(x: float, y: float, z: float, a: float, b: float, c: float) -> tuple[float, ...]:
    u, v, w = x / (a * a), y / (b * b), z / (c * c)
    level, steep = np.sqrt(x * u + y * v + z * w), np.sqrt(u * u + v * v + w * w)
    if steep == 0.0:
        return -min(a, b, c), 0.0, 0.0, 1.0
    return level * (level - 1.0) / steep, u / steep, v / steep, w / steep


@njit(cache=True)
def one_of(s: Shapes, b: int) -> One:
    """Return object `b` of several."""
    return One(
        s.kind[b],
        *(s.size[b, 0], s.size[b, 1], s.size[b, 2], s.size[b, 3]),
        *(s.start[b], s.counts[b, 0], s.counts[b, 1], s.counts[b, 2]),
        *(s.low[b, 0], s.low[b, 1], s.low[b, 2], s.pitch[b]),
    )


@njit(cache=True)
def _sampled(samples: Array, one: One, x: float, y: float, z: float) -> tuple[float, ...]:
    """Distance from a grid, trilinear; beyond it the one at its border plus the way there."""
    pitch, nx, ny, nz = one.pitch, one.nx, one.ny, one.nz
    fx, fy, fz = (x - one.x) / pitch, (y - one.y) / pitch, (z - one.z) / pitch
    cx, cy, cz = (
        min(max(fx, 0.0), nx - 1.0),
        min(max(fy, 0.0), ny - 1.0),
        min(max(fz, 0.0), nz - 1.0),
    )
    i, j, k = min(int(cx), nx - 2), min(int(cy), ny - 2), min(int(cz), nz - 2)
    u, v, w = cx - i, cy - j, cz - k
    at = one.start + (i * ny + j) * nz + k
    d = gx = gy = gz = 0.0
    for p in range(2):
        wx, tx = (u, 1.0) if p else (1.0 - u, -1.0)
        for q in range(2):
            wy, ty = (v, 1.0) if q else (1.0 - v, -1.0)
            for r in range(2):
                wz, tz = (w, 1.0) if r else (1.0 - w, -1.0)
                value = samples[at + (p * ny + q) * nz + r]
                d += wx * wy * wz * value
                gx += tx * wy * wz * value
                gy += wx * ty * wz * value
                gz += wx * wy * tz * value
    length = np.sqrt(gx * gx + gy * gy + gz * gz)
    if length < 1e-12 * pitch:
        gx, gy, gz, length = 0.0, 0.0, 1.0, 1.0
    ox, oy, oz = (fx - cx) * pitch, (fy - cy) * pitch, (fz - cz) * pitch
    return d + np.sqrt(ox * ox + oy * oy + oz * oz), gx / length, gy / length, gz / length


@njit(cache=True)
def distance(samples: Array, one: One, x: float, y: float, z: float) -> tuple[float, ...]:
    """Return the distance in mm of a point from an object, in its frame, and its gradient (3).

    samples (n,): of all objects.
    """
    kind, p, q, r, edge = one.kind, one.p, one.q, one.r, one.edge
    if kind == SAMPLED:
        return _sampled(samples, one, x, y, z)
    if kind == SPHERE:
        return _ball(x, y, z, p)
    if kind == PLANE:
        return z, 0.0, 0.0, 1.0
    if kind == BOX:
        d, gx, gy, gz = _box(x, y, z, p - edge, q - edge, r - edge)
        return d - edge, gx, gy, gz
    if kind == CAPSULE:
        return _ball(x, y, z - min(max(z, -q), q), p)
    if kind == CYLINDER:
        d, gx, gy, gz = _cylinder(x, y, z, p - r, q - r)
        return d - r, gx, gy, gz
    return _ellipsoid(x, y, z, p, q, r)


@njit(cache=True)
def distances(s: Shapes, b: int, points: Array) -> Array:
    """Return the distances in mm of points (n, 3) from object `b`, and their gradients: (n, 4)."""
    found, one = np.empty((len(points), 4)), one_of(s, b)
    for j in range(len(points)):
        x, y, z = points[j, 0], points[j, 1], points[j, 2]
        far, gx, gy, gz = distance(s.samples, one, x, y, z)
        found[j, 0], found[j, 1], found[j, 2], found[j, 3] = far, gx, gy, gz
    return found


@njit(cache=True)
def _straight(
    kind: int,
    radius: float,
    x: float,
    y: float,
    z: float,
    u: float,
    v: float,
    w: float,
    reach: float,
) -> tuple[bool, float, float, float, float]:
    """Follow a ray to a sphere or a plane, as `_followed`, in closed form."""
    if kind == PLANE:
        far = -z / w if w < 0.0 else np.inf
        return far <= reach, far, 0.0, 0.0, 1.0
    along, outside = x * u + y * v + z * w, x * x + y * y + z * z - radius * radius
    square = along * along - outside
    if square < 0.0 or (along > 0.0 and outside > 0.0):
        return False, reach, 0.0, 0.0, 0.0
    far = -along - np.sqrt(square)
    return far <= reach, far, (x + far * u) / radius, (y + far * v) / radius, (z + far * w) / radius


@njit(cache=True)
def _followed(
    samples: Array,
    one: One,
    x: float,
    y: float,
    z: float,
    u: float,
    v: float,
    w: float,
    reach: float,
) -> tuple[bool, float, float, float, float]:
    """Follow a ray from (x, y, z) along (u, v, w), in the frame of an object.

    Returns whether it comes to the surface within `reach` mm, after how many mm, and the gradient
    of the distance there.
    """
    far = 0.0
    for _ in range(STEPS):
        d, gx, gy, gz = distance(samples, one, x + far * u, y + far * v, z + far * w)
        slope = gx * u + gy * v + gz * w
        # Where the ray grazes, a step of the distance itself stays on this side of the surface.
        far += d / -slope if slope < -STEEP else d
        if abs(d) < CLOSE:
            return True, far, gx, gy, gz
        if far > reach:
            break
    return False, reach, 0.0, 0.0, 0.0


@njit(cache=True)
def rays(
    s: Shapes,
    b: int,
    rotation: Array,
    place: Array,
    points: Array,
    normals: Array,
    reach: float,
    found: Array,
) -> None:
    """Follow the outward normals of the skin from its points (k, 3) to object `b`.

    rotation (b, 3, 3) and place (b, 3) mm of the objects: x = rotation x' + place. Sets found (k,
    4) to the distance in mm of a surface of the object that faces the skin, negative inside the
    object, and to the object's outward normal there; to infinity where none is within `reach` mm.
    """
    one, turn, center = one_of(s, b), rotation[b], place[b]
    for k in range(len(points)):
        ray = _turned(turn, center, points[k], normals[k])
        if one.kind in (SPHERE, PLANE):
            seen = _straight(one.kind, one.p, *ray, reach)
        else:
            seen = _followed(s.samples, one, *ray, reach)
        _keep(found[k], turn, ray, seen)


@njit(cache=True)
def _turned(turn: Array, center: Array, point: Array, normal: Array) -> Ray:
    """Return a point and a direction, (3,) each, in the frame of an object."""
    dx, dy, dz = point[0] - center[0], point[1] - center[1], point[2] - center[2]
    u, v, w = normal[0], normal[1], normal[2]
    return (
        turn[0, 0] * dx + turn[1, 0] * dy + turn[2, 0] * dz,
        turn[0, 1] * dx + turn[1, 1] * dy + turn[2, 1] * dz,
        turn[0, 2] * dx + turn[1, 2] * dy + turn[2, 2] * dz,
        turn[0, 0] * u + turn[1, 0] * v + turn[2, 0] * w,
        turn[0, 1] * u + turn[1, 1] * v + turn[2, 1] * w,
        turn[0, 2] * u + turn[1, 2] * v + turn[2, 2] * w,
    )


@njit(cache=True)
def _keep(
    found: Array,
    turn: Array,
    ray: Ray,
    seen: tuple[bool, float, float, float, float],
) -> None:
    """Write what a ray met, in the frame of the skin, if it faces the skin."""
    hit, far, x, y, z = seen
    found[0] = np.inf
    if hit and x * ray[3] + y * ray[4] + z * ray[5] <= -GRAZING:
        found[0] = far
        for c in range(3):
            found[1 + c] = turn[c, 0] * x + turn[c, 1] * y + turn[c, 2] * z

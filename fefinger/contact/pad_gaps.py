"""Where objects at any pose are near the skin of a pad, and how far they penetrate it.

A ray along the normal of the skin finds the nearest object; gap and pressure are along the object's
normal at the hit. F = d . A . d of the near vertices is the flexibility in these directions.
"""

import numpy as np

from fefinger.contact.pad_worlds import Factors, Pad, Work
from fefinger.contact.signed_distance import Shapes, distance, one_of, rays
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.compiled import njit


WIDER, FULLER = 0.13, 1.8
"""Slopes of the exponent of t, by which it departs from a plate's: with the logarithm of the patch
over that under the plate, and with the difference in fullness (see `penetration`).

Least squares over 28 presses of a.h. (`validation/evidence/tactile.py`, those without `at`) at .5
to 1.5 mm: a ball on the proximal pad stiffens less than a plate there, a pin more.
"""


@njit(cache=True)
def nearest(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    touched: Integers,
    d: Array,
    m: Work,
    near: float,
) -> None:
    """Find the nearest object of every vertex.

    d (n, 3): the object's outward normal, which is the direction of the pressure.
    """
    m.ahead[:] = near
    touched[:] = -1
    found = np.empty((len(m.gap), 4))
    for b in range(len(shapes.kind)):
        rays(shapes, b, rotation, place, pad.points, pad.normals, near, found)
        for j in range(len(found)):
            if found[j, 0] < m.ahead[j]:
                m.ahead[j], touched[j] = found[j, 0], b
                d[j, 0], d[j, 1], d[j, 2] = found[j, 1], found[j, 2], found[j, 3]
    m.found[0] = 0
    for j in range(len(m.gap)):
        m.near[j] = touched[j] >= 0
        if m.near[j]:
            m.listed[m.found[0]] = j
            m.found[0] += 1


@njit(cache=True)
def gaps(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    touched: Integers,
    hit: Array,
    m: Work,
    near: float,
) -> None:
    """Weight the gaps (n,) along the objects' normals, and the places of contact, by the hats."""
    m.gap[:] = 0.0
    hit[:] = 0.0
    found = np.empty((pad.places.shape[1], 4))
    for k in range(len(pad.owner)):
        for c in range(3):
            j = pad.owner[k, c]
            if j < 0 or touched[j] < 0:
                continue
            b = touched[j]
            for other in range(c):  # of the same object: done with that corner
                i = pad.owner[k, other]
                if i >= 0 and touched[i] == b:
                    b = -1
                    break
            if b >= 0:
                rays(shapes, b, rotation, place, pad.places[k], pad.skin[k], near, found)
                _triangle(pad, touched, found, hit, m, near, k, c, b)


@njit(cache=True)
def _triangle(
    pad: Pad,
    touched: Integers,
    found: Array,
    hit: Array,
    m: Work,
    near: float,
    k: int,
    first: int,
    b: int,
) -> None:
    """Add the gaps of triangle `k` to object `b`, which its corners from `first` on touch."""
    places, skin = pad.places[k], pad.skin[k]
    for c in range(first, 3):
        j = pad.owner[k, c]
        if j < 0 or touched[j] != b:
            continue
        hats = pad.hats[k, c]
        gap = x = y = z = 0.0
        for q in range(len(found)):
            far, n, weight = found[q, 0], skin[q], hats[q]
            if far <= near:
                along = found[q, 1] * n[0] + found[q, 2] * n[1] + found[q, 3] * n[2]
                gap -= weight * far * along
            else:
                far = 0.0
                gap += weight * near
            x += weight * (places[q, 0] + far * n[0])
            y += weight * (places[q, 1] + far * n[1])
            z += weight * (places[q, 2] + far * n[2])
        m.gap[j] += gap
        hit[j, 0] += x
        hit[j, 1] += y
        hit[j, 2] += z


@njit(cache=True, fastmath={"contract", "reassoc"})
def moved(compliance: Floats, traction: Array, near: Integers, out: Array) -> None:
    """Compute A t at near vertices; t (3n,) is zero at most others.

    compliance A (3n, 3n) mm³/kPa of the relaxed body, for the components x, y, z of each vertex in
    turn.
    """
    n = len(traction) // 3
    loaded, k = np.empty(n, dtype=np.int64), 0
    for j in range(n):
        if traction[3 * j] != 0.0 or traction[3 * j + 1] != 0.0 or traction[3 * j + 2] != 0.0:
            loaded[k] = 3 * j
            k += 1
    for i in near:
        p, q, r = compliance[3 * i], compliance[3 * i + 1], compliance[3 * i + 2]
        a = b = c = 0.0
        for e in range(k):
            j = loaded[e]
            x, y, z = traction[j], traction[j + 1], traction[j + 2]
            a += p[j] * x + p[j + 1] * y + p[j + 2] * z
            b += q[j] * x + q[j + 1] * y + q[j + 2] * z
            c += r[j] * x + r[j + 1] * y + r[j + 2] * z
        out[3 * i], out[3 * i + 1], out[3 * i + 2] = a, b, c


@njit(cache=True)
def frames(frame: Array, m: Work) -> None:
    """Complete the directions of pressure to frames.

    Duff et al., J. Comput. Graph. Tech. 6:1, 2017.
    """
    for a in range(m.found[0]):
        j = m.listed[a]
        x, y, z = frame[0, j, 0], frame[0, j, 1], frame[0, j, 2]
        sign = np.copysign(1.0, z)
        p = -1.0 / (sign + z)
        q = x * y * p
        frame[1, j, 0], frame[1, j, 1], frame[1, j, 2] = 1.0 + sign * x * x * p, sign * q, -sign * x
        frame[2, j, 0], frame[2, j, 1], frame[2, j, 2] = q, sign + y * y * p, -y


@njit(cache=True, fastmath={"contract"})
def project(flexibility: Array, compliance: Floats, direction: Array, m: Work) -> None:
    """Set the rows and columns of near vertices to F = d . A . d, d (n, 3) the directions."""
    for j in range(len(m.gap)):  # what is near no more takes no part
        if not m.near[j] and flexibility[j, j] != 0.0:
            flexibility[j] = 0.0
            flexibility[:, j] = 0.0
    for p in range(m.found[0]):
        i = m.listed[p]
        r0, r1, r2 = compliance[3 * i], compliance[3 * i + 1], compliance[3 * i + 2]
        x, y, z = direction[i, 0], direction[i, 1], direction[i, 2]
        for q in range(p + 1):
            j = m.listed[q]
            k = 3 * j
            value = (
                (x * r0[k] + y * r1[k] + z * r2[k]) * direction[j, 0]
                + (x * r0[k + 1] + y * r1[k + 1] + z * r2[k + 1]) * direction[j, 1]
                + (x * r0[k + 2] + y * r1[k + 2] + z * r2[k + 2]) * direction[j, 2]
            )
            flexibility[i, j] = value
            flexibility[j, i] = value


@njit(cache=True)
def jumped(
    pad: Pad,
    shapes: Shapes,
    rotation: Array,
    place: Array,
    turned: Array,
    was: Array,
    deepest: float,
) -> bool:
    """Whether an object was deeper than `deepest` mm in the skin on its way here.

    rotation (b, 3, 3) and place (b, 3) mm of the objects, turned and was those before. On the way
    the center moves straight on while the object turns about it, by less than half a turn.
    """
    axis = np.empty(3)
    for b in range(len(shapes.kind)):
        angle, path, arm = _turn(turned[b], rotation[b], axis), 0.0, 0.0
        for c in range(3):
            path += (place[b, c] - was[b, c]) ** 2
        for j in range(len(pad.areas)):  # arm: to the farthest skin
            x, y = pad.points[j, 0] - place[b, 0], pad.points[j, 1] - place[b, 1]
            z = pad.points[j, 2] - place[b, 2]
            arm = max(arm, x * x + y * y + z * z)
        parts = int(2.0 * (np.sqrt(path) + angle * np.sqrt(arm)) / deepest)
        for k in range(1, parts):
            if _pierced(
                pad, shapes, b, turned[b], was[b], place[b], axis, angle, k / parts, deepest
            ):
                return True
    return False


@njit(cache=True)
def _pierced(
    pad: Pad,
    shapes: Shapes,
    b: int,
    turned: Array,
    was: Array,
    place: Array,
    axis: Array,
    angle: float,
    part: float,
    deepest: float,
) -> bool:
    """Whether object `b` is deeper than `deepest` mm in the skin after a part of its way."""
    sine, cosine = np.sin(part * angle), np.cos(part * angle)
    x, y, z = axis
    local, one = np.empty(3), one_of(shapes, b)
    for j in range(len(pad.areas)):
        u = pad.points[j, 0] - was[0] - part * (place[0] - was[0])
        v = pad.points[j, 1] - was[1] - part * (place[1] - was[1])
        w = pad.points[j, 2] - was[2] - part * (place[2] - was[2])
        along = (1.0 - cosine) * (x * u + y * v + z * w)
        # Back about the axis (Rodrigues), then to the frame of the object before.
        p = cosine * u - sine * (y * w - z * v) + along * x
        q = cosine * v - sine * (z * u - x * w) + along * y
        r = cosine * w - sine * (x * v - y * u) + along * z
        for c in range(3):
            local[c] = turned[0, c] * p + turned[1, c] * q + turned[2, c] * r
        if distance(shapes.samples, one, local[0], local[1], local[2])[0] < -deepest:
            return True
    return False


@njit(cache=True)
def _turn(before: Array, now: Array, axis: Array) -> float:
    """Set the axis (3,) of the turn between two rotations (3, 3); return its angle, 0 to pi.

    In loops: products of arrays and their copies take seconds to compile.
    """
    q = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                q[i, j] += now[i, k] * before[j, k]
    square = 0.0
    for c in range(3):
        d, e = (c + 1) % 3, (c + 2) % 3
        axis[c] = 0.5 * (q[e, d] - q[d, e])
        square += axis[c] * axis[c]
    sine, cosine = np.sqrt(square), 0.5 * (q[0, 0] + q[1, 1] + q[2, 2] - 1.0)
    if sine == 0.0 and cosine > 0.0:
        axis[0], axis[1], axis[2] = 0.0, 0.0, 1.0
        return 0.0
    if cosine < 0.0:  # near half a turn the sine says little: (1 - cosine) a a' does
        k, toward = 0, 0.0
        for c in range(1, 3):
            k = c if q[c, c] > q[k, k] else k
        column = np.empty(3)
        for c in range(3):
            column[c] = 0.5 * (q[c, k] + q[k, c]) - (cosine if c == k else 0.0)
            toward += column[c] * axis[c]
        square = 0.0
        for c in range(3):
            axis[c] = -column[c] if toward < 0.0 else column[c]
            square += axis[c] * axis[c]
    for c in range(3):
        axis[c] /= np.sqrt(square)
    return np.arctan2(sine, cosine)


@njit(cache=True)
def _between(value: float, grid: Array) -> tuple[int, float]:
    """Return the interval of a grid that holds a value, and where in it from 0 to 1.

    Beyond the grid they are its nearest end.
    """
    k = 0
    while k < len(grid) - 2 and value > grid[k + 1]:
        k += 1
    return k, min(max((value - grid[k]) / (grid[k + 1] - grid[k]), 0.0), 1.0)


@njit(cache=True)
def penetration(pad: Pad, direction: Array, m: Work) -> tuple[float, float, float, float]:
    """Describe how objects penetrate the undeformed skin, by numbers that are continuous.

    Returns the deepest penetration in mm, the mean angle of the objects' normals in degrees, the
    patch in mm² and the fullness: first moment squared over the second of the penetration over the
    skin, and second over first over the deepest one. A flat punch has a fullness of 1, a smooth
    object 2 / 3. Without penetration the patch is 0.
    """
    deepest = x = z = first = second = 0.0
    for a in range(m.found[0]):
        j = m.listed[a]
        into = max(-m.ahead[j], 0.0)
        part = into * pad.areas[j]
        deepest = max(deepest, into)
        first += part
        second += into * part
        x += part * direction[j, 0]
        z += part * direction[j, 2]
    if first == 0.0:
        return 0.0, 0.0, 0.0, 0.0
    angle = np.degrees(np.arctan2(-x, z))
    return deepest, angle, first * first / second, second / (first * deepest)


@njit(cache=True)
def stiffening(f: Factors, pad: Pad, direction: Array, m: Work) -> float:
    """Return the factor t on the elastic traction, a power of that under a plate.

    The plate has the angle and the depth of what penetrates the skin.
    """
    deepest, angle, patch, fullness = penetration(pad, direction, m)
    if patch == 0.0:
        return 1.0
    k, part = _between(deepest, f.depths)
    i, share = _between(angle, f.angles)
    plate = np.zeros(3)
    for c in range(3):
        low = f.values[i, k, c] + part * (f.values[i, k + 1, c] - f.values[i, k, c])
        high = f.values[i + 1, k, c] + part * (f.values[i + 1, k + 1, c] - f.values[i + 1, k, c])
        plate[c] = low + share * (high - low)
    power = 1.0 + WIDER * (np.log(patch) - plate[1]) + FULLER * (fullness - plate[2])
    return np.exp(power * plate[0])

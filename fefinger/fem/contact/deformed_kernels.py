"""Compiled sums over the facets of a deformed pad: loads of weighted gaps, and deformed area."""

import numpy as np
from numpy.typing import NDArray

from fefinger.support.arrays import Array, Integers
from fefinger.support.compiled import njit


Indices = NDArray[np.int32]


@njit(cache=True)
def add_loads(
    hats: Array,
    quadratic: Array,
    gradient: Array,
    slope: Array,
    bent: Array,
    spread: Array,
    spreading: Array,
    mean: Array,
    steepness: Array,
    owner: Integers,
    slots: Indices,
    data: Array,
) -> None:
    """Add the loads of all facets to `data`, at the slots (n_tri, 3, 6, 3) of their nodes.

    mean (n,) mm: the gaps of the candidates per deformed
    area.
    """
    n_points = hats.shape[2]
    by_gap, by_area = np.empty(n_points), np.empty(n_points)
    for t in range(len(hats)):
        for j in range(3):
            candidate = owner[t, j]
            if candidate < 0:
                continue
            for q in range(n_points):
                hat = hats[t, j, q] / steepness[candidate]
                by_gap[q] = hat * slope[t, q] * spread[t, q]
                by_area[q] = hat * (bent[t, q] - mean[candidate] * slope[t, q])
            for k in range(6):
                for c in range(3):
                    load = 0.0
                    for q in range(n_points):
                        load += by_gap[q] * quadratic[k, q] * gradient[t, q, c]
                        load += by_area[q] * spreading[t, k, q, c]
                    data[slots[t, j, k, c]] += load


@njit(cache=True)
def fill_spread(
    values: Array, rows: Integers, sides: Array, slopes: Array, spread: Array, spreading: Array
) -> None:
    """Fill deformed over undeformed area J (n_tri, n_q) and its derivative (n_tri, 6, n_q, 3)."""
    first, second, normal = np.empty((3, 3))
    for t in range(len(rows)):
        _cross(sides[t, 0], sides[t, 1], normal)
        at_rest = np.sqrt(np.sum(normal**2))
        for q in range(spread.shape[1]):
            for c in range(3):
                first[c], second[c] = sides[t, 0, c], sides[t, 1, c]
                for k in range(6):
                    first[c] += slopes[0, k, q] * values[rows[t, k, c]]
                    second[c] += slopes[1, k, q] * values[rows[t, k, c]]
            _cross(first, second, normal)
            length = np.sqrt(np.sum(normal**2))
            spread[t, q] = length / at_rest
            normal /= max(length, np.finfo(np.float64).tiny) * at_rest
            for k in range(6):
                # d|a x b| = (b x n) . da + (n x a) . db, with the unit normal n.
                for c in range(3):
                    i, j = (c + 1) % 3, (c + 2) % 3
                    spreading[t, k, q, c] = slopes[0, k, q] * (
                        second[i] * normal[j] - second[j] * normal[i]
                    ) + slopes[1, k, q] * (normal[i] * first[j] - normal[j] * first[i])


@njit(cache=True)
def _cross(a: Array, b: Array, out: Array) -> None:
    for c in range(3):
        i, j = (c + 1) % 3, (c + 2) % 3
        out[c] = a[i] * b[j] - a[j] * b[i]

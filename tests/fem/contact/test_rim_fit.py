"""The fits of the gap by the rim of a contact, against numpy's least squares."""

import numpy as np
import pytest

from fefinger.fem.contact.contact_area import FIRST, REACH, fit_rims
from fefinger.fem.contact.obstacle import FAR


def drawn(count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return offsets (count, 2) of neighbors, nearest first, which are pressed, and gaps."""
    rng = np.random.default_rng(seed)
    offset = rng.uniform(-2.4, 2.4, (count, 2))
    offset = offset[np.argsort(np.linalg.norm(offset, axis=1))]
    phi = 0.1 + offset @ [0.5, 0.2] + 0.05 * offset[:, 1] ** 2 + rng.normal(0, 0.01, count)
    pressed = phi < 0
    return offset, pressed, np.where(pressed, 1e-4, np.abs(phi) ** 1.5)


def fitted(offset: np.ndarray, pressed: np.ndarray, gap: np.ndarray) -> tuple[float, float, bool]:
    """Apply `fit_rims` to one vertex."""
    found, known = np.empty((1, 1, 2)), np.empty((1, 1), dtype=bool)
    near = np.arange(len(gap))[None]
    fit_rims(near, offset[None], pressed, gap[None], found, known)
    return float(found[0, 0, 0]), float(found[0, 0, 1]), bool(known[0, 0])


def expected(offset: np.ndarray, gap: np.ndarray, used: np.ndarray) -> tuple[float, float]:
    """Return c0 and 2 c3 / c1 of the points that are used, by numpy."""
    x, phi = offset[used], gap[used] ** (2 / 3)
    one, root = np.ones(len(phi)), phi / phi.max()
    plane = np.linalg.lstsq(root[:, None] * np.column_stack([one, x]), root * phi, rcond=None)[0]
    s = plane[1:] / np.linalg.norm(plane[1:])
    t = np.array([-s[1], s[0]])
    basis = np.column_stack([one, x @ s, x @ t, (x @ t) ** 2])
    fit = np.linalg.lstsq(root[:, None] * basis, root * phi, rcond=None)[0]
    return fit[0], 2 * fit[3] / fit[1]


@pytest.mark.parametrize("seed", range(5))
def test_they_are_the_least_squares_of_the_open_gaps_in_reach(seed: int) -> None:
    offset, pressed, gap = drawn(40, seed)
    used = ~pressed & (gap > 1e-4) & (np.linalg.norm(offset, axis=1) < REACH)
    level, bend, known = fitted(offset, pressed, gap)
    assert known
    assert (level, bend) == pytest.approx(expected(offset, gap, used), rel=1e-5, abs=1e-7)


def test_with_few_in_reach_the_nearest_ones_are_taken() -> None:
    offset, pressed, gap = drawn(40, 0)
    far = 3 * offset
    nearest = np.flatnonzero(~pressed & (gap > 1e-4))[:FIRST]
    assert (np.linalg.norm(far[nearest], axis=1) < REACH).sum() < 5
    used = np.isin(np.arange(40), nearest)
    level, bend, known = fitted(far, pressed, gap)
    assert known
    assert (level, bend) == pytest.approx(expected(far, gap, used), rel=1e-4)


def test_of_too_few_open_gaps_nothing_is_known() -> None:
    offset, pressed, gap = drawn(40, 0)
    hidden = np.where(np.cumsum(~pressed) > 4, FAR, gap)
    assert fitted(offset, pressed, hidden) == (pytest.approx(0.0, abs=1.0), 0.0, False)
    assert fitted(offset, np.ones(40, dtype=bool), gap) == (0.0, 0.0, False)

"""How objects penetrate the undeformed skin: patch, fullness and angle, against closed forms."""

import numpy as np
import pytest

from fefinger.contact import pad_worlds
from fefinger.contact.pad_gaps import penetration
from fefinger.contact.pad_worlds import Pad, Work


SIDE, PITCH = 30, 0.4


def flat_pad() -> Pad:
    """Return vertices of a flat skin on a square grid, without compliance."""
    at = PITCH * (np.arange(SIDE) - (SIDE - 1) / 2)
    points = np.stack([*np.meshgrid(at, at, indexing="ij"), np.zeros((SIDE, SIDE))], axis=-1)
    n = SIDE * SIDE
    return Pad(
        points=points.reshape(n, 3),
        normals=np.tile([0.0, 0.0, -1.0], (n, 1)),
        owner=np.zeros((0, 3), dtype=np.int64),
        places=np.zeros((0, 1, 3)),
        skin=np.zeros((0, 1, 3)),
        hats=np.zeros((0, 3, 1)),
        areas=np.full(n, PITCH**2),
        border=np.zeros(n, dtype=bool),
        weights=np.zeros(0),
        rates=np.zeros(0),
    )


def penetrated(pad: Pad, into: np.ndarray) -> Work:
    """Return the work arrays where skin is `into` (n,) mm within an object, all of it near."""
    work = pad_worlds.work(pad, 1)
    work.ahead[:] = -into
    work.listed[:] = np.arange(len(into))
    work.found[0] = len(into)
    return work


def turned(degrees: float, n: int) -> np.ndarray:
    angle = np.radians(degrees)
    return np.tile([-np.sin(angle), 0.0, np.cos(angle)], (n, 1))


def test_a_punch_is_full_and_a_paraboloid_by_two_thirds() -> None:
    pad = flat_pad()
    r = np.linalg.norm(pad.points, axis=1)
    punch = penetrated(pad, np.where(r < 4.0, 0.7, -0.1))
    found = penetration(pad, turned(20.0, len(r)), punch)
    assert found == pytest.approx((0.7, 20.0, pad.areas[r < 4.0].sum(), 1.0))
    radius = 4.0
    round_ = penetrated(pad, 0.9 * (1 - r**2 / radius**2))
    depth, angle, patch, fullness = penetration(pad, turned(-5.0, len(r)), round_)
    assert (depth, angle) == pytest.approx((0.9, -5.0), rel=0.01)
    assert patch == pytest.approx(0.75 * np.pi * radius**2, rel=0.01)
    assert fullness == pytest.approx(2 / 3, rel=0.01)


def test_patch_and_fullness_do_not_jump_where_a_vertex_joins() -> None:
    pad = flat_pad()
    r = np.linalg.norm(pad.points, axis=1)
    joins = np.unique(r.round(9))[40] ** 2 / 10  # depth at which further vertices are touched
    before, after = (
        penetration(pad, turned(0.0, len(r)), penetrated(pad, joins + more - r**2 / 10))
        for more in (-1e-6, 1e-6)
    )
    assert after == pytest.approx(before, rel=1e-5)
    assert penetration(pad, turned(0.0, len(r)), penetrated(pad, -r)) == (0.0, 0.0, 0.0, 0.0)

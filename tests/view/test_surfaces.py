"""The finger in pieces: closed, cut in the medial plane, and following the mesh."""

import dataclasses

import numpy as np
import pytest

from fefinger.result import Result
from fefinger.results.records import Fields
from fefinger.support.arrays import Array, Integers
from fefinger.view import frames, surfaces


@pytest.fixture
def half(synthetic: Result) -> Fields:
    assert synthetic.fields is not None
    return synthetic.fields


@pytest.fixture
def shifted(half: Fields) -> Fields:
    """Return a whole finger whose mesh has no points in the medial plane."""
    both = frames.whole(half)
    return dataclasses.replace(both, points=both.points + np.array([0.0, 0.137, 0.0]))


def volume(points: Array, triangles: Integers) -> float:
    """Volume inside closed outward surfaces, by the divergence theorem."""
    a, b, c = points[triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def cells_volume(fields: Fields, region: int) -> float:
    a, b, c, d = fields.points[fields.cells[fields.region == region]].transpose(1, 0, 2)
    return float(np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6)


def enclosed(fields: Fields, *names: str) -> float:
    return sum(
        volume(piece.at(fields.points), piece.triangles)
        for piece in surfaces.cut_open(fields)
        if piece.name in names
    )


def test_the_pieces_of_each_tissue_enclose_its_volume(half: Fields) -> None:
    names = {piece.name for piece in surfaces.cut_open(half)}
    assert names == {"skin", "pad", "subcutaneous tissue"}
    assert enclosed(half, "skin", "pad") == pytest.approx(cells_volume(half, 1), rel=1e-4)
    assert enclosed(half, "subcutaneous tissue") == pytest.approx(cells_volume(half, 2), rel=1e-4)


def test_a_whole_finger_is_cut_through_its_cells(shifted: Fields) -> None:
    """The halves on both sides of the cut add up to the volume of the cells."""
    other = dataclasses.replace(shifted, points=shifted.points * [1.0, -1.0, 1.0])
    for names, region in ((("skin", "pad"), 1), (("subcutaneous tissue",), 2)):
        parts = enclosed(shifted, *names), enclosed(other, *names)
        assert min(parts) > 0
        assert sum(parts) == pytest.approx(cells_volume(shifted, region), rel=1e-4)
    for piece in surfaces.cut_open(shifted):
        y = piece.at(shifted.points)[:, 1]
        assert y.min() >= -1e-3
        assert not piece.flat or y.max() <= 1e-3


def test_the_pad_is_the_skin_that_is_ever_touched(half: Fields) -> None:
    pad = next(piece for piece in surfaces.cut_open(half) if piece.name == "pad")
    touched = pad.at(half.pressure.max(axis=0))[pad.triangles].max(axis=1)
    assert (touched > 0).all()
    skin = next(piece for piece in surfaces.cut_open(half) if piece.name == "skin")
    assert (skin.at(half.pressure.max(axis=0))[skin.triangles].max(axis=1) == 0).any()


def test_the_entire_finger_encloses_all_of_it(half: Fields) -> None:
    both = frames.whole(half)
    (skin,) = surfaces.entire(both)
    expected = 2 * (cells_volume(half, 1) + cells_volume(half, 2))
    assert volume(skin.at(both.points), skin.triangles) == pytest.approx(expected)


def test_outlines_lie_on_the_cut(half: Fields) -> None:
    lines = surfaces.outlines(half)
    assert lines.triangles.shape[1] == 2
    assert np.abs(lines.at(half.points)[:, 1]).max() < 1e-3


def test_points_follow_a_linear_displacement_exactly_on_both_sides(half: Fields) -> None:
    rng = np.random.default_rng(5)
    slope = rng.normal(size=(3, 3)) * [1.0, 0.0, 1.0]
    slope[:, 1] = [0.0, 0.3, 0.0]  # no displacement across the plane of symmetry
    corners = half.points[half.cells[rng.integers(len(half.cells), size=20)]]
    inside = np.einsum("nk,nkj->nj", rng.dirichlet(np.ones(4), 20), corners)
    mirrored = inside * [1.0, -1.0, 1.0]
    followed = surfaces.follow(half, np.concatenate([inside, mirrored]))
    moved = followed.moved(half.points @ slope)
    expected = inside + inside @ slope
    np.testing.assert_allclose(moved[:20], expected, atol=1e-9)
    np.testing.assert_allclose(moved[20:], expected * [1.0, -1.0, 1.0], atol=1e-9)

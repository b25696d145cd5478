"""Marks of end organs and units: which are drawn, where, and with whose rates."""

import dataclasses

import numpy as np
import pytest

from fefinger.results.records import Sites
from fefinger.view import drawing, frames


@pytest.fixture
def crowd(synthetic):
    """Return the result with five end organs of each of the four units, 0.4 mm apart across."""
    assert synthetic.sites is not None
    sites = synthetic.sites
    across = np.array([0.0, 1.0, 0.0]) * np.arange(-2, 3)[:, None] * 0.4
    many = Sites(
        points=(sites.points[:, None] + across).reshape(-1, 3),
        normals=np.repeat(sites.normals, 5, axis=0),
        depths=np.repeat(sites.depths, 5),
        types=tuple(kind for kind in sites.types for _ in range(5)),
        unit=np.repeat(np.arange(4), 5),
    )
    response = dataclasses.replace(synthetic.response, sites=many)
    return dataclasses.replace(synthetic, response=response)


@pytest.mark.parametrize("count", [1, 2, 12])
def test_leaders_do_not_cross(count):
    marks = np.random.default_rng(count).uniform(-1.0, 1.0, (count, 2))
    ends = np.column_stack([np.full(count, 3.0), np.arange(count)[::-1] + 2.0])
    order = drawing.leader_order(marks, ends)
    assert sorted(order) == list(range(count))
    for i in range(count):
        for j in range(i):
            a, b = marks[order[i]], marks[order[j]]
            # Solve a + s (ends_i - a) = b + t (ends_j - b).
            s, t = np.linalg.solve(np.column_stack([ends[i] - a, b - ends[j]]), b - a)
            assert not (0 < s < 1 and 0 < t < 1)


def test_the_higher_of_two_marks_has_the_lower_label_where_it_is_nearer_to_the_column():
    marks, ends = np.array([[0.0, 0.0], [1.0, 0.2]]), np.array([[2.0, 3.0], [2.0, 2.0]])
    assert drawing.leader_order(marks, ends) == [0, 1]


def test_few_end_organs_are_marked_each_and_none_on_the_skin(synthetic):
    found = drawing.marks_in_section(synthetic)
    assert found.labels == ("SAI 0.8 mm", "SAII 1.8 mm", "FAI 0.6 mm", "FAII 3 mm")
    assert drawing.marks_on_skin(synthetic) is None


def test_of_a_population_those_near_the_cut_are_marked(crowd):
    found = drawing.marks_in_section(crowd)
    assert len(found.types) == 4 * 3
    assert np.abs(found.followed.points[:, 1]).max() <= drawing.OFF_PLANE
    assert found.units.tolist() == np.repeat(np.arange(4), 3).tolist()


def test_of_marks_alike_the_most_distal_one_has_the_label(crowd):
    along = crowd.sites.points + np.outer([0.0, 0.2, 0.3, 0.1, 0.0] * 4, [1.0, 0.0, 0.0])
    sites = dataclasses.replace(crowd.sites, points=along)
    response = dataclasses.replace(crowd.response, sites=sites)
    found = drawing.marks_in_section(dataclasses.replace(crowd, response=response))
    assert found.labels[:6] == ("", "SAI 0.8 mm", "", "", "SAII 1.8 mm", "")


def test_a_unit_is_marked_on_the_skin_above_its_end_organs(crowd):
    both = frames.whole(crowd.fields)
    whole = dataclasses.replace(crowd, response=dataclasses.replace(crowd.response, fields=both))
    found = drawing.marks_on_skin(whole)
    assert found.types == ("SAI", "SAII", "FAI", "FAII")
    np.testing.assert_allclose(found.followed.points, 0.0, atol=1e-12)  # all below first touch


def test_rates_are_those_of_the_unit_of_each_mark(crowd):
    found = drawing.marks_in_section(crowd)
    expected = [float(crowd.spikes.rate(unit, 2.5)) for unit in range(4)]
    np.testing.assert_allclose(found.rates(2.5), np.repeat(expected, 3))
    assert drawing.highest_rate(crowd) >= max(expected) > 0
    assert drawing.highest_rate(dataclasses.replace(crowd, spikes=None)) == 0

"""Units under the pad of a result: numbers, sites, delays, and spikes from a response."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger import library, population
from fefinger.checks import InputError
from fefinger.neural.endorgans import TYPES
from fefinger.records import Pad


@pytest.fixture
def pad():
    x = np.linspace(-5, 5, 21)
    xy = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    z = np.sqrt(144 - np.sum(xy**2, axis=1))
    normals = np.column_stack([xy, z]) / 12
    areas = np.full(len(xy), 0.25) / normals[:, 2]
    return Pad(np.column_stack([xy, z - 12]), areas, normals, np.empty((0, 3), np.int64))


@pytest.fixture
def answered(synthetic, pad):
    """Return what makes a response with the strain of the reference, growing, at every site."""

    def make(units):
        response = synthetic.response
        reference = response.reference
        found = population.sites(units)
        which = [reference.types.index(kind) for kind in found.types]
        grown = (response.depth / reference.depth)[:, None, None, None]
        return replace(
            response,
            sites=replace(found, normals=reference.normals[which]),
            strain=grown * reference.strain[which],
        )

    return make


def test_the_fingertip_has_as_many_units_as_its_area_holds(pad):
    units = population.fingertip(pad, TYPES, seed=2)
    area = pad.areas.sum() / 100
    for kind, row in library.innervation().items():
        assert units.types.count(kind) == round(row.density * area)
        counts = np.bincount(units.unit)[np.array(units.types) == kind]
        assert row.organs[0] <= counts.min() <= counts.max() <= row.organs[1]
    plain = population.fingertip(pad, ("SAI",), seed=2, branched=False, densities={"SAI": 10.0})
    assert len(plain.unit) == len(plain) == round(10 * area)


def test_sites_are_the_end_organs_below_the_skin(pad):
    units = population.fingertip(pad, ("SAI", "FAII"), seed=1, depths={"FAII": 2.0})
    found = population.sites(units)
    assert len(found.types) == len(units.unit) == len(found.points)
    depth = 12 - np.linalg.norm(found.points + np.array([0, 0, 12]), axis=1)
    # The skin is at most spacing² / radius away, beside the outermost points.
    np.testing.assert_allclose(depth, found.depths, atol=0.5**2 / 12)
    assert set(found.depths) == {library.receptors()["SAI"].depth, 2.0}


def test_densities_add_up_to_the_published_total():
    assert sum(row.density for row in library.innervation().values()) == 241
    assert tuple(library.innervation()) == TYPES
    for row in library.innervation().values():
        assert row.organs == (1, 1) or row.field is not None


def test_delays_are_distance_over_velocity():
    slow, fast = population.delays(("FAII", "FAI"), 800.0)
    assert slow == pytest.approx(0.8 / 46.9)
    assert fast == pytest.approx(0.8 / 55.3)
    with pytest.raises(InputError, match="distance: expected"):
        population.delays(("FAI",), -1.0)


def test_even_strain_gives_branched_units_the_spikes_of_one_end_organ(pad, answered):
    places = [[0, 0, 0], [1, 1, 0], [-2, 1, 0]]
    types = ("SAI", "FAI", "FAII")
    branched = population.placed(pad, types, places, branched=True, seed=1)
    plain = population.placed(pad, types, places)
    assert len(branched.unit) > len(plain.unit) == 3
    options = {"drives": dict.fromkeys(types, "compressive"), "check": False}
    many = population.fire(answered(branched), branched, **options)
    one = population.fire(answered(plain), plain, distance=500.0, **options)
    assert one.count().sum() > 0
    np.testing.assert_array_equal(many.count(), one.count())
    for kind, a, b in zip(types, many.times, one.times, strict=True):
        np.testing.assert_allclose(a + population.delays((kind,), 500.0), b, atol=1e-7)
    np.testing.assert_array_equal(many.positions, branched.centers)
    np.testing.assert_array_equal(many.depths, branched.depths)


def test_a_response_without_these_sites_is_refused(pad, answered, synthetic):
    units = population.placed(pad, ("SAI",), [[0, 0, 0]])
    with pytest.raises(InputError, match="received it at 4 other sites"):
        population.fire(synthetic.response, units)
    with pytest.raises(InputError, match="gives none"):
        population.fire(replace(answered(units), strain=None), units)

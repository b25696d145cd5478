"""Populations in scenes: places under the skin, sites of mechanics, spikes, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.problems import published
from refusals import refused

import fefinger as ff
from fefinger import afferents
from fefinger.afferents import fire
from fefinger.mechanics import get
from fefinger.mechanics.press.sites import meshed, spherical
from fefinger.mechanics.press.unit_placement import of_population, place_units
from fefinger.neural.populations import BESIDE
from fefinger.pages import report
from fefinger.scene import builtin
from fefinger.scene.ask import innervation
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.support.checks import InputError
from fefinger.support.vocabulary import TYPES


AXIS = direction(STANDARD)
SKIN = spherical(14.0, AXIS)
FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
LINE = ff.Line(start=(0, -2), stop=(0, 2), count=5, branched=False)
PRESS = ff.RampHold(speed=20, depth=0.6, hold=0.2, corner=0.01)


def asked(layout, spikes=("SAI", "FAI"), **options):
    options = {"afferents": "thesis", **options}
    return ff.Ask(spikes=spikes, population=layout, fields=False, pressure=False, **options)


def scene(layout, **options):
    return ff.Scene(finger=FINGER, motion=PRESS, ask=asked(layout, **options))


def test_a_scatter_has_as_many_units_as_its_disc_holds():
    units = place_units(asked(ff.Scatter(radius=5.0, seed=2), TYPES), SKIN, AXIS)
    area = 0.01 * np.pi * 25
    for kind, row in innervation().items():
        assert units.types.count(kind) == round(row.density * area)
        counts = np.bincount(units.unit)[np.array(units.types) == kind]
        assert row.organs[0] <= counts.min() <= counts.max() <= row.organs[1]
    sparse = ff.Scatter(branched=False, densities={"SAI": 10.0})
    plain = place_units(asked(sparse, ("SAI",)), SKIN, AXIS)
    assert len(plain.unit) == len(plain.types) == round(10 * area)


def test_sites_are_the_end_organs_below_the_skin():
    found = of_population(place_units(asked(ff.Scatter(seed=1)), SKIN, AXIS))
    depth = 14 - np.linalg.norm(found.points - 14 * AXIS, axis=1)
    np.testing.assert_allclose(depth, found.depths, atol=0.01)
    deeper = asked(ff.Scatter(seed=1), ("SAI",), depths={"SAI": 2.0})
    assert set(of_population(place_units(deeper, SKIN, AXIS)).depths) == {2.0}


OTHERS = [
    None,
    ff.Scatter(radius=1.5, seed=2),
    replace(LINE, branched=True),
    ff.Grid(spacing=2.0, radius=2.0),
]


@pytest.mark.parametrize("layout", OTHERS, ids=["central", "scatter", "line", "grid"])
def test_other_types_and_their_order_change_no_unit(layout):
    """Its place, end organs, gain and noise depend on the seed, its type and its place there."""
    single = scene(layout, spikes=("FAI",), afferents="recorded")
    alone = get("hertz").respond(single)
    for spikes in (("SAI", "FAI"), ("FAI", "FAII", "SAI")):
        several = scene(layout, spikes=spikes, afferents="recorded")
        response = get("hertz").respond(several)
        organs = np.array(response.sites.types) == "FAI"
        np.testing.assert_allclose(response.sites.points[organs], alone.sites.points, rtol=1e-12)
        # At the same times, which the other types may change.
        same = replace(alone, time=response.time, strain=response.strain[:, organs])
        expected = fire(single.ask, same, check=False)
        trains = fire(several.ask, response, check=False)
        mine = [i for i, kind in enumerate(trains.types) if kind == "FAI"]
        assert [trains.names[i] for i in mine] == list(expected.names)
        assert expected.count().sum() > 0
        for i, times in zip(mine, expected.times, strict=True):
            np.testing.assert_allclose(trains.times[i], times, rtol=0, atol=1e-9)


def test_every_place_has_a_unit_of_each_type():
    pair, grid = ff.Places(places=((0, 0), (1, 2)), branched=False), ff.Grid(branched=False)
    for layout, count in ((LINE, 5), (pair, 2), (grid, 61)):
        units = place_units(asked(layout), SKIN, AXIS)
        places = len(units.types) // 2
        assert units.types == ("SAI", "FAI") * places
        assert places == pytest.approx(count, abs=20 if count == 61 else 0)
        # exact: one place for both types
        np.testing.assert_array_equal(units.skin[::2], units.skin[1::2])


def test_places_of_a_grid_beside_the_skin_are_noted():
    asked_grid = scene(ff.Grid(spacing=2.0, radius=4.0, branched=False))
    response = get("hertz").respond(asked_grid)
    lost = np.isin(response.sites.unit, [0, 1])
    kept = replace(
        response.sites,
        points=response.sites.points[~lost],
        normals=response.sites.normals[~lost],
        depths=response.sites.depths[~lost],
        types=response.sites.types[2:],
        unit=response.sites.unit[~lost] - 2,
        number=response.sites.number[~lost],
    )
    whole = fire(asked_grid.ask, response)
    fewer = fire(asked_grid.ask, replace(response, sites=kept, strain=response.strain[:, ~lost]))
    assert fewer.names == whole.names[2:]
    assert not any("beside the skin" in note for note in whole.notes)
    assert fewer.notes[0].startswith("ask.population: 2 of the 26 units would lie beside the skin")


def test_units_of_a_fingertip_beside_the_skin_are_left_out_and_counted():
    """Of a disc as wide as any pad; the others are those of a skin that has room for all."""
    narrow, types = spherical(8.0, AXIS), ("SAI", "FAII")
    whole, part = (
        place_units(asked(ff.Fingertip(branched=False), types), skin, AXIS)
        for skin in (SKIN, narrow)
    )
    drawn = [round(np.pi * innervation()[kind].density) for kind in types]
    assert [whole.types.count(kind) for kind in types] == drawn
    assert 0 < len(part.types) < len(whole.types)
    over = np.linalg.norm(np.cross(whole.skin, AXIS), axis=1)
    kept = np.isin(whole.numbers, part.numbers)
    assert over[kept].max() < over[~kept].min() + BESIDE
    ask = asked(ff.Fingertip(branched=False), types)
    numbers = of_population(part).number
    names, (note,) = afferents._names(ask.population, types, part.types, numbers)
    assert f"{sum(drawn) - len(part.types)} of the {sum(drawn)} units" in note
    assert names[0] == f"SAI-{np.flatnonzero(kept)[0] + 1}"
    nowhere = ff.Fingertip(densities={"SAI": 0.4}, seed=3)
    with refused("ask.population.radius"):
        place_units(asked(nowhere, ("SAI",)), spherical(1.5, AXIS), AXIS)


def test_of_branched_units_strain_is_kept_at_the_most_compressed_end_organ():
    few = ff.Scatter(radius=1.0, densities={"SAI": 100.0}, seed=1)
    one = scene(few, spikes=("SAI",), afferents="recorded")
    whole = replace(one, ask=replace(one.ask, strain=True))
    kept, full = (ff.run(each, mechanics="hertz") for each in (one, whole))
    assert kept.strain.shape[1] == len(kept.spikes) < full.strain.shape[1]
    least = np.linalg.eigvalsh(full.strain)[..., 0].min(axis=0)
    for unit in range(len(kept.spikes)):
        of_unit = np.flatnonzero(full.sites.unit == unit)
        site = of_unit[np.argmin(least[of_unit])]
        assert kept.sites.points[unit] == pytest.approx(full.sites.points[site])
        assert kept.strain[:, unit] == pytest.approx(full.strain[:, site])
    assert any("one end organ of each unit" in note for note in kept.notes)
    again, other = kept.fire(trial=2), full.fire(trial=2)
    assert again.times[0] == pytest.approx(other.times[0])
    assert kept.fire().times[0] == pytest.approx(kept.spikes.times[0])
    assert abs(again.times[0][0] - kept.fire().times[0][0]) > 1e-5  # other noise
    of_thesis = replace(one, ask=replace(one.ask, afferents="thesis"))
    with refused("ask.strain"):
        ff.run(of_thesis, mechanics="hertz").fire(trial=2)


def test_the_skin_of_half_a_mesh_is_that_of_the_whole():
    points = np.array([[x, y, 0.1 * (x + y * y)] for x in range(4) for y in range(3)], float)
    quads = [(3 * i + j, 3 * i + j + 1, 3 * i + j + 3) for i in range(3) for j in range(2)]
    quads += [(3 * i + j + 1, 3 * i + j + 4, 3 * i + j + 3) for i in range(3) for j in range(2)]
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    half = meshed(points, np.array(quads), normals, half=False)
    whole = meshed(points, np.array(quads), normals, half=True)
    assert whole.areas.sum() == pytest.approx(2 * half.areas.sum())
    assert len(whole.points) == 2 * len(points) - 4
    np.testing.assert_allclose(np.sort(whole.points[:, 1]), -np.sort(-whole.points[:, 1])[::-1])


@pytest.fixture(scope="module")
def halved():
    return get("linear").respond(scene(LINE))


def test_half_a_finger_gives_the_sites_of_the_whole(halved):
    y = halved.sites.points[:, 1]
    assert y.min() < -1.5
    assert y.max() > 1.5
    other = np.arange(10).reshape(5, 2)[::-1].ravel()  # the same type at the mirrored place
    np.testing.assert_allclose(y, -y[other], atol=1e-9)
    mirror = np.diag([1.0, -1.0, 1.0])
    np.testing.assert_allclose(halved.strain, mirror @ halved.strain[:, other] @ mirror, atol=1e-9)
    assert np.abs(halved.strain[-1, :, 0, 1]).max() > 1e-4


def test_half_a_finger_and_the_whole_give_the_same_strain(halved):
    tilted = replace(scene(LINE), indenter=ff.Flat(tilt=1e-6))
    whole = get("linear").respond(tilted)
    assert whole.numbers["half"] == 0.0
    scale = np.abs(halved.strain[-1]).max()
    # Two meshes of the same finger.
    np.testing.assert_allclose(whole.strain[-1], halved.strain[-1], atol=0.12 * scale)


def test_the_central_unit_fires_as_the_one_under_first_touch():
    central = fire(scene(None).ask, get("hertz").respond(scene(None)))
    across = fire(scene(LINE).ask, get("hertz").respond(scene(LINE)))
    assert central.count().sum() > 3
    for k, kind in enumerate(("SAI", "FAI")):
        middle = across.index(f"{kind}-3")
        np.testing.assert_allclose(across.positions[middle], central.positions[k], atol=0.01)
        np.testing.assert_allclose(across.times[middle], central.times[k], atol=2e-4)


def test_hertz_is_the_same_in_every_direction():
    ring = scene(ff.Places(places=((0.0, 2.0), (0.0, -2.0)), branched=False))
    found = fire(ring.ask, get("hertz").respond(ring))
    np.testing.assert_allclose(found.x_in[:, 0], found.x_in[:, 2], atol=1e-9)
    np.testing.assert_allclose(found.x_in[:, 1], found.x_in[:, 3], atol=1e-9)


def test_spread_noise_and_distance_reach_the_units():
    layout = replace(LINE, spread=0.5, noise=0.5, distance=500.0, seed=7)
    response = get("hertz").respond(scene(layout))
    found = fire(scene(layout).ask, response)
    plain = fire(scene(LINE).ask, response)
    assert found.seed == 7
    assert plain.seed is None
    assert not np.allclose(found.current.max(axis=0), plain.current.max(axis=0))
    assert found.t_stop > plain.t_stop


def test_delays_are_distance_over_velocity():
    slow, fast = afferents.delays(("FAII", "FAI"), 800.0)
    assert slow == pytest.approx(0.8 / 46.9)
    assert fast == pytest.approx(0.8 / 55.3)
    with refused("distance"):
        afferents.delays(("FAI",), -1.0)


def test_a_response_without_these_end_organs_is_refused(synthetic):
    with pytest.raises(InputError, match="'linear' has no end organs of a population"):
        fire(asked(LINE), synthetic.response)
    with pytest.raises(InputError, match="gives no strain"):
        fire(asked(LINE), replace(synthetic.response, strain=None))
    with refused("ask.spikes"):
        fire(ff.Ask(spikes=("SAI",)), replace(synthetic.response, reference=None))


REFUSED = [
    ({"kind": "scater"}, "ask.population.kind: .*Did you mean 'scatter'"),
    ({"kind": "grid", "radios": 2}, r"radios: unknown key in \[ask.population\]"),
    ({"kind": "line", "stop": [1, 1]}, "ask.population.start: missing"),
    ({"kind": "line", "start": [1, 1], "stop": [1, 1]}, "a place other than start"),
    (
        {"kind": "line", "start": [0, 0], "stop": [1, 1], "count": 1},
        "count: expected a whole number at least 2",
    ),
    ({"kind": "places", "places": []}, r"places: expected 1 to .* places .*, received none"),
    ({"kind": "places", "places": 3}, "places: expected a list"),
    ({"kind": "places", "places": [[1]]}, r"places\[0\]: expected a list of 2 numbers"),
    ({"radius": 40}, "ask.population.radius: .*at most 10"),
    ({"densities": {"SA": 3}}, r"SA: unknown key in \[ask.population.densities\]"),
    ({"densities": {"SAI": 0}}, "densities.SAI: .*above 0"),
    ({"densities": 3}, "densities: expected a table"),
    ({"seed": -1}, "seed: expected a whole number"),
    ({"rule": "sum"}, "ask.population.rule: expected one of 'mean'"),
    ({"noise": 1e6}, "ask.population.noise: .*at most 100"),
    ({"branched": 1}, "branched: expected true or false"),
]


@pytest.mark.parametrize(("table", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_layouts_that_cannot_be_used_get_a_sentence(table, message):
    base = published.load("flat-press").to_dict()
    with pytest.raises(InputError, match=message):
        ff.Scene.from_dict(base | {"ask": {"spikes": ["SAI"], "population": table}})


def test_places_off_the_finger_and_a_population_without_types_get_a_sentence():
    far = scene(ff.Places(places=((0.0, 13.5),)))
    with pytest.raises(InputError, match=r"ask\.population\.places puts no place on the skin"):
        get("hertz").respond(far)
    with refused("places"):
        get("linear").respond(far)
    with pytest.raises(InputError, match=r"expected ask\.spikes to name the types"):
        ff.Ask(population=LINE)
    with pytest.raises(InputError, match="leaves no unit"):
        get("hertz").respond(scene(ff.Scatter(radius=0.1)))


def test_scenes_with_populations_go_to_toml_and_back():
    for layout in (
        ff.Scatter(radius=3, densities={"SAI": 50}, spread=0.2, seed=4),
        ff.Fingertip(densities={"FAI": 50}),
        ff.Grid(spacing=0.5),
        LINE,
        ff.Places(places=((0, 1), (1, 1))),
    ):
        one = scene(layout)
        assert ff.Scene.from_toml(one.to_toml()) == one
    changed = published.load("population-press", {"ask.population.kind": "grid"})
    assert changed.ask.population == ff.Grid(radius=4.0, seed=1)
    set_ = published.load("flat-press", builtin.settings(["ask.population.radius=2"]))
    assert set_.ask.population == ff.Scatter(radius=2.0)


@pytest.fixture(scope="module")
def answered():
    overrides = {"finger.resolution": "coarse", "ask.population.radius": 2.5}
    overrides |= {"ask.afferents": "thesis"}
    return ff.run(published.load("population-press", overrides), mechanics="hertz")


def test_a_population_is_saved_loaded_and_told(answered, tmp_path, monkeypatch):
    monkeypatch.setattr("fefinger.pages.page.svg", lambda drawn: "data:,")
    answered.save(tmp_path)
    again = ff.load(tmp_path)
    np.testing.assert_array_equal(again.sites.unit, answered.sites.unit)
    # exact: a file keeps every bit
    np.testing.assert_array_equal(again.spikes.positions, answered.spikes.positions)
    assert again.scene == answered.scene
    rows = (tmp_path / "spikes.csv").read_text().splitlines()
    assert len(rows) == 1 + answered.spikes.count().sum()
    assert "x_mm" in rows[0]
    html = (tmp_path / "report.html").read_text(encoding="utf-8")
    for text in ("Spikes of the population", "SAI (14 units)", "FAI (27 units)", "from 27 of 27"):
        assert text in html
    assert "No noise" in html
    said = ("contact_area", "centroid", "pad", "pressure", "sites", "strain", "fields")
    response = replace(answered.response, **dict.fromkeys(said))
    drawn = replace(answered, spikes=replace(answered.spikes, seed=3), response=response)
    report.write(drawn, tmp_path / "drawn.html")
    html = (tmp_path / "drawn.html").read_text(encoding="utf-8")
    assert "No noise" not in html
    assert "from the seed 3" in html

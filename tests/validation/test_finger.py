"""Suites finger and friction: chain of models, split of causes, checks that can fail."""

import json
from importlib.resources import files

import numpy as np
import pytest
from fefinger.validation.finger import causes
from fefinger.validation.finger import split as finger_split
from fefinger.validation.friction import blocks, dots, layers, sheared, waves
from fefinger.validation.problems import chain

from fefinger.contact.stepper import Target
from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.lumped.spring import Spring


def test_the_first_model_of_the_chain_is_hertz_of_the_relaxed_tissue():
    depth, force, _ = chain.reaching("hertz", chain.scene("d.s.", "flat-30"))
    finger = chain.scene("d.s.", "flat-30").finger
    skin, rest = finger.skin, finger.subcutaneous
    part = skin.thickness / (0.5 * finger.thickness)
    modulus = 1 / (part / skin.modulus + (1 - part) / rest.modulus)
    expected = Hertz(12.0, float(depth[-1]), modulus, 0.48).force
    assert 1e3 * force[-1] == pytest.approx(expected, rel=1e-9)
    assert depth == pytest.approx(0.2 * 11.5 * np.arange(1, 13) / 12)


def test_one_tissue_makes_the_layers_alike_and_nothing_else():
    pressed = chain.scene("a.h.", "sphere-5")
    alike = chain.one_tissue(pressed)
    assert alike.finger.skin.modulus == alike.finger.subcutaneous.modulus
    forces = [chain.reaching("hertz", each)[1] for each in (alike, pressed)]
    assert forces[0] == pytest.approx(forces[1])


def test_a_ball_has_no_angle():
    assert "level" not in chain.models("sphere-5")
    assert chain.models("flat-30") == tuple(chain.CHAIN)


def test_the_factors_multiply_to_finite_strain_over_hertz():
    for subject in chain.SUBJECTS:
        split = finger_split.factors(subject, "sphere-5")
        first, last = (
            finger_split.force(subject, "sphere-5", model)[5] for model in ("hertz", "solid")
        )
        assert np.prod(list(split.values())) == pytest.approx(last / first)
        swapped = finger_split.other_order(subject, "sphere-5")
        assert swapped["whole"] * swapped["layered"] == pytest.approx(
            split["layered"] * split["linear"]
        )


def test_steepness_finds_m_of_an_exponential_spring(monkeypatch):
    depth = 2.0 * np.arange(1, 13) / 12
    force = Spring(m=2.1, b=0.18).force(depth)
    springs = {"solid": force.tolist()}
    made = {"depth_mm": depth.tolist(), "thickness_mm": 10.0, "force_N": springs}
    monkeypatch.setattr(finger_split, "rows", lambda: {"a.h./flat-30": made})
    assert finger_split.steepness("a.h.", "solid") == pytest.approx(2.1, rel=1e-9)
    springs["solid"] = (depth**1.5).tolist()
    assert finger_split.steepness("a.h.", "solid") == pytest.approx(np.log(2**1.5 - 1), rel=1e-9)


def test_a_stale_report_is_found(monkeypatch):
    assert causes.stale("hertz", "a.h.", "flat-30") < 1e-4
    kept = finger_split.force
    monkeypatch.setattr(causes, "force", lambda *which: kept(*which) * np.linspace(1, 1.01, 12))
    assert causes.stale("hertz", "a.h.", "flat-30") == pytest.approx(0.0099, rel=0.01)


@pytest.fixture(autouse=True)
def _own_cache(operators):
    """Keep to the operators of this session."""


def test_stick_and_force_converge_with_the_squares():
    for measure in (sheared.stick_error, sheared.force_error):
        coarse, fine = (measure("squares", size) for size in (8, 16))
        assert fine < 0.8 * coarse


def test_the_checks_see_a_wrong_flexibility_and_a_wrong_coefficient():
    matrix, rest = blocks.offset(0.7 * sheared.limit())
    x = blocks.solved(matrix, rest, 0.5)
    n = len(rest) // 3
    wrong = matrix.copy()
    wrong[n:, n:] *= 1.02
    assert np.abs(blocks.solved(wrong, rest, 0.5) - x).max() > 1e-3 * x.max()
    assert np.abs(blocks.solved(matrix, rest, 0.51) - x).max() > 1e-3 * x.max()


def test_drag_vanishes_with_the_memory_and_peaks_between_its_rates():
    drags = [waves.exact(speed) for speed in (1e-6, 1.0, 20.0, 1e6)]
    assert max(drags[0], drags[3]) < 1e-3 * drags[2]


def test_dots_on_layers_that_have_gone_more_than_half_their_way_are_mirrored(monkeypatch):
    monkeypatch.setattr(layers, "POINTS", 128)
    monkeypatch.setattr(layers, "SPACING", 0.12)
    monkeypatch.setattr(layers, "STEP", 0.5)
    layers.fine.cache_clear()
    scene = dots.scene(2.0, 0.7)
    organs, pad = layers.sites(scene), layers.fine()
    strains = layers.strains(scene, organs)
    moved = np.array([1.5, 0.0])
    gap = pad.gap(lambda at: scene.indenter.profile.rise(at - moved))
    contact = pad.contact(lambda shift: gap)
    contact.advance(0.0, Target(600.0, by_force=True))
    shallow = organs.depths == organs.depths.min()
    found = pad.strain(contact.pressure, float(organs.depths.min()), organs.points[shallow, :2])
    assert strains[3, shallow] == pytest.approx(found, abs=1e-3 * np.abs(found).max())
    assert np.abs(strains[1, shallow] - found).max() > 0.1 * np.abs(found).max()
    later = layers.strains(scene, organs, start=0.5)
    assert later[2] == pytest.approx(strains[3], abs=1e-3 * np.abs(strains).max())
    layers.fine.cache_clear()


def test_spikes_over_dots_on_ridges_do_not_depend_on_the_grid():
    """Of the committed measurement: means over draws of units, with what the page says of them."""
    report = json.loads(files("fefinger.reports").joinpath("ridges.json").read_text("utf-8"))
    at = dots.SPACINGS.index(report["varied_at_mm"])
    for kind in dots.recorded():
        rates, smooth = (np.array(report[skin][kind]["Hz"]) for skin in ("ridges", "smooth"))
        for name in ("finer_grid_Hz", "moved_by_part_of_a_point_Hz"):
            assert report[name]["mean"][kind] == pytest.approx(rates[at], rel=0.05)
        if kind == "FAII":
            assert (rates > smooth + 4.0).all()
        else:
            assert rates == pytest.approx(smooth, rel=0.1)
    swing = report["FAII_input_mm"]
    assert swing["ridges"]["at_speed_over_pitch"] > 20 * swing["smooth"]["at_speed_over_pitch"]


def test_friction_changes_no_rate_of_faii_over_dots_by_more_than_draws_do():
    """Of the committed measurement; rates of SAI and FAI change by less than a tenth."""
    report = json.loads(files("fefinger.reports").joinpath("ridges.json").read_text("utf-8"))
    for kind in dots.recorded():
        free, rubbed = (report[skin][kind] for skin in ("ridges", "ridges_and_friction"))
        change = np.abs(np.array(rubbed["Hz"]) - free["Hz"])
        if kind == "FAII":
            assert (change < free["deviation"]).all()
        else:
            assert (change < 0.09 * np.array(free["Hz"])).all()


def test_over_moved_gratings_types_differ_as_recorded_ones_do_where_the_skin_has_ridges():
    """Of the committed measurement, with the order that Goodwin et al. (1987) describe."""
    report = json.loads(files("fefinger.reports").joinpath("gratings.json").read_text("utf-8"))
    rates = {kind: np.array(each["Hz"]) for kind, each in report["ridges"].items()}
    slow, rapid = rates["SAI"], rates["FAI"]
    assert (np.diff(slow, axis=0) > 0.0).all()
    assert np.ptp(slow, axis=1) == pytest.approx(0.0, abs=0.1 * slow.max())
    assert (np.diff(rapid, axis=0) > 0.0).all()
    assert (np.diff(rapid, axis=1) > 0.0).all()
    deep = rates["FAII"]
    assert (np.diff(deep, axis=1) > 0.4 * deep[:, 1:]).all()
    assert deep == pytest.approx(np.tile(deep.mean(axis=0), (4, 1)), rel=0.2)


def test_recorded_rates_are_those_of_three_types_over_rising_spacings():
    recorded = dots.recorded()
    assert set(recorded) == {"SAI", "FAI", "FAII"}
    for spacing, rate in recorded.values():
        assert (np.diff(spacing) > 0).all()
        assert spacing[0] <= dots.SPACINGS[0]
        assert dots.SPACINGS[-1] <= spacing[-1]
        assert (rate > 0).all()

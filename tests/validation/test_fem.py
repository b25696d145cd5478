"""The suite `fem`: its oracles, its measures, and that a wrong program would not pass."""

from dataclasses import replace

import numpy as np
import pytest
from fefinger.validation.fem import drawings, element_kinds, hertz, history
from fefinger.validation.fem.drawings import PEERS
from fefinger.validation.oracles.punch import Cone, FlatPunch
from fefinger.validation.problems.grids import box
from fefinger.validation.problems.quarter import Indenter, half_space_field, turned

from fefinger.fem.elements.assembly import Elastic, stiffness


@pytest.fixture(scope="module")
def coarse():
    return hertz.body(0.49, 0)


def test_the_field_around_a_contact_is_that_of_the_closed_form():
    truth = hertz.hertz(0.4)
    points = np.random.default_rng(1).uniform([0, 0, 1.5], [3, 3, 4.5], (30, 3))
    points[0, 2] = 0.0
    points[0, :2] = 2.5
    found = half_space_field(points, hertz.exact(truth), modulus=100.0, poisson=0.4)
    r = np.hypot(*points.T[:2])
    outward, inward = truth.displacement(r, points[:, 2])
    assert found[:, 2] == pytest.approx(inward, rel=1e-9)
    assert np.einsum("ni,ni->n", found[:, :2], points[:, :2]) / r == pytest.approx(outward)


@pytest.mark.parametrize(
    "truth", [Cone(80.0, 0.2, 100.0, 0.3), FlatPunch(1.0, 0.01, 100.0, 0.3)], ids=["cone", "punch"]
)
def test_the_rule_integrates_infinite_pressures(truth):
    a = truth.contact_radius
    exact = replace(
        hertz.exact(hertz.hertz(0.3)),
        axes=(a, a),
        pressure=lambda x, y: truth.pressure(np.hypot(x, y)),
    )
    far = half_space_field(np.array([[0.0, 0.0, 1e4]]), exact, modulus=100.0, poisson=0.3)[0, 2]
    shear = 100.0 / 2.6
    expected = truth.force / (4 * np.pi * shear) * (1 + 2 * 0.7) / 1e4
    assert far == pytest.approx(expected, rel=1e-4)


def test_turned_strains_keep_their_invariants():
    strain = np.array([[0.1], [0.2], [-0.4], [0.05]])
    turn = np.array([np.cos(0.7), np.sin(0.7)])
    tensor = turned(strain, turn)[0]
    assert np.trace(tensor) == pytest.approx(-0.1)
    outward = np.append(turn, 0)
    assert outward @ tensor @ outward == pytest.approx(0.1)
    assert outward @ tensor @ [0, 0, 1] == pytest.approx(0.05)


def test_a_wrong_gap_or_modulus_or_far_field_is_seen(coarse):
    truth = hertz.hertz(0.49)

    def error(body):
        return abs(body.pressed(truth.depth).force / truth.force - 1)

    assert error(coarse) < 0.01
    flatter = Indenter(lambda x, y: 0.95 * coarse.indenter.profile(x, y))
    softer = {1: Elastic(97.0, 0.49)}
    assert error(replace(coarse, indenter=flatter)) > 0.015
    assert error(replace(coarse, tissues=softer)) > 0.015
    assert error(replace(coarse, prescribed=0 * coarse.prescribed)) > 0.1


def test_the_l2_error_of_no_pressure_and_of_twice_the_pressure_is_one(coarse):
    truth = hertz.hertz(0.49)
    pressed = coarse.pressed(truth.depth)
    exact = hertz.exact(truth)
    values = exact.pressure(*coarse.space.points[coarse.patch.vertices, :2].T)
    at_vertices = replace(pressed, pressure=values)
    assert at_vertices.pressure_error(exact, 0.9) < 0.05  # what straight lines between leave
    for factor in (0.0, 2.0):
        scaled = replace(pressed, pressure=factor * values)
        assert scaled.pressure_error(exact, 0.9) == pytest.approx(1.0, abs=0.1)


def test_unloading_follows_ting_and_not_the_integral_of_the_thesis():
    name, steps = "slow up, fast down", 200
    time, found, exact = history.cycle(name, steps)
    assert np.abs(found - exact).max() < 0.01 * exact.max()
    assert history.detachment_error(name, steps) <= 0.5
    elastic = history.force(history.pressed(history.ELASTIC, "depth", *history.motion(name, steps)))
    naive = history.hereditary_integral(history.prony(), time, elastic)
    naive = naive / history.prony().long_time
    assert np.abs(naive - exact).max() > 0.03 * exact.max()
    assert naive.min() < 0 <= found.min()


def test_our_element_among_the_kinds_is_the_one_that_answers_scenes():
    line = np.linspace(0, 1, 3)
    space, tissues = box(line, line, line), {1: Elastic(3.0, 0.4)}
    ours = element_kinds.assembled(element_kinds.OURS, space, tissues).matrix
    answering = stiffness(space, tissues)
    assert abs(ours - answering).max() < 1e-14 * abs(answering).max()


def test_every_kind_converges_where_it_should_and_p1_locks():
    rows = {kind.name: element_kinds.hertz_row(kind, 0.3, 0) for kind in element_kinds.KINDS}
    assert abs(rows[element_kinds.OURS.name]["force_%"]) < 1
    assert all(abs(row["force_%"]) < 20 for row in rows.values())
    locked = element_kinds.hertz_row(element_kinds.KINDS[-1], 0.4999, 0)
    assert locked["force_%"] > 100


def test_the_kinds_of_linear_elements_hold_a_linear_displacement():
    line = np.linspace(0, 1, 3)
    space, tissues = box(line, line, line), {1: Elastic(3.0, 0.4)}
    gradient = np.array([[0.1, 0.2, -0.3], [0.4, -0.3, 0.1], [0.05, 0.6, 0.2]])
    inner = ((space.points > 0) & (space.points < 1)).all(axis=1)
    for kind in element_kinds.KINDS:
        wide = element_kinds.embedding(kind, space)
        discrete = element_kinds.assembled(kind, space, tissues)
        unknowns = np.zeros(discrete.matrix.shape[0])
        nodes = space.node_points[: discrete.n_displacements // 3]
        unknowns[: discrete.n_displacements] = (nodes @ gradient.T).ravel()
        held = np.repeat(inner, 3)
        rest = (discrete.matrix @ unknowns)[: len(held)][held]
        assert np.abs(rest).max() < 1e-12, kind.name
        moved = wide @ unknowns[: discrete.n_displacements]
        assert moved == pytest.approx((space.node_points @ gradient.T).ravel(), abs=1e-14)


def test_the_report_on_elements_is_drawn_beside_other_programs():
    rows = drawings.measured()
    names = {kind.name for kind in element_kinds.KINDS}
    assert {row["element"] for row in rows} == names
    told = drawings.beside(rows)
    shown = [row[0] for row in told]
    assert shown.count("fefinger") == 3 * len(element_kinds.RATIOS)
    assert {peer.program for peer in PEERS} < set(shown)
    assert [row for row in told if len(row) == 1] == [
        [f"Poisson's ratio {poisson:g}"] for poisson in element_kinds.RATIOS
    ]
    assert len(told) == len(PEERS) + 4 * len(element_kinds.RATIOS)
    drawn = drawings.kinds(rows)
    assert {line.get_label() for line in drawn.axes[0].lines} == names

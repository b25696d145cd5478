"""What `hertz` and `layered` share: strain in loading, hold, release and creep, and balance."""

from dataclasses import replace
from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest

import fefinger as ff
from fefinger.mechanics import hertz, layered
from fefinger.mechanics.press.axisymmetric import ElasticContact
from fefinger.theory.contact.contact_table import tabulate_to
from fefinger.theory.relaxation import creep_integral


FINGER = ff.Finger.subject("a.h.", tissue="maeno1998")
PRONY = FINGER.prony


class Sibling(NamedTuple):
    """A mechanics, and the elastic contact of its finger under a plate."""

    mechanics: ModuleType
    body: ElasticContact


SIBLINGS = {
    "hertz": Sibling(hertz, hertz.HalfSpace(14.0, *hertz.tissue(FINGER))),
    "layered": Sibling(layered, tabulate_to(layered.stack(FINGER), 14.0, depth=1.0)),
}
EACH = pytest.mark.parametrize("sibling", SIBLINGS.values(), ids=SIBLINGS)

MOTIONS = [
    ff.RampHold(20, 0.5, hold=1.0),
    ff.Trapezoid(20, 0.5, hold=0.1),
    ff.RampSinusoid(20, 0.4, amplitude=0.3, frequency=8, cycles=3),
    ff.Trapezoid(loading_rate=2, force=0.3, hold=0.1),
]


def respond(sibling, motion=MOTIONS[0]):
    scene = ff.Scene(finger=FINGER, motion=motion, ask=ff.Ask(fields=False))
    return sibling.mechanics.respond(scene)


def elastic(sibling, answer):
    """Strain (n_t, 4, 3, 3) at the four end organs of the elastic finger at the depths."""
    inward = -answer.sites.normals[0]
    values = sibling.body.strain(answer.depth, np.zeros(4), answer.sites.depths)[..., None]
    axis = np.outer(inward, inward)
    across = values[:, 0, ..., None] * (np.eye(3) - axis)
    return across + values[:, 2, ..., None] * axis


@EACH
def test_on_loading_and_hold_strain_is_the_elastic_field_at_the_present_depth(sibling):
    answer = respond(sibling)
    want = elastic(sibling, answer)
    assert answer.strain == pytest.approx(want, abs=3e-4 * np.abs(want).max())
    holding = answer.time >= answer.time[-1] - 1.0
    assert np.ptp(answer.strain[holding], axis=0).max() < 1e-12
    assert np.ptp(answer.force[holding]) > 0.3 * answer.force.max()  # while the force relaxes


@EACH
def test_after_release_a_residual_strain_remains_and_fades_without_pressure(sibling):
    release = ff.Sampled([0, 0.1, 0.2, 0.3, 1.3], depth=[0, 0.5, 0.5, -0.2, -0.2])
    answer = respond(sibling, release)
    off = answer.time > 0.3
    size = np.abs(answer.strain[off]).max(axis=(1, 2, 3))
    assert size[0] > 0.02 * np.abs(answer.strain).max()
    assert (np.diff(size) < 0).all()
    assert size[-1] < 0.5 * size[0]
    assert np.abs(answer.pressure[off]).max() == answer.force[off].max() == 0
    assert np.isnan(answer.centroid[off]).all()
    assert answer.contact_area[off].max() == 0


@EACH
def test_at_fixed_force_strain_and_depth_creep_as_the_creep_function_says(sibling):
    body, answer = sibling.body, respond(sibling, ff.RampHold(loading_rate=5, force=0.3, hold=20.0))
    holding = answer.time >= answer.time[-1] - 20.0
    assert answer.force[holding] == pytest.approx(0.3, rel=1e-9)
    assert (np.diff(answer.depth[holding]) > 0).all()
    assert answer.depth[-1] == pytest.approx(body.depth(300.0), rel=1e-3)  # relaxed by then
    want = elastic(sibling, answer)
    assert answer.strain == pytest.approx(want, abs=3e-4 * np.abs(want).max())
    # Long before that, too: the elastic force of the depth is the force convolved with J.
    want = creep_integral(PRONY, answer.time, 1e3 * answer.force) * PRONY.long_time
    assert body.force(answer.depth) == pytest.approx(want, abs=1e-3 * want.max())
    ceiling, weights, rates = PRONY.creep()
    later = answer.time[holding][3:] - 0.035  # after the middle of the ramp of 60 ms and a corner
    growth = PRONY.long_time * (ceiling - np.exp(-np.outer(later, rates)) @ weights)
    reached = body.force(answer.depth[holding][3:]) / 300.0
    slow = later > 0.1
    assert reached[slow] == pytest.approx(growth[slow], rel=2e-3)


@EACH
@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.kind)
def test_pressure_never_pulls_and_adds_up_to_the_force(sibling, motion):
    answer = respond(sibling, motion)
    assert answer.pressure.min() > -1e-9 * answer.pressure.max()
    total = 1e-3 * answer.pressure @ answer.pad.areas
    assert total == pytest.approx(answer.force, abs=1e-9 * answer.force.max())
    assert 0.99 < answer.contact_area.max() / answer.pad.areas.sum() < 1 + 1e-9
    prescribed = answer.depth if motion.control == "depth" else answer.force
    assert prescribed == pytest.approx(motion.value(answer.time), abs=1e-9)
    edges = answer.pad.points[answer.pad.triangles]
    flat = np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0])
    assert (flat @ answer.pad.normals[0] > 0).all()
    assert 0.85 < np.linalg.norm(flat, axis=1).sum() / 2 / answer.pad.areas.sum() < 1.05


@EACH
def test_a_round_ellipsoid_is_the_ball_that_it_is(sibling):
    scene = ff.Scene(finger=FINGER, motion=MOTIONS[0], ask=ff.Ask(fields=False))
    ball, same = (
        sibling.mechanics.respond(replace(scene, indenter=indenter))
        for indenter in (ff.Sphere(5.0), ff.Ellipsoid((5.0, 5.0, 5.0)))
    )
    assert same.force == pytest.approx(ball.force)
    assert any("equivalent radius" in note for note in same.notes)

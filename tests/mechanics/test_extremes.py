"""Bad meshes and extreme tissues: refused in a sentence or survived, never silently wrong."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.contact.complementarity import Complementarity
from fefinger.fem.body import Body, body, reduce
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.probe import strain_at
from fefinger.geometry.finger_mesh import FingerMesh, whole
from fefinger.mechanics import linear
from fefinger.mechanics import solid as finite
from fefinger.mechanics.press import placement, problem
from fefinger.mechanics.press.mesh_limits import refinement_location
from fefinger.mechanics.situation import Situation
from fefinger.mesh.store import load_or_build
from fefinger.support.checks import ConvergenceError, InputError


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
HELD = problem.fixed_facets(FINGER)
DEPTH = 0.6


@pytest.fixture(scope="module")
def mesh() -> FingerMesh:
    return load_or_build(FINGER, half=True)


def solid(mesh: FingerMesh, skin: float, pulp: float, poisson: float = 0.48) -> Body:
    return body(mesh, {1: Elastic(skin, poisson), 2: Elastic(pulp, poisson)}, HELD)


def pressed(finger: Body, touch: Obstacle, depth: float) -> tuple[float, float, float]:
    """Return the force, and how far forces and moments are from balance, relative to it."""
    on_pad = patch(finger.space, finger.pad, finger.normals, touch, 1.0)
    small = reduce(finger, on_pad, strain_at(finger.space, np.empty((0, 3))))
    pressure = Complementarity(small.flexibility).solve(on_pad.gap - depth * on_pad.projected)
    loads = on_pad.loads @ pressure
    reactions = np.zeros(finger.space.n_unknowns)
    held = finger.system.fixed
    reactions[held] = finger.system.reactions(finger.system.solve(loads), loads)
    nodes = reactions[: finger.space.n_displacements].reshape(-1, 3)
    force = float(on_pad.projected @ pressure)
    moment = np.cross(finger.space.node_points, nodes).sum(axis=0) + pressure @ on_pad.moment
    if finger.half:
        moment = moment[1:2]  # the other half balances the rest
    off = abs(float(-nodes.sum(axis=0) @ touch.axis / force) - 1)
    return force, off, float(np.abs(moment).max() / (force * FINGER.width))


@pytest.mark.parametrize(
    ("skin", "pulp", "poisson"),
    [
        (136.0, 80.0, 0.48),
        (136.0, 80.0, 0.5),
        (80e9, 80.0, 0.48),
        (80.0, 80e9, 0.48),
        (80.0, 80e9, 0.5),
    ],
)
def test_force_and_moment_balance_to_1e8_at_any_moduli(
    mesh: FingerMesh, skin: float, pulp: float, poisson: float
) -> None:
    finger = solid(mesh, skin, pulp, poisson)
    force, off, turning = pressed(finger, placement.obstacle(ff.Flat(30), finger), DEPTH)
    assert force > 0
    assert off < 1e-8
    assert turning < 1e-8


def test_the_moment_of_a_whole_finger_balances_about_every_axis(mesh: FingerMesh) -> None:
    finger = solid(whole(mesh), 136, 80)
    _, off, turning = pressed(finger, placement.obstacle(ff.Flat(30, 10), finger), DEPTH)
    assert off < 1e-8
    assert turning < 1e-8


def test_an_incompressible_skin_a_billion_times_stiffer_than_the_pulp_is_refused(
    mesh: FingerMesh,
) -> None:
    finger = solid(mesh, 80e9, 80, 0.5)
    with pytest.raises(ConvergenceError, match=r"at most 1e-10, reached .*moduli"):
        pressed(finger, placement.obstacle(ff.Flat(30), finger), DEPTH)


def test_an_indenter_that_starts_inside_the_body_is_a_press_to_that_depth(mesh: FingerMesh) -> None:
    finger = solid(mesh, 136, 80)
    touch = placement.obstacle(ff.Flat(30), finger)
    inside = replace(touch, origin=touch.origin + 0.4 * touch.axis)
    assert pressed(finger, inside, DEPTH - 0.4)[0] == pytest.approx(
        pressed(finger, touch, DEPTH)[0], rel=1e-9
    )


def test_a_motion_that_starts_at_a_depth_answers_with_the_instantaneous_force() -> None:
    asked = ff.Ask(fields=False, pressure=False, strain=False)
    at_once = ff.Scene(finger=FINGER, motion=ff.Sampled((0, 1), (DEPTH, DEPTH)), ask=asked)
    response = linear.respond(at_once)
    prony = FINGER.prony
    expected = response.force[0] * prony.relaxation(response.time)
    assert response.force == pytest.approx(expected, rel=1e-9)


def inverted(mesh: FingerMesh) -> FingerMesh:
    cells = mesh.cells.copy()
    cells[7] = cells[7][[1, 0, 2, 3]]
    return replace(mesh, cells=cells)


def flat(mesh: FingerMesh) -> FingerMesh:
    points = mesh.points.copy()
    corner = mesh.cells[7]
    points[corner[3]] = points[corner[:3]].mean(axis=0)
    return replace(mesh, points=points)


def lost(mesh: FingerMesh) -> FingerMesh:
    points = mesh.points.copy()
    points[mesh.cells[7, 0]] = np.nan
    return replace(mesh, points=points)


def without_skin(mesh: FingerMesh) -> FingerMesh:
    kept = mesh.region != 1
    return replace(mesh, cells=mesh.cells[kept], region=mesh.region[kept])


def without_hold(mesh: FingerMesh) -> FingerMesh:
    nothing = np.empty((0, 3), dtype=np.int64)
    return replace(mesh, facets=mesh.facets | dict.fromkeys(HELD, nothing) | {"medial": nothing})


BAD = [
    (inverted, r"1 inverted or flat ones, the first of them number 7"),
    (flat, r"inverted or flat ones"),
    (lost, r"inverted or flat ones"),
    (without_skin, r"expected cells of region 1, received only regions 2, 3"),
    (without_hold, r"held facets: expected at least one"),
]


@pytest.mark.parametrize(("fault", "message"), BAD)
def test_a_mesh_that_cannot_be_solved_on_is_refused(
    mesh: FingerMesh, fault: object, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        solid(fault(mesh), 136, 80)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave out the continuation behind the cut, which contact would meet much deeper."""
    monkeypatch.setattr("fefinger.mechanics.press.problem.needs_continuation", lambda *_: False)


def deep(angle: float = 0.0) -> ff.Scene:
    """Return a press along the finger, of tissue without memory, that stands at its depth."""
    elastic = replace(FINGER, prony=ff.Prony((1.0,), ()))
    press, ask = ff.Sampled((0.0, 0.01), (1.6, 1.6)), ff.Ask(fields=False, strain=False)
    return ff.Scene(finger=elastic, indenter=ff.Flat(angle), motion=press, ask=ask)


@pytest.mark.usefixtures("short")
def test_a_long_contact_that_meets_the_cut_is_refused() -> None:
    with pytest.raises(InputError, match=r"1\.6 mm it reaches the proximal cut, behind which"):
        linear.respond(deep())


@pytest.mark.usefixtures("few_steps", "short")
def test_finite_strain_goes_no_further_than_to_where_the_contact_meets_the_cut() -> None:
    with refused("motion"):
        finite.respond(deep())


@pytest.mark.usefixtures("few_steps")
def test_finite_strain_answers_the_same_press_on_the_continued_finger() -> None:
    flat, steeper = (finite.respond(deep(angle)).force[-1] for angle in (0, 7))
    assert 0.8 < flat / steeper < 1.25


def test_the_border_that_a_contact_reaches_is_called_by_its_name(mesh: FingerMesh) -> None:
    finger = solid(mesh, 136, 80)
    border = placement.border(finger)
    x, z = finger.space.points[border][:, 0], finger.space.points[border][:, 2]
    ends = {"proximal cut": border[np.argmin(x)], "nail": border[np.argmax(z + 0.5 * x)]}
    for name, vertex in ends.items():
        with pytest.raises(InputError, match=f"at a depth of 1.5 mm it reaches the {name}"):
            placement.check_inside(finger, np.array([vertex]), 1.5)
    within = np.setdiff1d(np.unique(finger.pad), border)
    placement.check_inside(finger, within, 1.5)


def test_gap_and_moment_are_those_of_the_contact() -> None:
    scene = ff.Scene(finger=FINGER, motion=ff.Ramp(60, 1.0), ask=ff.Ask(fields=False))
    response = linear.respond(scene)
    assert response.gap.shape == response.pressure.shape
    touching = response.pressure[-1] > 0
    assert np.abs(response.gap[-1][touching]).max() < 0.05
    assert response.gap[-1][~touching].min() > -0.05
    assert response.moment[:, [0, 2]] == pytest.approx(0.0)
    axis = np.array([-0.5, 0.0, np.sqrt(0.75)])
    weights = response.pressure[-1] * response.pad.areas
    expected = weights @ np.cross(response.pad.points, axis)[:, 1] / 1e3
    assert response.moment[-1, 1] == pytest.approx(expected, abs=0.02 * response.force[-1])


@pytest.mark.parametrize(
    ("subject", "at"),
    [("a.h.", (0, 5.1)), ("a.h.", (0, 5.3)), ("a.h.", (3.1, 0)), ("p.w.", (3, 3))],
)
def test_a_place_on_the_pad_is_not_refused_because_its_mesh_is_made_for_a_rounded_one(
    subject: str, at: tuple[float, float]
) -> None:
    scene = ff.Scene(
        finger=ff.Finger.subject(subject, tissue="maeno1998"),
        indenter=ff.Sphere(5, at=at),
        motion=ff.Ramp(60, 0.3),
    )
    assert linear.unmeshable(Situation.of(scene)) == ()


def test_a_place_from_which_no_part_of_the_pad_is_covered_is_refused_as_the_scene_gives_it() -> (
    None
):
    scene = ff.Scene(finger=FINGER, indenter=ff.Sphere(5, at=(14, 0)), motion=ff.Ramp(60, 0.3))
    (said,) = linear.unmeshable(Situation.of(scene))
    assert said.text.endswith("within 8.4 mm of (0, 0), received (14.0, 0.0)")


def test_neighboring_scenes_share_a_mesh_that_is_fine_where_they_touch() -> None:
    assert refinement_location(ff.Flat(30)) is None
    assert refinement_location(ff.Flat(36, 10)) is None
    assert refinement_location(ff.Flat(10)) == 15.0
    assert refinement_location(ff.Grating(4, 2, 0.6, angle=0)) == 0.0
    assert refinement_location(ff.Sphere(5)) is None
    assert refinement_location(ff.Sphere(5, at=(-2.0, 1.0))) is None
    assert refinement_location(ff.Cylinder(5, at=(-6.7, -3.2))) == (-6.0, 4.0)

"""Coulomb friction on a hyperelastic cube under a plate that slides, or a ball that does."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
import pytest
from fefinger.validation.problems.cube import glued_cube
from scipy.sparse.linalg import splu

from fefinger.contact.frictional import FrictionalContact
from fefinger.contact.stepper import Prescribed, march
from fefinger.fem.contact.deformed_gap import tangents
from fefinger.fem.contact.obstacle import Obstacle
from fefinger.fem.hyperelastic import load_path
from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.fem.hyperelastic.load_path import FrictionHistory, SideLoad
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State
from fefinger.geometry.profiles import Ellipsoid, Plane, Profile
from fefinger.support.checks import ConvergenceError


MU = 0.4
DEPTH, FAR = 0.1, 0.15
"""Depth and path in mm: of the path a third ends stick."""


@dataclass(frozen=True)
class Slid:
    """All equilibria of a slide: states, loads of the plate across its axis, and what held them."""

    body: Continuum
    solver: Equilibrium
    history: FrictionHistory
    states: list[State]
    loads: SideLoad

    @property
    def pulls(self) -> np.ndarray:
        """Force (n, 2) of the plate across its axis."""
        return self.loads.force

    @property
    def forces(self) -> np.ndarray:
        """Force (n,) of the plate along its axis."""
        areas = self.solver.contact.projected
        return np.array([areas @ each.pressure for each in self.states]) + self.loads.axial


def slide(
    depth: Callable[[float], float],
    path: Callable[[float], float],
    *,
    steps: int = 8,
    mu: tuple[float, float] = (MU, MU),
    heading: tuple[float, float] = (1.0, 0.0),
    turn: np.ndarray | None = None,
    profile: Profile | None = None,
    poisson: float = 0.4,
    control: str = "depth",
) -> Slid:
    """Press to depth(t) and slide by path(t) mm along a heading, for t from 0 to 1."""
    turn = np.eye(3) if turn is None else turn
    body, solver = glued_cube(turn, profile or Plane(), poisson)
    history = FrictionHistory(solver.contact, mu)
    along = turn @ [*heading, 0.0]
    times = np.linspace(0.0, 1.0, steps + 1)
    states, loads = [], []

    def observe(_: int, state: State) -> None:
        states.append(state)
        loads.append(SideLoad.of(solver.contact, body.space, state, history))

    course = load_path.LoadPath(control, times, depth, lambda t: path(t) * along)
    load_path.follow(solver, load_path.StressHistory(body, {}), course, observe, friction=history)
    return Slid(body, solver, history, states, SideLoad.stacked(loads))


def pressed(t: float, scale: float = 1.0) -> float:
    """Return the depth in mm: reached at half the time, then kept."""
    return scale * DEPTH * min(2 * t, 1.0)


def moved(t: float, scale: float = 1.0) -> float:
    """Return the path in mm: from half the time on."""
    return scale * FAR * max(2 * t - 1.0, 0.0)


@cache
def standard(steps: int = 8) -> Slid:
    """Return the press and the slide of the plate."""
    return slide(pressed, moved, steps=steps)


@pytest.mark.parametrize("profile", [None, Ellipsoid((2.0, 2.0, 2.0))], ids=["plate", "ball"])
def test_the_base_bears_pressure_and_friction_and_their_moment(profile: Profile | None):
    done = slide(pressed, moved, profile=profile)
    state, contact = done.states[-1], done.solver.contact
    count, gap = done.body.space.n_displacements, contact.at(state)
    inner, _ = done.body.residual(state.values, done.body.at_rest)
    pulled = gap.loads @ state.pressure + gap.tangential @ state.traction.ravel()
    held = np.setdiff1d(np.arange(count), done.solver.system.free)
    reaction = np.zeros(count)
    reaction[held] = (inner - pulled)[held]
    total = reaction.reshape(-1, 3).sum(axis=0)
    borne = done.forces[-1]
    assert total[2] == pytest.approx(borne, rel=1e-6)
    across = -total @ np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).T
    assert across == pytest.approx(done.pulls[-1], abs=1e-6 * borne)
    assert np.hypot(*done.pulls[-1]) > 0.1 * borne
    arms = done.body.space.node_points + state.values[:count].reshape(-1, 3)
    turning = np.cross(arms, (reaction + pulled[:count]).reshape(-1, 3)).sum(axis=0)
    assert turning == pytest.approx(np.zeros(3), abs=1e-6 * borne)


def test_every_vertex_obeys_signorini_and_coulomb_in_every_step():
    """Laws of the definition, with slips as integrals of the displacement over the skin."""
    done, kinds = standard(), set()
    contact, count = done.solver.contact, done.body.space.n_displacements
    part = contact.on.part
    for before, after in pairwise(done.states):
        gap = contact.at(after).gaps / contact.projected
        pressed, top = after.pressure > 0, after.pressure.max()
        assert after.pressure.min() >= 0
        assert np.abs(gap[pressed]).max() < 1e-7
        assert gap[~pressed].min(initial=0.0) > -1e-7
        change = (after.values - before.values)[:count].reshape(-1, 3)
        moving = np.einsum("kq,tkc->tqc", part.quadratic, change[part.nodes])
        slid = moving - (after.shift - before.shift)
        hats = np.einsum("tjq,tqc->tjc", part.hats, slid)
        mean = np.stack(
            [np.bincount(contact.on.owner.ravel(), hats[..., c].ravel()) for c in (0, 1)]
        )
        slip = mean / contact.projected * [[-1.0], [1.0]]  # the first direction is -x
        size = np.hypot(*after.traction)
        assert (size - MU * after.pressure).max() < 1e-9 * top
        stuck = size < (1 - 1e-6) * MU * after.pressure
        kinds |= {(bool(x), bool(y)) for x, y in zip(pressed, stuck, strict=True)}
        # The solver weighs by deformed areas.
        alike = 0.05 * np.abs(slid).max()
        assert np.hypot(*slip[:, stuck]).max(initial=0.0) < alike
        slips = pressed & ~stuck & (np.hypot(*slip) > alike)
        power, full = (after.traction * slip).sum(axis=0), size * np.hypot(*slip)
        assert (power < -0.98 * full)[slips].all()
    assert {(True, True), (True, False)} <= kinds


def test_it_tends_to_friction_at_small_strain_in_first_order_of_the_depth():
    errors = []
    for scale in (0.02, 0.01):
        depth, path = partial(pressed, scale=scale), partial(moved, scale=scale)
        done = slide(depth, path)
        contact, rest, free = done.solver.contact, done.states[0], done.solver.system.free
        gap, areas = contact.at(rest), contact.projected
        loads = np.hstack([gap.loads.toarray(), gap.tangential.toarray()])[free]
        tangent = done.body.tangent(rest.values, done.body.at_rest).tocsc()
        flexibility = loads.T @ splu(tangent[np.ix_(free, free)]).solve(loads)
        elastic = np.ones(1), np.zeros(0)
        small = FrictionalContact(
            (flexibility + flexibility.T) / 2, (MU, MU), gap.gaps, areas, elastic
        )
        times = np.linspace(0.0, 1.0, 9)
        places = np.array([[-path(t), 0.0] for t in times])  # the first direction is -x
        course = Prescribed("depth", times, np.array([depth(t) for t in times]), places)
        pulled = march(small, course).sliding.traction @ areas
        errors.append(np.abs(done.pulls - pulled).max() / np.abs(pulled).max())
    assert errors[1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.2)


def test_a_scene_that_is_turned_as_a_whole_has_the_same_contact():
    random = np.random.default_rng(4)
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    one = standard()
    other = slide(pressed, moved, turn=turn)
    top = one.states[-1].pressure.max()
    for a, b in zip(one.states, other.states, strict=True):
        assert b.pressure == pytest.approx(a.pressure, abs=1e-5 * top)
    size = [np.hypot(*each.pulls.T) for each in (one, other)]
    assert size[1] == pytest.approx(size[0], abs=1e-5 * size[0].max())


def test_half_the_steps_change_the_friction_by_less_than_a_thousandth():
    pulls = [standard(steps).pulls[:: steps // 8] for steps in (8, 16, 32)]
    largest = np.abs(pulls[-1]).max()
    coarse, fine = (np.abs(np.diff(pair, axis=0)).max() / largest for pair in pairwise(pulls))
    assert fine < coarse < 1e-3


def test_friction_takes_work_at_every_step_and_no_closed_path_gains_any():
    """Press, slide to and fro, and let go: the plate does what friction loses, in the limit."""
    gained = []
    for steps in (24, 96):
        done = slide(
            lambda t: DEPTH * min(6 * t, 1.0, 6 - 6 * t),
            lambda t: FAR * float(np.interp(t, [0, 1 / 6, 3 / 6, 5 / 6, 1], [0, 0, 1, 0, 0])),
            steps=steps,
        )
        lost = done.loads.work
        assert np.diff(lost).min() >= -1e-9 * lost[-1]
        depth = np.array([each.depth for each in done.states])
        place = -np.array([each.shift[0] for each in done.states])  # along the first direction
        mean = (
            (done.forces[1:] + done.forces[:-1]) / 2,
            (done.pulls[1:, 0] + done.pulls[:-1, 0]) / 2,
        )
        put_in = float(mean[0] @ np.diff(depth) + mean[1] @ np.diff(place))
        assert done.forces[-1] == pytest.approx(0, abs=1e-9)
        gained.append(put_in / lost[-1] - 1)
    assert 0 < gained[1] < 0.6 * gained[0] < 0.06


def test_skin_that_slips_has_the_kinetic_coefficient_and_the_static_one_before():
    done = slide(pressed, lambda t: 2 * moved(t), mu=(MU, MU / 2), steps=16)
    ratio = np.hypot(*done.pulls.T)[1:] / done.forces[1:]
    assert ratio.max() > 1.05 * MU / 2
    assert ratio[-1] == pytest.approx(MU / 2, rel=1e-3)
    assert not done.loads.sticking[-1].any()


def test_a_prescribed_force_has_friction_as_the_depth_that_it_reaches():
    by_depth = standard()
    force = dict(zip(np.linspace(0, 1, 9).tolist(), by_depth.forces.tolist(), strict=True))
    by_force = slide(force.__getitem__, moved, control="force")
    assert [x.depth for x in by_force.states[1:]] == pytest.approx(
        [x.depth for x in by_depth.states[1:]], rel=1e-4
    )
    assert by_force.pulls == pytest.approx(by_depth.pulls, abs=1e-4 * np.abs(by_depth.pulls).max())


def test_the_slip_of_skin_that_turns_about_the_middle_of_a_ball_is_its_path_along_the_ball():
    axis, radius = np.array([0.0, 0.6, -0.8]), 2.0
    random = np.random.default_rng(1)
    ball = Obstacle(axis, np.zeros(3), Ellipsoid(3 * (radius,)))
    middle = -radius * axis
    away = random.normal(size=(20, 3)) * 0.5 + 3 * axis
    places = middle + radius * away / np.linalg.norm(away, axis=1, keepdims=True)
    distance, gradient = ball.implicit(places)
    assert distance == pytest.approx(np.zeros(20), abs=1e-12)
    along = tangents(axis, gradient)
    length = np.linalg.norm(gradient, axis=1)
    squares = np.einsum("nac,nbc->nab", along, along)
    assert squares == pytest.approx(length[:, None, None] ** 2 * np.eye(2), abs=1e-12)
    assert np.einsum("nac,nc->na", along, gradient) == pytest.approx(np.zeros((20, 2)), abs=1e-12)
    turned = np.cross([0.1, -0.3, 0.2], places - middle)
    slip = np.einsum("nac,nc->na", along, turned) / length[:, None]
    assert np.hypot(*slip.T) == pytest.approx(np.linalg.norm(turned, axis=1))


def test_skin_that_goes_with_a_ball_does_not_slip_and_skin_that_stays_behind_does():
    body, solver = glued_cube(np.eye(3), Ellipsoid((2.0, 2.0, 2.0)), 0.4)
    contact, count = solver.contact, body.space.n_displacements
    rest = State(np.zeros(body.space.n_unknowns), np.zeros(len(contact)), 0.0)
    along, across = 0.07, np.array([0.05, -0.03, 0.0])
    values = rest.values.copy()
    values[:count].reshape(-1, 3)[:] = across + along * contact.obstacle.axis
    behind = replace(rest, depth=along, shift=across)
    gone = replace(behind, values=values)
    assert contact.slip(contact.at(gone), gone, rest) == pytest.approx(
        np.zeros((2, len(contact))), abs=1e-12
    )
    deeper = replace(rest, depth=along)
    left = contact.slip(contact.at(deeper), deeper, rest)
    assert np.abs(left).max() > 0.1 * along * contact.projected.min()


def test_a_coefficient_without_a_solution_ends_in_an_error():
    with pytest.raises(ConvergenceError, match=r"Coulomb.s law|relative residual"):
        slide(pressed, lambda t: 50 * moved(t), mu=(50.0, 50.0), steps=2)

"""Equilibrium and its passage through time at finite strain, against closed forms."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from fefinger.validation.problems.cube import Cube, across, cube, nominal, stretches
from numpy.polynomial import Chebyshev
from scipy import sparse

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic import newton
from fefinger.fem.hyperelastic.iterate import ASTRAY, Anderson, stagnant
from fefinger.fem.hyperelastic.linearized import FactoredTangent
from fefinger.fem.hyperelastic.load_path import (
    FactorizationBudget,
    LoadPath,
    Series,
    StressHistory,
    follow,
)
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.fem.hyperelastic.newton import LEAST, STUCK, TRUST, Equilibrium
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.tolerances import EQUILIBRIUM, LEAST_FORCE, SMALL_FORCE
from fefinger.theory.relaxation import Prony, hereditary_integral


RATIOS = (0.0, 0.3, 0.45, 0.49, 0.5)
LAWS = {
    "neo-hookean": material_of,
    "mooney-rivlin": lambda elastic: material_of(elastic, "mooney-rivlin", share=0.4),
    "demiray": lambda elastic: material_of(elastic, "demiray", exponent=1.5),
    "veronda-westmann": lambda elastic: material_of(elastic, "veronda-westmann", exponent=1.0),
}
PRONY = Prony((0.3, 0.4, 0.3), (60.0, 2.0))
SERIES = {1: Series(np.array(PRONY.weights), np.array(PRONY.v))}


def at_rest(pressed: Cube) -> State:
    count = pressed.body.space.n_unknowns
    return State(np.zeros(count), np.zeros(len(pressed.equilibrium.contact)), 0.0)


def force_of(pressed: Cube, state: State) -> float:
    """Return the force in mN of a state."""
    return float(pressed.equilibrium.contact.projected @ state.pressure)


def pressed_to(pressed: Cube, *depths: float) -> tuple[Target, State]:
    """Return the last target and the state at it."""
    state = at_rest(pressed)
    for depth in depths:
        target = Target("depth", depth, pressed.body.at_rest)
        state = pressed.equilibrium.find(state, target)
    return target, state


def squeezed(material: Material, depths: list[float]) -> tuple[float, np.ndarray, State]:
    """Return the force in mN and the stretches at the last of the depths, and the state."""
    pressed = cube(material)
    _, state = pressed_to(pressed, *depths)
    return force_of(pressed, state), stretches(state.values, pressed.body), state


def forces_along(pressed: Cube, path: LoadPath, **options: object) -> np.ndarray:
    """Return the forces in mN at the times of a path."""
    forces: list[float] = []
    history = StressHistory(pressed.body, SERIES, **options)
    follow(pressed.equilibrium, history, path, lambda _, s: forces.append(force_of(pressed, s)))
    return np.array(forces)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("poisson", RATIOS)
def test_a_cube_squeezed_to_half_its_height_has_its_closed_form(name: str, poisson: float):
    material = LAWS[name](Elastic(40.0, poisson))
    force, stretch, _ = squeezed(material, [0.1, 0.2, 0.3, 0.4, 0.5])
    assert force == pytest.approx(nominal(material, 0.5), rel=1e-5)
    assert stretch == pytest.approx([across(material, 0.5)] * 2 + [0.5], rel=1e-6)


def test_a_cube_that_is_not_nearly_incompressible_does_not_fold_at_its_corner():
    """In ten steps one is not found by rounding alone, in one of twenty runs; in these, in none."""
    material = material_of(Elastic(100.0, 0.45), "mooney-rivlin")
    _, stretch, _ = squeezed(material, np.linspace(0.025, 0.5, 20).tolist())
    assert stretch == pytest.approx([across(material, 0.5)] * 2 + [0.5], rel=1e-6)


def test_the_same_cube_in_other_units_gives_the_same_strains():
    forces = [squeezed(material_of(Elastic(e, 0.49)), [0.2])[0] / e for e in (1e-3, 40.0, 1e9)]
    assert forces == pytest.approx([forces[0]] * 3, rel=1e-6)


def test_residuals_are_scaled_by_the_largest_load_of_an_equilibrium_not_of_an_iterate():
    """An iterate can overshoot; what it bore must not loosen the tolerance of later steps."""
    pressed = cube(LAWS["demiray"](Elastic(40.0, 0.49)))
    solver, borne = pressed.equilibrium, 0.0
    state = at_rest(pressed)
    for depth in (0.4, 0.2):
        state = solver.find(state, Target("depth", depth, pressed.body.at_rest))
        loads = solver.contact.at(state).loads
        borne = max(borne, float(np.linalg.norm(loads @ state.pressure)))
        assert solver.load == pytest.approx(borne, rel=1e-12)


def test_factors_that_fail_in_single_precision_are_made_in_double(
    unsound: Callable[..., None],
):
    material = material_of(Elastic(40.0, 0.49), "demiray", exponent=1.5)
    usual, _, _ = squeezed(material, [0.2, 0.4])
    unsound(np.float32)
    pressed = cube(material)
    solver = pressed.equilibrium
    target, state = pressed_to(pressed, 0.2)
    solver._renew(solver._evaluate(state, target), target)
    assert len(solver.system.failed) == solver.factors + 1 >= 2
    state = solver.find(state, replace(target, value=0.4))
    assert force_of(pressed, state) == pytest.approx(usual, rel=1e-6)
    unsound(np.float32, np.float64)
    with pytest.raises(ConvergenceError, match="tangent of an iterate is singular"):
        solver._renew(solver._evaluate(state, target), target)
    with pytest.raises(InputError, match="hold more facets or repair the mesh"):
        cube(material)


def test_all_nodes_of_the_plate_carry_the_same_pressure_and_none_pulls():
    material = material_of(Elastic(40.0, 0.5))
    force, _, state = squeezed(material, [0.2])
    assert state.pressure == pytest.approx(np.full(len(state.pressure), force), rel=1e-5)


def test_the_bed_under_a_contact_is_as_stiff_as_stability_asks(monkeypatch: pytest.MonkeyPatch):
    pressed = cube(material_of(Elastic(40.0, 0.49)))
    solver = pressed.equilibrium
    target, state = pressed_to(pressed, 0.1, 0.3, 0.5)
    pressures = (solver.system.free >= pressed.body.space.n_displacements).sum()
    solver._renew(solver._evaluate(state, target), target)
    assert solver._factored.approximate_factor.negative == pressures
    monkeypatch.setattr(newton, "SUPPORTS", newton.SUPPORTS[:1])
    soft = cube(material_of(Elastic(40.0, 0.49))).equilibrium
    soft._renew(soft._evaluate(state, target), target)
    assert soft._factored.approximate_factor.negative > pressures
    assert soft._factored.support.max() < solver._factored.support.max()


def test_a_step_too_large_is_reported():
    with pytest.raises(ConvergenceError, match="press less deep"):
        pressed_to(cube(material_of(Elastic(40.0, 0.5)), 1), 1.2)


# Through time


def passed(material: Material, times: np.ndarray, depth: object, **options: object) -> np.ndarray:
    """Return the force in mN at the times, under depth control."""
    return forces_along(cube(material, 1), LoadPath("depth", times, depth), **options)


@pytest.mark.parametrize("poisson", RATIOS)
def test_a_body_without_memory_that_is_left_again_is_at_rest_at_once(poisson: float):
    """Nothing is left to which the errors of that last step could be relative."""
    pressed, states = cube(material_of(Elastic(40.0, poisson))), []
    history = StressHistory(pressed.body, {1: Series(np.ones(1), np.empty(0))})
    times, depth = np.arange(9.0), lambda time: 0.1 * min(time, 8.0 - time)
    follow(
        pressed.equilibrium, history, LoadPath("depth", times, depth), lambda _, s: states.append(s)
    )
    assert np.abs(states[-1].values).max() < 1e-7
    forces = [float(pressed.equilibrium.contact.projected @ state.pressure) for state in states]
    assert forces[-1] < EQUILIBRIUM * max(forces)  # single pressures go with the processor
    assert pressed.equilibrium.factors < 10  # 60 and more in the last step, and no equilibrium


def ramp(time: float) -> float:
    """Return a depth in mm: 0.4 mm in 40 ms, then a hold."""
    return min(10.0 * time, 0.4)


def relaxed(material: Material, times: np.ndarray) -> np.ndarray:
    """Return the force of `ramp`: P = stretch times the hereditary integral of P_e / stretch.

    With free sides the lateral S stays zero, so that S along the axis relaxes alone.
    """
    fine = np.unique(np.concatenate([np.linspace(0, 0.05, 2001), times]))
    stretch = 1 - np.array([ramp(t) for t in fine])
    pressure = Chebyshev.interpolate(np.vectorize(partial(nominal, material)), 16, (0.6, 1.0))
    elastic = pressure(stretch) / stretch
    scaled = Prony(PRONY.c, PRONY.v)
    stress = hereditary_integral(scaled, fine, elastic) / scaled.long_time
    return np.asarray((stretch * stress)[np.searchsorted(fine, times)])


@pytest.mark.parametrize("tiny", [1e-9, 1e-12, 1e-16])
def test_forces_far_below_the_largest_one_of_a_path_are_met_as_closely_as_can_be(tiny: float):
    pressed = cube(material_of(Elastic(40.0, 0.49)), 1)
    times, forces = np.linspace(0, 1, 6), 10 * np.array([tiny, 1, tiny, 0, tiny**0.5, 1])
    path = LoadPath("force", times, lambda time: float(np.interp(time, times, forces)))
    close = EQUILIBRIUM * max(SMALL_FORCE * forces.max(), LEAST_FORCE)
    assert forces_along(pressed, path) == pytest.approx(forces, rel=EQUILIBRIUM, abs=close)


def timed(steps: int) -> np.ndarray:
    """Return times with `steps` in the ramp, and some in the hold."""
    return np.concatenate([np.linspace(0, 0.04, steps + 1), [0.041, 0.05, 0.1, 1.0]])


@pytest.mark.parametrize(
    "material",
    [material_of(Elastic(40.0, 0.5)), material_of(Elastic(40.0, 0.49), "demiray", exponent=2.0)],
)
def test_a_ramp_and_hold_is_the_hereditary_integral_to_second_order(material: Material):
    errors = []
    for steps in (5, 10):
        times = timed(steps)
        exact = relaxed(material, times)
        errors.append(np.abs(passed(material, times, ramp) - exact).max() / exact.max())
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] > 3.4


def test_a_jump_starts_stiff_by_one_over_c0_and_ends_relaxed():
    material = material_of(Elastic(40.0, 0.5))
    forces = passed(material, np.array([0.0, 1e3]), lambda t: 0.3)
    assert forces[0] == pytest.approx(nominal(material, 0.7) / PRONY.long_time, rel=1e-5)
    assert forces[1] == pytest.approx(nominal(material, 0.7), rel=1e-3)


def test_pressure_that_does_not_relax_changes_a_compressible_cube_only():
    times = np.array([0.0, 0.05])
    soft, tight = (material_of(Elastic(40.0, nu)) for nu in (0.3, 0.4999))
    whole, part = (
        [passed(law, times, lambda t: 0.2, deviatoric=flag) for law in (soft, tight)]
        for flag in (False, True)
    )
    assert part[1] == pytest.approx(whole[1], rel=5e-3)
    assert part[0][0] < 0.97 * whole[0][0]


def test_retraction_leaves_the_plate_without_pull_and_work_is_lost_in_the_cycle():
    material = material_of(Elastic(40.0, 0.49))
    times = np.linspace(0.0, 0.08, 41)

    def depth(t: float) -> float:
        return 0.3 - abs(0.3 - 7.5 * t)

    forces = passed(material, times, depth)
    assert (forces >= 0).all()
    assert (forces[-5:] == 0).all()
    depths = np.array([depth(t) for t in times])
    assert np.trapezoid(forces, depths) > 0


@pytest.mark.parametrize("step", [1e-6, 1e3])
def test_steps_from_a_microsecond_to_a_thousand_seconds_are_stable(step: float):
    material = material_of(Elastic(40.0, 0.49))
    forces = passed(material, step * np.arange(4.0), lambda t: min(0.1 * t / step, 0.2))
    bounds = np.array([nominal(material, 0.8), nominal(material, 0.8) / PRONY.long_time])
    assert forces[-1] == pytest.approx(bounds[0 if step > 1 else 1], rel=1e-3)


def test_a_held_force_creeps_to_the_depth_of_the_relaxed_cube():
    material = material_of(Elastic(40.0, 0.5))
    pressed = cube(material, 1)
    target, depths = nominal(material, 0.8), []
    history = StressHistory(pressed.body, SERIES)
    times = np.concatenate([[0.0], np.geomspace(1e-3, 30.0, 25)])
    path = LoadPath("force", times, lambda t: target)

    def keep(_: int, state: State) -> None:
        depths.append(state.depth)
        assert force_of(pressed, state) == pytest.approx(target, rel=1e-6)

    follow(pressed.equilibrium, history, path, keep)
    assert (np.diff(depths) > 0).all()
    assert depths[-1] == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize("poisson", [0.3, 0.45])
def test_one_iteration_with_a_fresh_tangent_finds_the_depth_of_a_slightly_larger_force(
    poisson: float,
):
    # The stiffness of the contact travels with the plate: it does not resist the travel itself.
    force, _, state = squeezed(material_of(Elastic(40.0, poisson)), [0.15, 0.3])
    pressed = cube(material_of(Elastic(40.0, poisson)))
    solver = pressed.equilibrium
    more = Target("force", 1.0001 * force, pressed.body.at_rest, force)
    iterate = solver._evaluate(state, more)
    solver._renew(iterate, more)
    first = solver._step(iterate, more, Anderson(1))
    exact = solver.find(state, more)
    assert first.depth - state.depth == pytest.approx(exact.depth - state.depth, rel=1e-3)


@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_a_path_under_force_control_takes_few_iterations(poisson: float):
    """Some 70 in 13 steps; three times as many if the depth is not accelerated with the rest."""
    material = material_of(Elastic(40.0, poisson))
    force, _, _ = squeezed(material, [0.1, 0.2, 0.3])
    pressed = cube(material)
    path = LoadPath("force", np.linspace(0, 1, 13), lambda time: force * min(2 * time, 1.0))
    follow(pressed.equilibrium, StressHistory(pressed.body, SERIES), path, lambda *_: None)
    assert pressed.equilibrium.iterations < 110


def starts_and_ends(
    solver: Equilibrium, path: LoadPath, monkeypatch: pytest.MonkeyPatch
) -> tuple[list[State], list[State]]:
    """Return the states from which the steps of a path start, and those that they find."""
    starts, ends, find = [], [], solver.find

    def seen(start: State, target: Target) -> State:
        starts.append(start)
        ends.append(find(start, target))
        return ends[-1]

    monkeypatch.setattr(solver, "find", seen)
    follow(solver, StressHistory(solver.body, SERIES), path, lambda *_: None)
    return starts, ends


def test_a_step_of_a_hold_starts_where_creep_as_in_the_step_before_it_would_lead(
    monkeypatch: pytest.MonkeyPatch,
):
    """Not so the first one, before which the plate moved."""
    path = LoadPath("force", np.array([0.0, 0.01, 0.02, 0.04, 0.08]), lambda t: 1000 * min(t, 0.01))
    solver = cube(material_of(Elastic(40.0, 0.3)), 1).equilibrium
    starts, ends = starts_and_ends(solver, path, monkeypatch)
    assert starts[2].depth == pytest.approx(ends[1].depth, rel=1e-12)
    for start, last, before in zip(starts[3:], ends[2:], ends[1:], strict=False):
        assert last.depth > before.depth
        assert start.depth == pytest.approx(2 * last.depth - before.depth, rel=1e-12)
        assert start.values == pytest.approx(2 * last.values - before.values)
        assert start.pressure == pytest.approx(2 * last.pressure - before.pressure)


def test_no_step_starts_with_tension(monkeypatch: pytest.MonkeyPatch):
    depths = [0.0, 0.1, 0.3, 0.01]
    path = LoadPath("depth", np.arange(4) / 10, lambda t: depths[round(10 * t)])
    solver = cube(material_of(Elastic(40.0, 0.3), "demiray", exponent=2.0), 1).equilibrium
    starts, ends = starts_and_ends(solver, path, monkeypatch)
    on = ends[1].toward(ends[2], 1 + (0.01 - 0.3) / 0.2).pressure
    assert on.min() < 0
    assert starts[3].pressure == pytest.approx(np.maximum(on, 0.0))


def test_the_flexibility_of_columns_that_come_later_is_that_of_all_at_once():
    material = material_of(Elastic(40.0, 0.3))
    _, _, state = squeezed(material, [0.2])
    solver = cube(material).equilibrium
    target = Target("depth", 0.2, solver.body.at_rest)
    found = []
    for parts in (1, 3):
        solver._renew(solver._evaluate(state, target), target)
        factored = solver._factored
        for part in range(1, parts + 1):
            near = np.arange(len(solver.contact)) < len(solver.contact) * part / parts
            flexibility = factored.contact(near).flexibility
        found.append(flexibility)
        assert factored.flexibility == pytest.approx(
            factored.loads.T @ factored.columns.T, abs=1e-6 * np.abs(flexibility).max()
        )
    assert found[1] == pytest.approx(found[0], abs=1e-5 * np.abs(found[0]).max())


def test_nothing_follows_an_obstacle_where_gaps_would_open_by_it():
    """As in a body that would buckle without the obstacle: slower, but it converges."""
    material = material_of(Elastic(40.0, 0.49))
    force, _, state = squeezed(material, [0.15, 0.3])
    pressed = cube(material)
    solver, projected = pressed.equilibrium, pressed.equilibrium.contact.projected
    more = Target("force", 1.0001 * force, pressed.body.at_rest, force)
    iterate = solver._evaluate(state, more)
    solver._renew(iterate, more)
    loads = iterate.gap.loads
    assert (projected - loads.T @ solver._factored.following).min() < 0
    following, closing = solver._factored.travel(loads, projected)
    assert not following.any()
    assert np.array_equal(closing, projected)
    assert projected @ solver.find(state, more).pressure == pytest.approx(more.value, rel=1e-6)


def test_an_iteration_that_runs_away_is_told_as_one_so_that_its_step_is_split():
    """It left as an error of the linear algebra, which no step control catches."""
    mixing = Anderson(3)
    mixing.next(np.zeros(2), np.array([1.0, 1e200]))
    with np.errstate(over="ignore"), pytest.raises(ConvergenceError, match="iteration diverged"):
        mixing.next(np.ones(2), np.array([2.0, -1e200]))


@pytest.mark.parametrize(("error", "iterations"), [(1.0, STUCK + 2), (1.1, ASTRAY + 1)])
def test_an_iteration_that_comes_no_nearer_is_given_up(
    monkeypatch: pytest.MonkeyPatch, error: float, iterations: int
):
    """Sooner where more is out of balance than presses."""
    monkeypatch.setattr(newton, "relative_error", lambda *_: error)
    with pytest.raises(ConvergenceError, match=f"after {iterations} iterations"):
        pressed_to(cube(material_of(Elastic(40.0, 0.3)), 1), 0.2)


def test_large_errors_that_fall_are_not_stagnant():
    falling = [np.inf, *(5e5 / 1.8**k for k in range(40))]
    assert not any(stagnant(falling[: k + 1], STUCK) for k in range(len(falling)))
    level = [np.inf, 1e-3, *(6 / 1.05**k for k in range(30))]
    ends = [k for k in range(len(level)) if stagnant(level[: k + 1], STUCK)]
    assert ends[0] == ASTRAY + 1


def test_a_step_that_takes_more_than_its_allowance_is_given_up_with_all_its_parts():
    """It was split again and again, each time at the price of a whole search and descent."""
    pressed = cube(material_of(Elastic(40.0, 0.5)), 1)
    solver, seen = pressed.equilibrium, []
    path = LoadPath("depth", np.arange(4.0), lambda t: (0.0, 0.1, 0.2, 1.2)[int(np.ceil(t))])
    history = StressHistory(pressed.body, SERIES)

    def keep(number: int, _: State) -> None:
        seen.append((number, solver.factors))

    with pytest.raises(ConvergenceError, match=r"within the limit of [0-9]+ factorizations"):
        follow(solver, history, path, keep, allowance=FactorizationBudget(2.0, 5.0))
    assert [number for number, _ in seen] == [0, 1, 2]
    assert solver.factors - seen[-1][1] <= 2 + 5


def test_what_a_step_spends_beyond_the_usual_is_gone_for_all_later_ones():
    allowance = FactorizationBudget(4.0, 60.0)
    assert allowance.after(3) == allowance
    assert allowance.after(14).after(4) == FactorizationBudget(4.0, 50.0)
    assert FactorizationBudget().after(1000) == FactorizationBudget()


def test_a_factor_with_which_the_error_no_longer_falls_is_renewed_before_patience_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pressed = cube(material_of(Elastic(40.0, 0.49)))
    solver, count = pressed.equilibrium, pressed.body.space.n_unknowns
    factored = solver._factored
    uneven = np.exp(0.5 * np.random.default_rng(0).standard_normal(count))
    solve = factored.solve
    monkeypatch.setattr(factored, "solve", lambda right: (solve(right).T * uneven).T)
    solver.find(at_rest(pressed), Target("depth", 0.1, pressed.body.at_rest))
    assert solver.factors == 1
    assert solver.iterations < newton.PATIENCE
    # The new factor does not answer for the iterations before it.
    assert solver._excess < (solver.iterations - 1 - newton.FEW) ** 2 / 2


def test_a_search_that_takes_many_factors_is_left_for_the_way_downhill(
    monkeypatch: pytest.MonkeyPatch,
):
    """Where a pad buckles it took 34 factors, all in vain."""
    spent = []

    def seen(self: Equilibrium, start: State, target: Target) -> State:
        spent.append(self.factors)
        raise ConvergenceError

    monkeypatch.setattr(Equilibrium, "_globalized", seen)
    monkeypatch.setattr(Equilibrium, "_folds_too_stiff", lambda *_: True)
    monkeypatch.setattr(newton, "relative_error", lambda *_: 1.0)
    monkeypatch.setattr(newton, "SOON", 1)
    with pytest.raises(ConvergenceError):
        squeezed(material_of(Elastic(40.0, 0.3)), [0.2])
    assert spent == [newton.SEARCH + 1]


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("poisson", [0.3, 0.5])
def test_the_way_downhill_ends_in_the_closed_form(
    monkeypatch: pytest.MonkeyPatch, name: str, poisson: float
):
    search = Equilibrium._search

    def fails(self: Equilibrium, start: State, target: Target, *, consistent: bool = True) -> State:
        if consistent:
            raise ConvergenceError
        return search(self, start, target, consistent=consistent)

    monkeypatch.setattr(Equilibrium, "_search", fails)
    material = LAWS[name](Elastic(40.0, poisson))
    force, _, _ = squeezed(material, [0.2, 0.4])
    assert force == pytest.approx(nominal(material, 0.6), rel=1e-5)


def test_an_iterate_whose_forces_have_run_away_is_none_like_one_that_is_inside_out():
    pressed = cube(material_of(Elastic(40.0, 0.49), "demiray", exponent=1e3))
    solver, space = pressed.equilibrium, pressed.body.space
    height = space.node_points[:, 2]
    target, flat = Target("depth", 0.1, pressed.body.at_rest), np.zeros(len(solver.contact))
    looks = {}
    for part in (0.01, 0.5):
        values = np.zeros(space.n_unknowns)
        values[2 : space.n_displacements : 3] = -part * height
        looks[part] = solver._evaluate(State(values, flat, 0.0), target)
    assert looks[0.01] is not None
    assert looks[0.5] is None


def test_a_bed_under_the_weighted_gaps_is_that_of_the_matrix_and_takes_its_eigenvalues():
    pressed = cube(material_of(Elastic(40.0, 0.49)))
    solver, space = pressed.equilibrium, pressed.body.space
    target, state = pressed_to(pressed, 0.1, 0.3, 0.5)
    tangent = pressed.body.tangent(state.values, target.history)
    loads = solver.contact.at(state).loads
    support = np.full(len(solver.contact), 1e3)
    stiff = (tangent + loads @ sparse.diags(support / solver.contact.projected) @ loads.T).tocsr()
    none = np.zeros_like(support)
    alone, whole = (
        FactoredTangent(
            solver._factor_approximately(matrix), solver.system.free, loads, 1.0, none, none
        )
        for matrix in (tangent, stiff)
    )
    taken = alone.add_support(support, solver.contact.projected)
    assert taken > 0
    assert alone.approximate_factor.negative - taken == whole.approximate_factor.negative
    right = np.random.default_rng(0).normal(size=space.n_unknowns)
    exact = whole.solve(right)
    assert np.abs(alone.solve(right) - exact).max() < 1e-3 * np.abs(exact).max()
    near = np.ones(len(support), dtype=bool)
    flexible = [each.contact(near).flexibility for each in (alone, whole)]
    assert np.abs(flexible[0] - flexible[1]).max() < 1e-3 * np.abs(flexible[1]).max()


def test_a_blend_takes_as_much_of_the_definite_tangent_as_stability_asks():
    pressed = cube(material_of(Elastic(40.0, 0.49)))
    solver = pressed.equilibrium
    state, shares = at_rest(pressed), []
    for depth in (0.1, 0.3, 0.5):
        target = Target("depth", depth, pressed.body.at_rest)
        state = solver.find(state, target)
        shares.append(solver._blend(solver._evaluate(state, target), target, LEAST))
    assert shares[0] == LEAST
    assert LEAST < shares[2] <= 1
    by_force = replace(target, control="force")
    assert solver._blend(solver._evaluate(state, by_force), by_force, 1.0) == 1


def test_no_node_goes_farther_downhill_in_an_iteration_than_it_is_trusted():
    pressed = cube(material_of(Elastic(40.0, 0.3)))
    solver, space = pressed.equilibrium, pressed.body.space
    start = at_rest(pressed)
    far = State(np.full(space.n_unknowns, 10.0), np.ones(len(solver.contact)), 0.4)
    found = solver._trusted(start, far)
    part = TRUST * solver.contact.sizes.mean() / (10 * np.sqrt(3))
    np.testing.assert_allclose(found.values, part * far.values)
    np.testing.assert_allclose(found.pressure, part * far.pressure)
    assert solver._trusted(start, found) is found

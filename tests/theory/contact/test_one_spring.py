"""One spring of Fung's kind: loading, retreat and re-contact against independent solutions."""

import numpy as np
import pytest

from fefinger.scene import pawluk1997
from fefinger.support.arrays import Array
from fefinger.theory.contact.one_spring import ElasticForce, RelaxingSpring, relax
from fefinger.theory.contact.ting import radius_nodes
from fefinger.theory.relaxation import Prony, creep_integral, hereditary_integral


PRONY = pawluk1997.relaxation()["a.h."]
ELASTIC = Prony((1.0,), ())
NODES = radius_nodes(2.0, 128)
LAWS = {
    "linear": NODES,
    "Hertz": NODES**1.5,
    "exponential": np.expm1(2.1 * NODES) / 2.1,
}


def relaxed(prony: Prony, time: Array, values: Array) -> Array:
    """Hereditary integral with a G whose long-time value is 1."""
    return hereditary_integral(prony, time, values) / prony.long_time


def ramp(time: Array, speed: float = 2.0, depth: float = 1.5) -> Array:
    return np.minimum(speed * time, depth)


@pytest.fixture(params=LAWS)
def elastic(request: pytest.FixtureRequest) -> ElasticForce:
    return ElasticForce(NODES, LAWS[request.param])


def test_on_loading_and_hold_any_value_is_the_hereditary_integral_of_its_elastic_one(
    elastic: ElasticForce,
) -> None:
    time = np.concatenate([np.linspace(0, 0.75, 301), np.geomspace(0.76, 20, 50)])
    depth = ramp(time)
    press = relax(elastic, PRONY, time, depth, "depth")
    values = np.cos(3 * NODES) - 1
    expected = relaxed(PRONY, time, np.interp(depth, NODES, values))
    assert np.allclose(press.stress @ values, expected, rtol=0, atol=1e-12)
    force = relaxed(PRONY, time, np.interp(depth, NODES, elastic.force))
    assert np.allclose(press.force, force, rtol=1e-11, atol=1e-12)
    assert np.allclose(press.strain @ NODES, depth, atol=1e-12)
    assert np.allclose(press.edge, depth, atol=1e-12)


def test_without_relaxation_retreat_goes_back_along_the_elastic_curve(
    elastic: ElasticForce,
) -> None:
    time = np.linspace(0, 1, 101)
    depth = 1.5 * np.sin(np.pi * time)
    press = relax(elastic, ELASTIC, time, depth, "depth")
    expected = np.interp(depth, NODES, elastic.force)
    assert np.allclose(press.force, expected, rtol=0, atol=1e-12)
    assert np.allclose(press.edge, depth, atol=1e-9)


def test_a_prescribed_force_gives_the_depth_that_gives_this_force(elastic: ElasticForce) -> None:
    time = np.linspace(0, 3, 601)
    depth = 0.9 - 0.5 * np.cos(2 * np.pi * time) - 0.4 * np.exp(-20 * time)
    by_depth = relax(elastic, PRONY, time, depth, "depth")
    by_force = relax(elastic, PRONY, time, by_depth.force, "force")
    in_contact = by_depth.force > 0
    assert in_contact.mean() > 0.5
    assert np.allclose(by_force.depth[in_contact], depth[in_contact], rtol=0, atol=1e-8)


def test_without_a_prescribed_force_nothing_touches_while_the_body_recovers(
    elastic: ElasticForce,
) -> None:
    time = np.concatenate([np.linspace(0, 0.2, 101), np.geomspace(0.201, 5, 60)])
    force = np.interp(time, [0.0, 0.1, 0.2], [0.0, 0.5, 0.0])
    press = relax(elastic, PRONY, time, force, "force")
    assert np.array_equal(press.force, force), "to the last digit"
    rest = time >= 0.2
    assert (press.edge[rest] == 0).all()
    assert (press.stress[rest] == 0).all()
    assert (press.edge[~rest][1:] > 0).all()
    assert (np.diff(press.depth[rest]) <= 1e-12).all()
    assert press.depth[rest][0] > 0


def test_after_lift_off_a_linear_body_recovers_by_its_creep_function() -> None:
    elastic = ElasticForce(NODES, LAWS["linear"])
    time = np.concatenate([np.linspace(0, 1, 2001), np.linspace(1.0, 5.0, 4001)[1:]])
    depth = np.where(time <= 1, ramp(time), 0.0)
    depth[time > 1] = np.maximum(1.5 - 50 * (time[time > 1] - 1), 0.0)
    press = relax(elastic, PRONY, time, depth, "depth")
    assert press.force.min() == 0.0
    # The force is known; the strain of a linear body is its creep integral, in contact and after.
    expected = creep_integral(PRONY, time, press.force) * PRONY.long_time
    after = time > 1.1
    body = press.strain @ NODES
    assert np.abs(body - expected)[after].max() < 2e-3 * 1.5
    assert (np.diff(body[after]) <= 1e-12).all()
    assert 0.01 < body[-1] < 0.3 * body[after][0]


def test_contact_ends_where_the_force_would_pull_and_never_pulls(elastic: ElasticForce) -> None:
    time = np.linspace(0, 2, 2001)
    depth = 0.7 - 0.7 * np.cos(2 * np.pi * 2 * time)
    press = relax(elastic, PRONY, time, depth, "depth")
    assert press.force.min() == 0.0
    free = press.force == 0
    assert (press.stress[free] == 0).all()
    assert (press.strain @ NODES)[free].min() >= -1e-12
    assert ((press.strain @ NODES)[free] >= depth[free] - 1e-12).all()
    assert (press.edge[free] == 0).all()
    assert (press.edge <= press.strain @ NODES + 1e-12).all()


def test_a_step_is_of_second_order_in_its_length() -> None:
    elastic = ElasticForce(NODES, LAWS["exponential"])

    def last(count: int) -> float:
        time = np.linspace(0, 0.3, count + 1)
        return float(relax(elastic, PRONY, time, 1.5 * np.sin(5 * time), "depth").force[-1])

    exact = last(12_800)
    errors = [abs(last(count) - exact) for count in (100, 200, 400)]
    # Nodes make the force piecewise linear in the depth, which leaves an error of its own.
    assert errors[0] < 5e-4 * exact
    assert errors[2] < 0.35 * errors[1] < 0.35 * 0.35 * errors[0] * 1.4


def test_a_reset_spring_has_no_memory() -> None:
    spring = RelaxingSpring(ElasticForce(NODES, LAWS["Hertz"]), PRONY)
    for _ in range(2):
        spring.advance(0.1, 0.8)
        spring.advance(0.5, 0.3)
        first = spring.force, spring.body, spring.edge
        spring.reset()
    spring.advance(0.1, 0.8)
    spring.advance(0.5, 0.3)
    assert (spring.force, spring.body, spring.edge) == first


@pytest.mark.parametrize(
    ("nodes", "force", "field"),
    [
        (np.array([0.1, 1.0]), np.array([0.0, 1.0]), "nodes"),
        (np.array([0.0, 1.0, 0.5]), np.array([0.0, 1.0, 2.0]), "nodes"),
        (np.array([0.0, 1.0]), np.array([0.0, 0.0]), "force"),
        (np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 0.5]), "force"),
        (np.array([0.0, 1.0]), np.array([0.0, 1.0, 2.0]), "force"),
    ],
)
def test_an_elastic_press_that_does_not_rise_is_refused(
    nodes: Array, force: Array, field: str
) -> None:
    with pytest.raises(ValueError, match=f"^{field}: expected"):
        ElasticForce(nodes, force)


def test_a_press_whose_first_touch_is_not_resolved_is_carried_all_the_same() -> None:
    force = np.maximum(NODES - 0.05, 0.0)
    time = np.linspace(0, 1, 201)
    press = relax(ElasticForce(NODES, force), ELASTIC, time, 1.2 * np.sin(3 * time), "depth")
    expected = np.interp(1.2 * np.sin(3 * time), NODES, force)
    assert np.allclose(press.force, expected, rtol=0, atol=1e-12)


def test_what_lies_beyond_the_deepest_node_is_refused() -> None:
    elastic = ElasticForce(NODES, LAWS["Hertz"])
    with pytest.raises(ValueError, match="depth: expected at most 2 mm"):
        RelaxingSpring(elastic, PRONY).advance(0.1, 2.5)
    with pytest.raises(
        ValueError, match=r"force: expected at most .*, that of the largest depth, 2 mm"
    ):
        RelaxingSpring(elastic, PRONY).advance_force(0.1, 1e3)


def test_the_largest_depth_holds_for_depths_and_forces_and_a_refusal_moves_nothing() -> None:
    spring = RelaxingSpring(ElasticForce(NODES, LAWS["Hertz"]), PRONY, deepest=0.5)
    spring.advance_force(0.1, 0.3)
    before = spring.depth, spring.force, spring.body
    for advance, value, field in (
        (spring.advance, 0.51, "depth"),
        (spring.advance_force, 20.0, "force"),
    ):
        with pytest.raises(ValueError, match=f"^{field}: expected at most .*0.5 mm"):
            advance(0.1, value)
        assert (spring.depth, spring.force, spring.body) == before
    spring.advance(0.1, 0.5)
    limit = spring.force
    spring.advance_force(0.0, limit)
    assert spring.depth == pytest.approx(0.5)

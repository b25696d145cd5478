"""Chains of springs and dampers against the printed transfer functions and scipy's simulation."""

import numpy as np
import pytest
from fefinger.validation.oracles.chains import (
    Chain,
    Resonant,
    SpringDamper,
    fast_chain,
    realize,
    slow_chain,
    under_force,
)
from scipy import signal

from fefinger.neural.endorgans import END_ORGANS, PoleZero
from fefinger.support.checks import InputError


SLOW = slow_chain(2.0, SpringDamper(0.3, 0.05), 0.7)
FAST = fast_chain(2.0, SpringDamper(0.0, 0.05), SpringDamper(0.9, 0.004), 0.7)
CHAINS = pytest.mark.parametrize("chain", [SLOW, FAST], ids=["slow", "fast"])


def impedances(chain, s):
    return [pair.stiffness + s * pair.damping for pair in chain.organ]


def printed(chain, s):
    """Eq. B.21 and B.27, as printed."""
    k_s, k_n = chain.skin, chain.nerve
    if len(chain.organ) == 1:
        (pair,) = chain.organ
        k_e, b = pair.stiffness, pair.damping
        return k_s * (k_e + s * b) / (s * b * (k_s + k_n) + k_e * k_n + k_s * k_e + k_s * k_n)
    one, two = impedances(chain, s)
    return k_s * two * one / (k_s * (two * (k_n + one) + k_n * one) + k_n * two * one)


def network(chain, parallel=None):
    """State space of the stretches of the pairs: from displacement, or from force, to x_nerve."""
    soft = 1 / chain.skin + 1 / chain.nerve + (1 / parallel if parallel else 0.0)
    b = np.array([1 / pair.damping for pair in chain.organ])
    z = np.array([pair.stiffness / pair.damping for pair in chain.organ])
    k, n = 1 / soft, len(b)
    drive = k / parallel if parallel else k
    a = -np.diag(z) - k * np.outer(b, np.ones(n))
    return a, drive * b[:, None], -k / chain.nerve * np.ones((1, n)), [[drive / chain.nerve]]


def random_chains(count, pairs):
    rng = np.random.default_rng(11)
    for _ in range(count):
        k = 10 ** rng.uniform(-3, 3, 2 + 2 * pairs)
        organ = tuple(SpringDamper(k[2 + 2 * i], k[3 + 2 * i]) for i in range(pairs))
        yield Chain(skin=k[0], organ=organ, nerve=k[1])


@pytest.mark.parametrize("pairs", [1, 2])
def test_filters_of_random_chains_are_the_printed_ones(pairs):
    frequency = np.geomspace(1e-4, 1e4, 9)
    for chain in random_chains(300, pairs):
        response = chain.displacement_filter().frequency_response(frequency)
        np.testing.assert_allclose(response, printed(chain, 2j * np.pi * frequency), rtol=1e-9)


def test_zeros_and_poles_of_random_chains_interlace():
    for chain in random_chains(2000, 2):
        for organ in (chain.displacement_filter(), chain.force_filter(chain.skin)):
            (z1, z2), (p1, p2) = organ.zeros, organ.poles
            assert z1 < p1 < z2 < p2


def test_slow_chain_has_the_closed_forms_of_the_thesis():
    k_e, b, k_s, k_n = 0.3, 0.05, 2.0, 0.7
    organ = SLOW.displacement_filter()
    assert organ.gain == pytest.approx(k_s / (k_s + k_n))
    assert 2 * np.pi * organ.zeros[0] == pytest.approx(k_e / b)
    assert 2 * np.pi * organ.poles[0] == pytest.approx(k_e / b + k_s * k_n / (b * (k_s + k_n)))
    at_rest = k_s * k_e / (k_s * k_e + k_n * (k_s + k_e))
    assert organ.partial_fractions()[0] == pytest.approx(at_rest)


@CHAINS
@pytest.mark.parametrize("parallel", [None, 0.01, 5.0])
def test_response_to_uneven_straight_lines_is_that_of_the_network(chain, parallel):
    """The oracle, lsim, is exact for straight lines too, by matrix exponentials of even steps."""
    time = np.linspace(0, 2, 401)
    knots = np.array([0, 0.05, 0.3, 0.31, 1.0, 1.5, 2.0])
    x = np.interp(time, knots, [0, 1, 1, -0.4, 0.2, 0.2, 0])
    organ = chain.displacement_filter() if parallel is None else chain.force_filter(parallel)
    _, expected, _ = signal.lsim(network(chain, parallel), x, time)
    np.testing.assert_allclose(organ.respond(time, x), expected, atol=1e-11)
    at_knots = np.searchsorted(time, knots - 1e-9)
    response = organ.respond(time[at_knots], x[at_knots], at=time)
    np.testing.assert_allclose(response, expected, atol=1e-11)


@CHAINS
def test_a_parallel_spring_shares_the_force(chain):
    """Force is K_parallel x_in + K_n x_nerve, at any frequency."""
    frequency, parallel = np.geomspace(1e-3, 1e3, 13), 1.7
    share = chain.displacement_filter().frequency_response(frequency)
    expected = share / (parallel + chain.nerve * share)
    response = chain.force_filter(parallel).frequency_response(frequency)
    np.testing.assert_allclose(response, expected, rtol=1e-12)
    alone = under_force(chain.displacement_filter(), nerve=chain.nerve, parallel=parallel)
    np.testing.assert_allclose(alone.frequency_response(frequency), expected, rtol=1e-9)


@CHAINS
def test_without_a_parallel_spring_every_chain_answers_a_force_as_the_bare_nerve(chain):
    bare = chain.force_filter(0.0)
    np.testing.assert_allclose(bare.respond([0, 1, 1, 3], [0, 0, 2, 2]), [0, 0, 2 / 0.7, 2 / 0.7])
    # exact: one division
    assert under_force(chain.displacement_filter(), nerve=0.7, parallel=0.0) == bare


def test_with_a_parallel_spring_a_constant_force_leaves_the_fast_chain_and_holds_the_slow_one():
    held = [chain.force_filter(0.5).respond([0, 0, 60], [0, 2, 2])[-1] for chain in (SLOW, FAST)]
    slow_at_rest = 2 * 0.3 / (2 * 0.3 + 0.7 * 2.3)
    assert held[0] == pytest.approx(2 * slow_at_rest / (0.5 + 0.7 * slow_at_rest))
    assert held[1] == pytest.approx(0.0, abs=1e-12)


@CHAINS
def test_realizing_a_filter_gives_the_chain_back(chain):
    again = realize(chain.displacement_filter(), nerve=chain.nerve)
    assert again.skin == pytest.approx(chain.skin)
    for pair, wanted in zip(again.organ, chain.organ, strict=True):
        assert pair.damping == pytest.approx(wanted.damping)
        assert pair.stiffness == pytest.approx(wanted.stiffness, abs=1e-14)


@pytest.mark.parametrize("kind", ["SAI", "SAII"])
def test_the_slow_filters_of_the_thesis_are_chains(kind):
    organ = PoleZero(END_ORGANS[kind].zeros, END_ORGANS[kind].poles, 0.8)
    again = realize(organ).displacement_filter()
    np.testing.assert_allclose(
        [*again.zeros, *again.poles, again.gain], [*organ.zeros, *organ.poles, 0.8]
    )


@pytest.mark.parametrize(
    ("organ", "message"),
    [
        (PoleZero((0.0, 0.0), (1.0, 10.0), 0.5), "interlace"),
        (PoleZero((0.0, 0.5), (1.0, 10.0), 0.5), "interlace"),
        (PoleZero((2.0,), (1.0,), 0.5), "interlace"),
        (PoleZero((0.1,), (1.0,), 1.0), "organ.gain: expected a finite number above 0 and below 1"),
    ],
)
def test_filters_that_no_chain_has_are_refused(organ, message):
    with pytest.raises(InputError, match=message):
        realize(organ)


def test_pairs_with_one_corner_act_as_one():
    two = fast_chain(2.0, SpringDamper(0.0, 0.1), SpringDamper(0.0, 0.1), 0.7)
    one = slow_chain(2.0, SpringDamper(0.0, 0.05), 0.7).displacement_filter()
    for part in ("zeros", "poles", "gain"):
        expected = pytest.approx(getattr(one, part), rel=1e-12)
        assert getattr(two.displacement_filter(), part) == expected
    assert len(one.poles) == 1


def test_a_strong_nerve_makes_the_poles_of_the_fast_filter_complex():
    """FAI as a filter: 121 K_p = 40 (K_p + K_n) separates real from complex poles."""
    real = under_force(END_ORGANS["FAI"], nerve=2.02, parallel=1.0)
    assert isinstance(real, PoleZero)
    organ = under_force(END_ORGANS["FAI"], nerve=3.0, parallel=1.0)
    assert isinstance(organ, Resonant)
    frequency = np.geomspace(0.01, 100, 9)
    share = END_ORGANS["FAI"].frequency_response(frequency)
    np.testing.assert_allclose(organ.frequency_response(frequency), share / (1 + 3 * share))
    time = np.linspace(0, 1, 301)
    x = np.interp(time, [0, 0.1, 0.5, 1.0], [0, 1, -1, 0.5])
    s = 2 * np.pi
    system = ([1, 0, 0], [4, 11 * s, 10 * s**2])
    _, expected, _ = signal.lsim(system, x, time)
    np.testing.assert_allclose(organ.respond(time, x), expected, atol=1e-11)
    np.testing.assert_allclose(organ.respond(time[::30], x[::30], at=time), expected, atol=1e-11)


def test_poles_that_coincide_are_refused():
    with pytest.raises(InputError, match="two poles coincide"):
        under_force(END_ORGANS["FAI"], nerve=81 / 40, parallel=1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SpringDamper(1.0, 0.0), "damping: expected a finite number in mN s/mm above 0"),
        (lambda: SpringDamper(-1.0, 1.0), "stiffness: expected"),
        (lambda: slow_chain(0.0, SpringDamper(1.0, 1.0), 1.0), "skin: expected"),
        (lambda: SLOW.force_filter(-1.0), "parallel: expected"),
    ],
)
def test_impossible_parts_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()

"""Least squares with priors and bounds, against closed forms."""

import numpy as np
import pytest

from fefinger.calibration import inverse, record
from fefinger.support.checks import ConvergenceError


def unknown(name, **options):
    return inverse.Unknown(name, 1.0, 0.1, 10.0, "1", "test", **options)


def test_a_linear_problem_has_its_closed_form():
    rng = np.random.default_rng(0)
    design, sigma = rng.normal(size=(200, 2)), 0.1
    data = design @ [2.0, 3.0] + sigma * rng.normal(size=200)
    asked = [unknown("p", log=False), unknown("q", log=False)]
    found = inverse.solve(lambda v: (design @ [v["p"], v["q"]] - data) / sigma, asked)
    best, *_ = np.linalg.lstsq(design, data, rcond=None)
    np.testing.assert_allclose([found.values["p"], found.values["q"]], best, rtol=1e-6)
    scale = max(1.0, found.misfit)
    covariance = scale * sigma**2 * np.linalg.inv(design.T @ design)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-6)
    assert found.weak == ()
    assert found.at_bounds == ()


def test_what_the_data_do_not_decide_is_named_and_keeps_its_prior():
    asked = [unknown("p", prior=(1.0, 0.7)), unknown("q", prior=(1.0, 0.7))]
    found = inverse.solve(lambda v: np.full(5, (np.log(v["p"] * v["q"]) - 1.0) / 0.01), asked)
    assert found.values["p"] * found.values["q"] == pytest.approx(np.e, rel=1e-3)
    assert found.covariance[0, 1] < -0.99 * found.covariance[0, 0]
    assert found.deviations["p"] == pytest.approx(found.values["p"] * 0.7 / np.sqrt(2), rel=0.01)
    assert len(found.weak) == 1
    assert found.weak[0].startswith(("p with q^-1", "p^-1 with q"))


def test_what_is_held_stays_and_adds_to_the_uncertainty():
    def residual(v):
        return np.array([v["p"] + v["q"] - 3.0, v["p"] + v["q"] - 3.0]) / 0.01

    free = unknown("p", log=False)
    held = unknown("q", log=False, prior=(1.0, 0.5), held=True)
    found = inverse.solve(residual, [free, held])
    assert found.values["q"] == 1.0
    assert found.values["p"] == pytest.approx(2.0)
    assert found.deviations["p"] == pytest.approx(0.5, rel=0.01)


def test_what_is_held_keeps_its_prior_although_the_data_would_move_it():
    """By draws: the fitted number errs by what was held wrongly, which these data could tell."""

    def fit(measured):
        free = unknown("p", log=False)
        held = unknown("q", log=False, prior=(1.0, 0.5), held=True)
        return inverse.solve(
            lambda v: (np.array([v["p"] + v["q"], v["p"] + 1.2 * v["q"]]) - measured) / 0.02,
            [free, held],
        )

    rng = np.random.default_rng(0)
    off = []
    for q in rng.normal(1.0, 0.5, 300):
        found = fit(np.array([2.0 + q, 2.0 + 1.2 * q]) + 0.02 * rng.normal(size=2))
        off.append(found.values["p"] - 2.0)
    found = fit(np.array([3.0, 3.2]))
    assert found.deviations["q"] == pytest.approx(0.5)
    assert found.deviations["p"] == pytest.approx(np.std(off), rel=0.15)


def test_a_systematic_error_adds_to_deviations_and_covariance():
    asked = [unknown("p"), unknown("q", log=False)]
    found = inverse.solve(lambda v: np.array([np.log(v["p"] / 2), v["q"] - 3]) / 0.03, asked)
    wider = found.widened({"p": 0.04, "q": 0.4})
    assert wider.deviations["p"] == pytest.approx(2 * 0.05, rel=1e-3)
    assert wider.deviations["q"] == pytest.approx(np.hypot(0.03, 0.4), rel=1e-3)
    np.testing.assert_allclose(np.diag(wider.covariance), [0.05**2, 0.03**2 + 0.4**2], rtol=1e-3)


def test_a_bound_that_stops_the_search_is_named():
    found = inverse.solve(lambda v: np.array([v["p"] - 20.0, 0.1]), [unknown("p")])
    assert found.at_bounds == ("p",)


def test_a_search_that_fails_says_so(monkeypatch):
    monkeypatch.setattr(inverse, "EVALUATIONS", 1)
    monkeypatch.setattr(inverse, "LONGER", 1)
    asked = [unknown("p"), unknown("q", prior=(1.0, 0.1))]
    with pytest.raises(
        ConvergenceError,
        match=r"within 1 evaluations, it did not from any of 1 .*; not identified: q: a",
    ):
        inverse.solve(lambda v: np.array([np.exp(v["p"]) - 3.0]), asked)


def test_a_search_that_creeps_along_a_flat_valley_goes_on(monkeypatch):
    monkeypatch.setattr(inverse, "EVALUATIONS", 1)
    found = inverse.solve(lambda v: np.array([np.exp(v["p"]) - 3.0]), [unknown("p")])
    assert found.values["p"] == pytest.approx(np.log(3.0), rel=1e-3)


def test_correlations_are_those_of_the_parameters_in_their_order():
    """By 4000 draws of what was searched for; the weights of G stand after all others."""
    asked = [
        unknown("t_b"),
        *(unknown(f"c{i}/c0", prior=(1.0, 0.5)) for i in (1, 2)),
        unknown("v1", prior=(1.0, 0.3)),
    ]
    way = np.array([[1.0, 0.5, 0.0, 0.0], [0.0, 1.0, -1.0, 0.5]]) / 0.02
    names = [each.name for each in asked]
    found = inverse.solve(lambda v: way @ [np.log(v[name]) for name in names], asked)
    draws = np.random.default_rng(0).multivariate_normal(np.zeros(4), found.covariance, 4000).T
    rows = dict(zip(names, 1e-3 * draws, strict=True))
    shares = np.array(
        [np.ones(4000), *(found.values[c] * np.exp(rows[c]) for c in ("c1/c0", "c2/c0"))]
    )
    rows |= dict(zip(("c0", "c1", "c2"), shares / shares.sum(axis=0), strict=True))
    parameters, correlations = record.parameters_of(found)
    expected = np.corrcoef([rows[each.name] for each in parameters])
    np.testing.assert_allclose(correlations, expected, atol=0.05)

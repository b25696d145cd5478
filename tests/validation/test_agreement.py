"""Stated intervals of mechanics that answer one scene: when they overlap, and how often they do."""

import pytest
from fefinger.validation.evidence import agreement

from fefinger.mechanics.evidence.presses import read


def test_an_interval_holds_the_true_values_of_which_an_answer_errs_by_as_much():
    low, high = agreement.interval(2.0, 0.25)
    assert abs(2.0 - low) / low == pytest.approx(0.25)
    assert abs(2.0 - high) / high == pytest.approx(0.25)
    assert agreement.interval(1.0, 1.2) == (pytest.approx(1 / 2.2), float("inf"))


@pytest.mark.parametrize(("error", "off"), [(0.4, {}), (0.2, {"force": ["hertz, linear"]})])
def test_values_a_half_apart_agree_within_errors_that_reach(error, off):
    answered = {"hertz": {"force": 1.0, "area": 9.0}, "linear": {"force": 1.6, "area": 1.0}}
    errors = {"hertz": {"force": error}, "linear": {"force": 0.05, "area": 0.1}}
    pairs, found = agreement.apart(answered, errors)
    assert (dict(pairs), found) == ({"force": 1}, off)


def test_95_of_100_pairs_of_every_quantity_agree_in_scenes_drawn_after_the_rule():
    report = read(agreement.REPORT)
    assert list(report["scenes"]) == list(agreement.drawn())
    for what, (pairs, beyond) in report["pairs"].items():
        found = sum(len(row["apart"].get(what, ())) for row in report["scenes"].values())
        assert found == beyond
        assert beyond <= 0.05 * pairs, what

"""Stated errors of closed formulas: by the forces of the presses in reports/formula-force.json."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from fefinger.mechanics import get
from fefinger.mechanics.evidence import formulas
from fefinger.mechanics.evidence.table import FORMULAS, Measured
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Bar, Flat, Sphere
from fefinger.scene.motions import ForceRampHold, Ramp, Sampled, Sinusoid
from fefinger.scene.scene import Scene
from fefinger.support.package_data import report
from fefinger.theory.relaxation import Prony


ROWS = json.loads(report(FORMULAS))["rows"]

FORCE = Ask(pressure=False, strain=False, fields=False)

RELAXED = Prony((1.0,), ())


def case(indenter, part, subject="a.h.", tissue=None, prony=None, motion=None) -> Situation:
    finger = Finger.subject(subject, tissue=tissue)
    finger = replace(finger, prony=prony or finger.prony)
    motion = motion or Ramp(60.0, part * finger.thickness, corner=0.0)
    return Situation.of(Scene(finger=finger, indenter=indenter, motion=motion, ask=FORCE))


@pytest.mark.parametrize("name", ["hertz", "layered"])
@pytest.mark.parametrize(
    ("label", "indenter"),
    [("calibrated, a.h., sphere-5", Sphere(5)), ("maeno1998, a.h., flat-15", Flat(15))],
)
def test_the_ratios_are_those_of_the_answer_to_the_press(name, label, indenter) -> None:
    row = ROWS[label]
    tissue = "maeno1998" if label.startswith("maeno") else None
    depth, force = np.array(row["depth_mm"]), np.array(row["force_N"])
    asked = case(indenter, depth[-1] / row["thickness_mm"], tissue=tissue, prony=RELAXED)
    response = get(name).respond(
        Scene(finger=asked.finger, indenter=indenter, motion=asked.motion, ask=FORCE)
    )
    ratio = np.interp(depth, response.depth, response.force) / force
    np.testing.assert_allclose(np.log(ratio), row["log_ratio"][name], atol=2e-3)


@pytest.mark.parametrize("name", ["hertz", "layered"])
def test_of_tissue_that_does_not_relax_a_press_has_its_own_largest_difference(name) -> None:
    row = ROWS["calibrated, a.h., sphere-5"]
    force, ratio = np.array(row["force_N"]), np.exp(row["log_ratio"][name])
    part = row["depth_mm"][8] / row["thickness_mm"]
    largest = np.abs(force * (ratio - 1))[:9].max() / force[8]
    found = formulas.error(Candidate(name), case(Sphere(5), part, prony=RELAXED))
    margin = np.expm1(0.05)  # of the mesh alone: an object that was pressed, no relaxation
    assert 0.99 * largest < found.error < largest + margin * max(1.0, ratio[8])


@pytest.mark.parametrize("subject", ["d.s.", "d.p.", "p.w."])
def test_a_ball_between_presses_of_another_finger_has_the_error_of_its_press(subject) -> None:
    """The press by the ball of 10 mm is left out: the finger differs there as at 0 and at 0.2."""
    candidate, missed = Candidate("layered"), []
    main = formulas.row_of(candidate, "calibrated", "a.h.", "curvature")
    own = formulas.row_of(candidate, "calibrated", subject, "curvature")
    at = int(np.flatnonzero(np.isclose(own.places, 0.1))[0])
    left = formulas.Row(np.delete(own.places, at), own.presses[:at] + own.presses[at + 1 :])
    for part, value in zip(own.presses[at].part, own.presses[at].values, strict=True):
        missed.append(abs(value - formulas.log_ratio(main, left, 0.1, float(part))))
    assert max(missed) < 0.1


def test_on_retreat_the_error_of_carrying_is_added_to_the_largest_force() -> None:
    there = 0.8
    loading = formulas.error(
        Candidate("layered"), case(Sphere(5), 0.08, motion=Ramp(10.0, there, corner=0.0))
    )
    waving = formulas.error(
        Candidate("layered"), case(Sphere(5), 0.08, motion=Sinusoid(there / 2, 2.0, 2))
    )
    assert waving.error > loading.error


@pytest.mark.parametrize("name", ["hertz", "layered"])
def test_many_times_are_thinned_out_without_another_error(name, monkeypatch) -> None:
    """Shallow cycles, and a deep one late: at all of its times and at a thousand."""
    time = np.linspace(0.0, 40.0, 4001)
    depth = (0.1 + 0.7 * (time > 20.0) * (time < 30.0)) * np.sin(np.pi * time / 10.0) ** 2
    motion = Sampled(tuple(time.tolist()), tuple(depth.tolist()))
    asked = case(Sphere(5), 0.08, motion=motion)
    assert len(asked.times) > 3 * formulas.MANY
    thinned = formulas.error(Candidate(name), asked).error
    monkeypatch.setattr(formulas, "MANY", len(asked.times))
    assert thinned == pytest.approx(formulas.error(Candidate(name), asked).error, rel=0.02)


def test_under_a_force_it_is_that_at_the_depth_that_the_force_reaches() -> None:
    row = ROWS["calibrated, a.h., flat-30"]
    force = row["force_N"][5]
    found = formulas.error(
        Candidate("layered"), case(Flat(30), 0.1, motion=ForceRampHold(1.0, force, hold=20.0))
    )
    known = abs(math.expm1(row["log_ratio"]["layered"][5]))
    assert found.error == pytest.approx(known, abs=0.06)


@pytest.mark.parametrize(
    "asked",
    [
        case(Bar(2.0, corner=1.0), 0.05),
        case(Flat(30, tilt=10.0), 0.05),
        case(Sphere(5, at=(0.0, 4.0)), 0.05),
        case(Sphere(1.5), 0.05),
        case(Flat(30), 0.45),
        case(Flat(30), 0.05, tissue="saal2017"),
    ],
)
def test_what_was_not_pressed_has_no_such_error(asked) -> None:
    assert formulas.error(Candidate("hertz"), asked) is None


def test_between_presses_the_margin_is_that_of_a_curve_of_constant_curvature() -> None:
    """Of a parabola the bound of a linear interpolation is its own error, and CURVED times that."""
    places = np.array([0.0, 10.0, 30.0, 40.0])
    presses = tuple(
        Measured(
            "", Candidate("hertz"), "", "", np.full(2, 3.0 * at**2), np.ones(2), {"thickness_mm": 1}
        )
        for at in places
    )
    row = formulas.Row(places, presses)
    for here in (4.0, 17.0, 38.0):
        missed = abs(formulas.log_ratio(row, None, here, 1.0) - 3.0 * here**2)
        assert formulas._between(row, here, 1.0) == pytest.approx(formulas.CURVED * missed)
    assert formulas._between(row, 30.0, 1.0) == 0.0
    assert formulas._between(formulas.Row(places[:2], presses[:2]), 4.0, 1.0) == math.inf

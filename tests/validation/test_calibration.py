"""The suite `calibration`: what is shipped is what the report holds, and its figures can be drawn.

The twins are measured by `fefinger validate calibration`, which takes longer than a test may.
"""

from dataclasses import asdict, replace

import numpy as np
import pytest
from fefinger.validation.calibration import (
    coverage_page,
    report,
    sensitivity,
    sensitivity_figures,
    subjects,
    suite,
    tip_shape,
)
from fefinger.validation.calibration import split as calibration_split
from fefinger.validation.calibration.report import calibrated, rows
from fefinger.validation.calibration.subject_target import target_of

from fefinger.calibration import pad_radius
from fefinger.calibration.outcome import line, stiffening
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.view import figures


SUBJECTS = ("a.h.", "d.s.", "d.p.", "p.w.")


def test_the_report_has_all_subjects_that_are_shipped():
    assert tuple(rows()) == SUBJECTS
    elastic = [name for name in library.TISSUE_SETS if not name.endswith(library.VISCOUS)]
    shipped = [name for name in elastic if name.startswith("calibrated_")]
    fitted = (*SUBJECTS, library.MEANS)  # the means have a report of their own
    assert sorted(map(library.calibrated_name, fitted)) == sorted(shipped)


@pytest.mark.parametrize("subject", SUBJECTS)
def test_a_shipped_set_is_what_was_calibrated_and_says_so(subject):
    assert subjects.shipped(subject) < 5e-3
    kept = library.tissue_set(library.calibrated_name(subject))
    assert "not a measurement" in kept.source
    assert kept.confidence == "low"
    finger = Finger.subject(subject, tissue=library.calibrated_name(subject))
    assert finger.prony == kept.prony
    assert finger.pad_radius == kept.pad_radius
    assert finger.skin.law == finger.subcutaneous.law == "demiray"
    assert finger.skin.thickness == 1.0
    source = library.tissue_set(library.calibrated_name(subject)).source
    assert f"on the {calibrated(subject).finger['resolution']} mesh" in source


@pytest.mark.parametrize("subject", SUBJECTS)
def test_the_parts_of_the_stiffening_add_up_to_table_2_1(subject):
    split = rows()[subject]["split"]
    total = sum(split[part] for part in calibration_split.PARTS)
    assert total == pytest.approx(library.lumped()[subject].m)
    assert sum(split["shares"].values()) == pytest.approx(1.0)
    found = calibrated(subject)
    own = calibration_split.steepness(found.curve.force, split["depth"])
    assert own == pytest.approx(total - split["rest"], rel=1e-6)


def test_steepness_of_an_exponential_is_its_exponent_at_any_scale():
    for scale in (1.0, 7.0):
        found = calibration_split.steepness(lambda x, s=scale: s * np.expm1(2.1 * x), 1.5)
        assert found == pytest.approx(2.1, rel=1e-3)


def test_the_figures_of_the_quick_cases_are_drawn():
    names = [case.name for case in suite.cases(quick=True)]
    assert sum(name.startswith("twin") for name in names) == 2
    for caption, drawn in suite.figures():
        assert caption.endswith(".")
        assert "<svg" in figures.svg(drawn)


@pytest.mark.parametrize("subject", SUBJECTS)
def test_table_3_2_comes_back_from_its_own_frames(subject):
    row = library.quasistatic()[subject]
    found = pad_radius.thesis_fit(sensitivity.half_space(subject))
    assert (found.radius, found.m, found.c0_b) == pytest.approx((row.radius, row.m, row.b), 1e-3)


def test_frames_of_a_contact_of_hertz_carry_its_force_and_have_its_radius():
    depth = np.linspace(0.0, 1.5, 41)
    force = 0.4 * depth**2.1
    frames = sensitivity.hertzian(13.0, depth, force)
    assert 4e-3 * frames.pressure[-1].sum() == pytest.approx(force[-1], rel=0.01)
    assert pad_radius.thesis_fit(frames).radius == pytest.approx(13.0, rel=0.01)


def test_the_scatter_of_a_line_is_that_of_many_lines():
    wanted = target_of("a.h.")
    rng = np.random.default_rng(3)
    noise = wanted.stiffness_sd * rng.normal(size=(4000, len(wanted.force)))
    lines = [line(wanted.force, wanted.stiffness + each) for each in noise]
    found = subjects.line_sd(wanted)
    assert found == pytest.approx(tuple(np.std(lines, axis=0)), rel=0.05)


@pytest.mark.parametrize("subject", SUBJECTS)
def test_a_finger_bears_the_force_of_its_subject_once_touch_is_not_that_of_an_exponential(subject):
    before, force_off, stiffness = subjects.touched(subject)
    assert -0.02 < before < 0.25
    assert force_off < 0.02
    assert abs(stiffness - 1) < 0.15 or subject == "p.w."
    wanted = target_of(subject)
    assert wanted.stiffness_sd > 0.7 * wanted.spring.stiffness(0.05)  # what the source leaves


def test_the_steps_to_a_round_tip_end_at_the_shipped_finger():
    last = [each for _, each in tip_shape.steps()][-1]
    shipped = Finger.subject("a.h.")
    for name in ("pad_radius", "tip_tissue", "tip_radius", "width", "thickness"):
        assert getattr(last, name) == getattr(shipped, name)
    ratio = last.skin.modulus / last.subcutaneous.modulus
    assert ratio == pytest.approx(shipped.skin.modulus / shipped.subcutaneous.modulus)
    stiff = stiffening(last, 3.0)
    assert stiff.skin.exponent / stiff.subcutaneous.exponent == pytest.approx(
        shipped.skin.exponent / shipped.subcutaneous.exponent
    )


@pytest.mark.parametrize("subject", SUBJECTS)
def test_the_figures_of_a_shipped_finger_are_of_its_tissue(subject):
    row, tissues = tip_shape.of_report(subject), Finger.subject(subject)
    pulp = tissues.subcutaneous
    assert (row["modulus"], row["exponent"]) == (pulp.modulus, pulp.exponent)


def test_the_speed_of_surface_waves_is_the_root_of_the_cubic_of_rayleigh():
    # Incompressible: x^3 - 8 x^2 + 24 x - 16 = 0 with x = (Rayleigh / shear speed)^2.
    roots = np.roots([1.0, -8.0, 24.0, -16.0])
    x = float(roots[np.isreal(roots)].real.min())
    assert tip_shape.speed(3.3, 1100.0) == pytest.approx(np.sqrt(x), rel=1e-4)


def test_assumptions_on_the_finger_are_drawn_and_a_table_tells_what_each_would_change(monkeypatch):
    plain = sensitivity.Fitted(
        *("the finger as it is", 10.0, 1.0, 11.0, 0.06, 7.0, 3.6, 2.1, 0.2, 0.01, 1.1, 1.7, 3.0)
    )
    other = replace(plain, lever="nail free (held)", radius=11.0, stiffness_b=0.25)
    unable = replace(plain, lever="skin alone stiffens", misfit=5.0, stiffness_b=1.2)
    rows = [asdict(each) for each in (plain, other, unable)]
    tried = report.sensitivity() | {"finger": rows}
    monkeypatch.setattr(sensitivity_figures, "sensitivity", lambda: tried)
    ((_, drawn),) = sensitivity_figures.figures()
    assert "<svg" in figures.svg(drawn)
    told, sessions = sensitivity_figures.tables()
    assert "b of 0.2 to 0.25 N/mm and R of 10 to 11 mm" in told["caption"]
    assert [row[0] for row in told["rows"]] == [each["lever"] for each in rows]
    assert told["rows"][1][5] == "11 (+10 %)"
    assert {len(row) for row in sessions["rows"]} == {1, len(sessions["heading"])}


def test_ranks_are_level_where_deviations_are_right_and_hold_what_intervals_hold(tmp_path):
    """Of normal scores; twice as narrow deviations leave 67 % in their 95 % intervals."""
    scores = np.random.default_rng(0).normal(size=4000)
    counts, _ = np.histogram(coverage_page.ranks(scores), np.linspace(0, 1, 11))
    assert np.abs(counts - 400).max() < 4 * np.sqrt(400 * 0.9)
    assert coverage_page.covered(scores) == pytest.approx(0.95, abs=0.014)
    assert coverage_page.covered(2 * scores) == pytest.approx(0.673, abs=0.03)
    assert coverage_page.ranks([5.0])[0] < 1e-6  # the truth is far below the fit
    rows = [{"solid": False, "scores": {"modulus": each}} for each in scores[:50].tolist()]
    rows.append({"solid": False, "refused": "no hold"})
    made = {"command": "c", "commit": "a", "date": "d", "rows": rows}
    coverage_page.write(made, tmp_path / "coverage.html")
    html = (tmp_path / "coverage.html").read_text(encoding="utf-8")
    assert "50 records were calibrated, 1 refused" in html
    assert "coverage.json" in html

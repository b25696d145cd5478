"""The page of a study: bars, isobars, what is told on top, tables that fit; and its progress."""

import pytest

from fefinger.commands import study as command
from fefinger.studies import study_page as figures
from fefinger.studies import study_page as report
from fefinger.studies.grid import MESH, remarks
from fefinger.studies.study import Study


X = "indenter.angle_deg"


def row(angle, **more):
    """Return a row at the end of a press."""
    return {X: angle, "at": "end", "status": "done", "mechanics": "linear", **more}


def panel(drawn, title):
    """Return the axes of a title."""
    return next(axis for axis in drawn.axes if axis.get_title(loc="left") == title)


def test_bars_hold_what_has_the_stated_error_and_end_at_twice_the_value():
    rows = [
        row(0, highest_pressure_1mm2_kPa=20.0, highest_pressure_rel_error=0.1, force_N=1.0),
        row(30, highest_pressure_1mm2_kPa=30.0, highest_pressure_rel_error=1.5, force_N=2.0),
        row(60, highest_pressure_1mm2_kPa=40.0, force_N=3.0),
    ]
    drawn = figures.panels(rows, X, [])
    (bars,) = panel(drawn, "highest pressure over 1 mm² / kPa").collections
    ends = [segment[:, 1].tolist() for segment in bars.get_segments()]
    assert ends == [pytest.approx([20 / 1.1, 20 / 0.9]), pytest.approx([12, 60])]
    assert not panel(drawn, "force / N").collections


def test_a_measure_that_is_the_same_everywhere_has_no_panel():
    told = [{"x_deg": x, "depth_mm": 1.5 + 1e-4 * x, "force_N": 1.0 + x} for x in range(3)]
    drawn = figures.panels(told, "x_deg", [])
    titles = [axis.get_title(loc="left") for axis in drawn.axes if axis.axison]
    assert titles == ["force / N"]


def test_what_rounding_leaves_of_symmetry_has_no_panel():
    rows = [row(angle, asymmetry=1e-16 * angle, force_N=1.0 + angle) for angle in (0, 30)]
    titles = [axis.get_title(loc="left") for axis in figures.panels(rows, X, []).axes]
    assert "force / N" in titles
    assert "asymmetry of the force" not in titles
    assert report.text(1e-17) == "0"


def test_a_series_is_named_with_units_and_keeps_its_color_where_others_are_missing():
    speed, rows = "motion.speed_mm_per_s", []
    for angle in (0, 30):
        rows += [row(angle, **{speed: each, "force_N": each + angle}) for each in range(1, 10)]
    groups = figures.grouped(rows, [speed])
    assert list(groups)[1] == "speed 2 mm/s"
    second = [each for each in rows if each[speed] == 2]
    for drawn in (
        figures.panels(second, X, [speed], labels=list(groups)),
        figures.spikes([each | {"spikes_SAI": 1} for each in second], X, [speed], list(groups)),
    ):
        (line,) = [each for each in drawn.axes[0].lines if len(each.get_xdata())]
        (named,) = drawn.legends[0].get_lines()
        assert line.get_color() == named.get_color() == figures.PALETTE[1]
        assert drawn.legends[0].get_texts()[0].get_text() == "speed 2 mm/s"
    looks = {(line.get_color(), line.get_marker())
             for line in figures.panels(rows, X, [speed]).legends[0].get_lines()}  # fmt: skip
    assert len(looks) == len(groups)


def test_values_that_are_no_numbers_are_words_on_the_axis():
    rows = [row(angle, force_N=force) for angle, force in ((None, 1.0), (30, 2.0))]
    about = {"grid": {"indenter.angle": [None, 30]}}
    page = report.html(Study("press", (X,), tuple(rows), (), 2, 0, about))
    assert ">None</" in page


def test_the_page_tells_on_top_what_was_not_reached_and_what_the_bars_are():
    told = [
        row(0.0, force_N=1.0, force_rel_error=0.1, contact_area_mm2=3.0, asymmetry=0.1),
        row(30.0, force_N=1.0, force_rel_error=0.2, contact_area_mm2=3.0, asymmetry=0.2),
    ]
    missed = [
        {X: angle, "at": "50 N", "status": "not reached: force = 2 N at most", "mechanics": name}
        for angle, name in ((0.0, "linear"), (30.0, "solid"))
    ]
    about = {"grid": {"indenter.angle": [0, 30]}}
    page = report.html(Study("press", (X,), (*told, *missed), (), 2, 0, about))
    top, _, rest = page.partition("<section")
    assert "2 scenes have no row at 50 N, the first of them: " in top
    assert "The rows are answers of linear, solid: " in top
    assert "by its expected error: force 10 % to 20 %. Bars end at twice the value." in top
    assert "The array of the thesis" not in top
    assert "not of the tissue" in top
    assert "Error not known: contact area in 2 of 2 rows." in top
    assert "No error is stated of asymmetry of the force." in top
    assert "force_<wbr>rel_<wbr>error" in rest
    assert "peak pressure" not in page


def test_rows_of_different_mechanics_and_forces_not_reached_are_told():
    told = [
        {"angle": angle, "at": "1 N", "status": "done", "mechanics": name}
        for angle, name in ((10.0, "linear"), (20.0, "lumped"), (30.0, "linear"))
    ]
    (said,) = remarks(told, ("angle",))
    assert said.startswith("The rows are answers of linear, lumped: ")
    assert "--mechanics NAME takes one for all" in said
    assert remarks(told[:1], ("angle",)) == []
    missed = told[0] | {"at": "50 N", "status": "not reached: force = 2 N at most"}
    (said,) = remarks([missed], ("angle",))
    assert said == "angle = 10.0, at 50 N: not reached: force = 2 N at most"


def test_rows_of_other_meshes_are_told():
    rows = [row(0.0, mesh="coarse"), row(30.0, mesh="standard")]
    (said,) = remarks(rows, (X,))
    assert said.startswith("The rows are answers of linear coarse, linear standard: ")


def test_meshes_that_are_compared_on_purpose_need_no_remark():
    rows = [
        {MESH: mesh, "at": "end", "status": "done", "mechanics": "linear", "mesh": mesh}
        for mesh in ("coarse", "standard")
    ]
    assert remarks(rows, (MESH,)) == []
    assert len(remarks(rows, ("indenter.angle_deg",))) == 1
    other = rows[0] | {"mechanics": "solid"}
    assert "linear, solid" in remarks([*rows, other], (MESH,))[0]


def test_a_failure_with_a_table_is_told_by_its_first_and_its_last_line():
    said = "ask: no mechanics is able\n\n  mechanics  error\n  linear  9 %\n\nName a mechanics."
    about = {"grid": {X: [1.0]}, "mechanics": None}
    study = Study("press", (X,), (), (({X: 1.0}, said),), 1, 0, about)
    short = "ask: no mechanics is able [...] Name a mechanics."
    assert short in report.html(study)
    assert short in command.study_summary(command.study_record(study, []))
    assert "one line" in report.html(Study("p", (X,), (), (({X: 1.0}, "one line"),), 1, 0, about))


def test_counts_of_spikes_have_whole_numbers_at_their_ticks() -> None:
    rows = [{X: x, "spikes_SAI": count} for x, count in ((1.0, 0), (2.0, 1), (3.0, 2))]
    (axis,) = figures.spikes(rows, X, []).axes
    assert all(float(tick).is_integer() for tick in axis.get_yticks())

"""The report holds what was asked, nothing else, and needs no other file."""

import dataclasses
import io
import math
import re
from xml.etree.ElementTree import fromstring

import numpy as np
import pytest

from fefinger.pages import report
from fefinger.results import key_numbers
from fefinger.results.pressure import highest
from fefinger.results.records import Rung
from fefinger.scene.motions import Ramp, RampHold, RampSinusoid
from fefinger.scene.scene import Scene
from fefinger.view import figures, renderer, spatial_figures


def page(result, folder):
    report.write(result, folder / "report.html")
    return (folder / "report.html").read_text(encoding="utf-8")


def sections(html):
    return re.findall(r'<section id="([a-z]+)"', html)


@pytest.fixture(autouse=True)
def plain_pictures(monkeypatch):
    """Draw without a renderer: the pictures of view have their own tests."""
    monkeypatch.setattr(renderer, "renderer_lacking", lambda: "No renderer (said in the test).")


@pytest.fixture
def words_alone(monkeypatch):
    """Leave drawings out of the page, where its words are the question."""
    monkeypatch.setattr("fefinger.pages.page.svg", lambda drawn: "data:,")


def test_a_full_report_has_every_section_and_stands_alone(synthetic, tmp_path):
    html = page(synthetic, tmp_path)
    parts = ["force", "pressure", "contact", "section", "strain", "current", "spikes"]
    assert sections(html) == [*parts, "limits", "plan", "files", "provenance"]
    sources = re.findall(r'src="([^"]*)"', html)
    assert len(sources) == 8
    assert all(source.startswith("data:image/svg+xml,") for source in sources)
    files = {"result.nc", "result.vtkhdf", "spikes.csv", "units.csv"}
    assert set(re.findall(r'href="([^"]*)"', html)) == files
    for text in (
        "No renderer (said in the test).",
        "The run overrides a refusal about accuracy: depth / half thickness = 0.3 &gt; 0.2",
        "contact radius / tissue thickness = 0.9 &gt; 0.1 (accuracy)",
        "Expected within: force 4 %, contact area 3 %. Error not known: highest pressure over "
        "1 mm², strain at the end organs, spikes.",
        "Small strain: geometry of the undeformed finger.",
        "SAI-1: made up.",
        "versions.fefinger",
        "kind = &#34;ramp-hold&#34;",
        "result.show()",
    ):
        assert text in html


def test_what_was_not_asked_is_absent(synthetic, tmp_path):
    names = ("contact_area", "centroid", "pad", "pressure", "sites", "strain", "fields")
    response = dataclasses.replace(synthetic.response, **dict.fromkeys(names))
    bare = dataclasses.replace(synthetic, response=response, spikes=None, provenance={})
    html = page(bare, tmp_path)
    assert sections(html) == ["force", "limits", "plan", "files", "provenance"]
    assert "None" not in html
    assert "result.show()" not in html


def test_the_answer_says_force_area_and_spikes(synthetic):
    peak = synthetic.response.force.max()
    said = report.answer(synthetic)
    assert f"peaks at {peak:.3g} N" in said
    assert "33 mm²" in said
    assert "SAI-1 107, SAII-1 51, FAI-1 5, FAII-1 0 (not modeled here)" in said


@pytest.mark.usefixtures("words_alone")
def test_under_a_given_force_the_answer_is_the_depth_and_pictures_are_of_the_deepest_step(
    synthetic, tmp_path
):
    """The force is the same through the hold; its largest value is one of rounding."""
    motion = RampHold(loading_rate=1.0, force=1.0, hold=1.0)
    scene = dataclasses.replace(synthetic.scene, motion=motion)
    depth = np.linspace(0.0, 1.5, len(synthetic.time))
    response = dataclasses.replace(synthetic.response, depth=depth)
    held = dataclasses.replace(synthetic, scene=scene, response=response)
    assert held.peak == len(held.time) - 1 != synthetic.peak
    html = page(held, tmp_path)
    tiles = re.findall(r'<div class="tile"><span>(.*?)</span><b>(.*?)</b>', html)
    assert tiles[0] == ("largest depth", "1.5 mm")
    assert "N and the indentation 1.5 mm (at" in report.answer(held)
    assert "Contact pressure at the largest depth" in html


@pytest.mark.usefixtures("words_alone")
def test_the_first_tiles_are_the_numbers_that_matter_with_their_errors(synthetic, tmp_path):
    html = page(synthetic, tmp_path)
    tiles = re.findall(r'<div class="tile"><span>(.*?)</span><b>(.*?)</b><i>(.*?)</i>', html)
    names = ["peak force", "largest contact area", "largest compressive strain at an end organ"]
    assert [name for name, _, _ in tiles] == [*names, "spikes of 4 units"]
    assert tiles[0][1] == f"{synthetic.response.force.max():.3g} N"
    assert tiles[0][2].startswith("within 4 %")
    assert tiles[1][2] == "within 3 %"
    assert tiles[2][2].startswith("error not known")
    assert html.index('class="tile"') < html.index('<section id="force"')
    # The highest pressure at a point has its own time.
    step = int(np.argmax(synthetic.pressure.max(axis=1)))
    top, when = synthetic.pressure[step].max(), key_numbers.format_instant(synthetic.time[step])
    assert f"at most {top:.3g} kPa, at {when}." in html
    mean, _ = highest(synthetic.pad, synthetic.pressure)
    assert f"{mean:.3g} kPa over 1 mm²" in html


@pytest.mark.usefixtures("words_alone")
def test_pressure_is_at_vertices_of_a_mesh_or_at_points_of_a_grid_without_lines(
    synthetic, tmp_path
):
    layers = dataclasses.replace(synthetic.response, mechanics="layered")
    gridded = dataclasses.replace(synthetic, response=layers)
    for result, point, lines in (
        (synthetic, "a vertex of the mesh", 1),
        (gridded, "a point of the grid", 0),
    ):
        html = page(dataclasses.replace(result, spikes=None), tmp_path)
        assert f"at {point} alone" in html
        assert html.count("lines show the mesh") == lines
        axis = spatial_figures.pressure_map(result).axes[0]
        assert point in axis.get_title(loc="left")
        assert any(line.get_linewidth() < 0.5 for line in axis.lines) == bool(lines)


@pytest.mark.usefixtures("words_alone")
def test_block_and_large_errors_are_said_and_what_is_not_able_has_neither_cost_nor_error(
    synthetic, tmp_path
):
    spikes = dataclasses.replace(synthetic.spikes, block_seconds=np.array([0.0, 2.5, 0.0, 0.0]))
    scene = dataclasses.replace(synthetic.scene, name="<script>alert(1)</script>")
    wrong, *others = synthetic.plan.rungs
    wrong = dataclasses.replace(wrong, error=1.2)
    rungs = (Rung("lumped", math.nan, math.nan, "not able"), wrong, *others)
    plan = dataclasses.replace(synthetic.plan, rungs=rungs)
    html = page(dataclasses.replace(synthetic, spikes=spikes, scene=scene, plan=plan), tmp_path)
    assert "SAII-1 spends 2.5 s in depolarization block" in html
    assert "<script>" not in html
    assert ">120 %</td>" in html  # as in the terminal
    (row,) = re.findall(r"<td>lumped</td>.*?</tr>", html, re.S)
    assert "nan" not in row


@pytest.mark.parametrize(
    ("motion", "titles"),
    [
        (Ramp(speed=60, depth=1.5), ["whole stimulus"]),
        (RampHold(speed=60, depth=1.5, hold=5), ["first movement", "whole stimulus"]),
        (
            RampSinusoid(speed=20, depth=1, amplitude=0.01, frequency=200, cycles=100, settle=1),
            ["first movement", "last four cycles", "whole stimulus"],
        ),
    ],
)
def test_fast_and_slow_parts_get_their_own_panels(synthetic, motion, titles):
    scene: Scene = dataclasses.replace(synthetic.scene, motion=motion)
    spans = figures.windows(scene, motion.duration)
    assert [title for title, _, _ in spans] == titles
    assert spans[-1][1:] == (0.0, motion.duration)
    assert all(0 <= start < stop <= motion.duration for _, start, stop in spans)


def test_the_same_result_gives_the_same_figure(synthetic):
    assert figures.svg(figures.force(synthetic)) == figures.svg(figures.force(synthetic))


def test_an_svg_keeps_its_words_and_moves_no_mark():
    with figures.style():
        drawn = figures.figure(3, 2)
        axes = drawn.subplots()
        axes.plot([0, 1, 2], [0.1234567, 0.2, 0.7], label="a & b < 0.12345")
        axes.legend()
        text = io.StringIO()
        drawn.savefig(text, format="svg", metadata={"Date": None})
    exact, short = (
        fromstring(each) for each in (text.getvalue(), figures.rounded(text.getvalue()))
    )
    exact.remove(exact[0])  # metadata, which nobody sees
    words = [" ".join(" ".join(each.itertext()).split()) for each in (exact, short)]
    assert words[0] == words[1]
    assert "a & b < 0.12345" in words[0]
    for one, other in zip(exact.iter(), short.iter(), strict=True):
        for key in ("d", "x", "y"):
            numbers = [re.findall(r"[-\d.]+", each.get(key, "")) for each in (one, other)]
            places = [np.array(each, float) for each in numbers]
            np.testing.assert_allclose(*places, rtol=0, atol=0.00501)

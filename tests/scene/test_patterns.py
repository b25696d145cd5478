"""Raised dots, Braille and letters: their surfaces, against counts, sizes and other splines."""

import struct
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from refusals import refused
from scipy.interpolate import RectBivariateSpline

import fefinger as ff
from fefinger.geometry.profiles import Relief, flank_of, sharpest_radius, smooth_step
from fefinger.mechanics.press.mesh_limits import rim_reached
from fefinger.scene.texts import cells
from fefinger.support.checks import InputError


PATTERNS = [
    ff.Dots(2.0),
    ff.Dots(2.0, arrangement="random", seed=7),
    ff.Braille("touch 12"),
    ff.Letters("Rao&B"),
]


def grid(step: float, x: tuple[float, float], y: tuple[float, float]) -> np.ndarray:
    return np.stack(np.meshgrid(np.arange(*x, step), np.arange(*y, step), indexing="ij"), axis=-1)


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda one: one.describe())
def test_crests_have_the_stated_radius_and_the_stated_height(pattern):
    places = grid(0.02, (-1, 9), (-3, 3))
    h = pattern.profile.rise(places)
    assert h.min() == pytest.approx(0, abs=1e-3 * pattern.height)
    assert h.max() == pytest.approx(pattern.height, rel=2e-3)
    sharpest = sharpest_radius(pattern.profile, places.reshape(-1, 2))
    assert sharpest == pytest.approx(pattern.crest, rel=0.06)


@pytest.mark.parametrize("pattern", PATTERNS, ids=lambda one: one.describe())
def test_compiled_heights_and_slopes_are_those_of_the_spline(pattern):
    places = np.random.default_rng(1).uniform(-40, 40, (4000, 2))
    h, slope, _ = pattern.profile.height(places)
    rise = pattern.profile.rise(places)
    assert np.array_equal(np.isfinite(rise), np.isfinite(h))
    there = np.isfinite(h)
    assert rise[there] == pytest.approx(h[there], abs=1e-12)
    assert pattern.profile.incline(places) == pytest.approx(slope, abs=1e-11)


def test_a_raster_is_the_spline_of_fitpack_up_to_its_edge_and_uneven_lines_keep_that():
    rng = np.random.default_rng(2)
    u, v = np.linspace(-1, 2, 17), np.linspace(0, 1, 9)
    heights = rng.normal(size=(17, 9))
    places = np.column_stack([rng.uniform(-1, 2, 500), rng.uniform(0, 1, 500)])
    spline = RectBivariateSpline(u, v, heights.max() - heights)
    even = Relief(u, v, heights)
    assert even.rise(places) == pytest.approx(spline.ev(*places.T), abs=1e-12)
    assert even.incline(places)[:, 1] == pytest.approx(spline.ev(*places.T, dy=1), abs=1e-10)
    assert np.isinf(even.rise(np.array([[2.01, 0.5], [0.0, -0.01]]))).all()
    uneven = Relief(u**3, v, heights)
    other = RectBivariateSpline(u**3, v, heights.max() - heights)
    assert uneven.rise(places) == pytest.approx(other.ev(*places.T), abs=1e-12)


def test_a_step_is_as_sharp_as_its_flank_says():
    t = np.linspace(0, 1, 20001)
    bend = np.gradient(np.gradient(0.4 * smooth_step(t), t), t) / flank_of(0.1, 0.4) ** 2
    assert 1 / np.abs(bend).max() == pytest.approx(0.1, rel=1e-3)


def test_dots_stand_on_their_grid_and_at_random_with_the_same_density():
    step = 0.02
    for dots in (ff.Dots(2.0), ff.Dots(2.0, arrangement="random", seed=3)):
        h = dots.profile.rise(grid(step, (0, 24), (0, 24)))
        volume = (dots.height - h).sum() * step**2
        r = np.linspace(0, 1, 4001)
        one = 2 * np.pi * np.trapezoid(r * dots.rising(dots.diameter / 2 - r), r)
        assert volume == pytest.approx(144 * one, rel=5e-3)
    assert ff.Dots(2.0).profile.rise(np.array([[4.0, -6.0]])) == pytest.approx(0.0, abs=1e-9)


def test_random_dots_follow_their_seed_repeat_and_keep_apart():
    dots = ff.Dots(1.5, arrangement="random", seed=5)
    again, other = (ff.Dots(1.5, arrangement="random", seed=k) for k in (5, 6))
    assert np.array_equal(dots.centers, again.centers)  # exact: one seed, twice
    assert not np.array_equal(dots.centers, other.centers)
    apart = np.abs(dots.centers[:, None] - dots.centers)
    apart = np.hypot(*np.moveaxis(np.minimum(apart, dots.tile - apart), 2, 0))
    assert (apart + dots.tile * np.eye(len(apart))).min() >= dots.base
    places = np.random.default_rng(0).uniform(0, 18, (300, 2))
    moved = dots.profile.rise(places + np.array([1, -2]) * dots.tile)
    assert dots.profile.rise(places) == pytest.approx(moved, abs=1e-9)


def test_braille_has_the_dots_of_the_table():
    assert list(cells("Louis")) == [(5,), (0, 1, 2), (0, 2, 4), (0, 2, 5), (1, 3), (1, 2, 3)]
    assert list(cells("12a, w")) == [
        *((2, 3, 4, 5), (0,), (0, 1), (4, 5), (0,)),
        *((1,), (), (1, 3, 4, 5)),
    ]
    word = ff.Braille("l i")
    assert len(word.centers) == 5
    assert word.centers[:, 0].max() == pytest.approx(2 * word.cell + word.spacing)
    assert word.profile.rise(word.centers) == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        *(("3.5", "⠼⠉⠲⠑"), ("1,000", "⠼⠁⠂⠚⠚⠚"), ("12m", "⠼⠁⠃⠍"), ("1k", "⠼⠁⠅")),
        *(("12a", "⠼⠁⠃⠰⠁"), ("5, 6", "⠼⠑⠂⠀⠼⠋"), ("Touch", "⠠⠞⠕⠥⠉⠓"), ("ABC x", "⠠⠠⠁⠃⠉⠀⠭")),
    ],
)
def test_numbers_and_capitals_are_those_of_unified_english_braille(text, printed):
    """Rulebook of UEB, 6.1 to 6.5 and 8.3 to 8.4; Unicode numbers the patterns by their dots."""
    patterns = [chr(0x2800 + sum(1 << dot for dot in cell)) for cell in cells(text)]
    assert "".join(patterns) == printed


def test_dollars_are_letters_and_not_mathematics():
    assert ff.Letters("$x$").box[0] > 2 * ff.Letters("$").box[0]


def test_letters_are_as_tall_as_stated_and_have_their_holes():
    letters = ff.Letters("HO", size=8, start=1.0)
    h = letters.profile.rise(grid(0.05, (0.0, 19.0), (-6, 6)))
    raised = h < letters.height / 2
    rows = np.flatnonzero(raised[: int(5 / 0.05)].any(axis=0))
    assert (rows[-1] - rows[0]) * 0.05 == pytest.approx(8, abs=0.2)  # that of the H
    columns = np.flatnonzero(raised.any(axis=1))
    assert columns[0] * 0.05 == pytest.approx(1.0, abs=0.1)
    assert columns[-1] * 0.05 == pytest.approx(1.0 + letters.box[0], abs=0.1)
    middle = int((1.0 + letters.box[0] - 4) / 0.05)
    assert not raised[middle, int(6 / 0.05)]  # the hole of the O


BAD = [
    (
        lambda: ff.Dots(0.75),
        "spacing: .* received spacing = 0.75, diameter = 0.7, which leave 0.05",
    ),
    (lambda: ff.Dots(0.6), "indenter.spacing: .* which leave 0 mm"),
    (lambda: ff.Dots(2, edge=1e-4), "indenter.edge: expected at least 0.00277 mm at a height of"),
    (lambda: ff.Dots(1000), "indenter.spacing: expected a surface of at most 1e.07 samples"),
    (lambda: ff.Braille("a", diameter=2.4), "received spacing = 2.34, diameter = 2.4, which leave"),
    (lambda: ff.Braille("a", cell=3.5), "indenter.cell: .* received cell = 3.5, spacing = 2.34, d"),
    (lambda: ff.Letters("a", size=0.5), "indenter.size: .* received size = 0.5, which leave 0.067"),
    (lambda: ff.Letters("M" * 60, size=40).profile, "indenter.text: expected a surface of at most"),
    (lambda: ff.Dots(2, edge=1.0), "indenter.edge: expected at most 0.212 mm"),
    (lambda: ff.Dots(2, arrangement="hexagon"), "indenter.arrangement: expected one of"),
    (lambda: ff.Dots(2, seed=-1), "indenter.seed: expected a whole number"),
    (lambda: ff.Dots(1.0, arrangement="random"), "room for 144 dots 1 mm wide at random"),
    (lambda: ff.Braille("tøj"), "indenter.text: .* received 'ø'"),
    (lambda: ff.Braille(" "), "not all blank"),
    (lambda: ff.Letters("a" * 61), "1 to 60 characters"),
    (
        lambda: ff.Letters("a漢字b").box,
        "expected characters that DejaVu Sans draws, received '漢字'",
    ),
    (lambda: ff.Letters("a\nb").profile, r"DejaVu Sans draws, received '\\n'"),
    (
        lambda: ff.Relief.from_array(np.diag([0.0, 120, 250, 500]), 0.1),
        "indenter.heights: expected heights in mm that differ by at most 20 mm, received 0 to 500",
    ),
    (lambda: ff.Relief.from_array([["a"] * 4] * 4, 0.1), "indenter.heights: .* of numbers in mm"),
    (lambda: ff.Grating(3, 1, 0.5, edge=2.0), "indenter.edge: expected at most"),
]


@pytest.mark.parametrize(("make", "message"), BAD)
def test_what_cannot_be_made_gets_a_sentence(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("pattern", "crest"),
    [
        (ff.Dots(3), 0.1),
        (ff.Dots(3, height=0.5, diameter=0.5), 0.5**2 / (10 / 3**0.5 * 0.5)),
        (ff.Dots(1.0), 0.3**2 / (10 / 3**0.5 * 0.4)),
        (ff.Braille("a"), 0.25),
        (ff.Letters("a"), 0.05),
        (ff.Letters("a", size=1), 0.135**2 / (10 / 3**0.5 * 0.5)),
        (ff.Dots(3, edge=0.03), 0.03),
    ],
)
def test_an_edge_that_nobody_states_is_the_usual_one_or_what_fits(pattern, crest):
    assert (pattern.crest, pattern.least_radius) == pytest.approx((crest, crest))
    flatter = replace(pattern, height=pattern.height * 2)
    assert flatter.crest <= crest
    assert flatter.edge == pattern.edge  # what was stated stays stated


def test_a_grating_with_a_stated_edge_has_it_and_keeps_its_widths():
    grating = ff.Grating(3, 1.2, 0.5, edge=0.1)
    assert grating.least_radius == pytest.approx(0.1, rel=0.02)
    at = np.array([[0.6, 0.0], [1.5, 0.0], [0.0, 0.0]])
    assert grating.profile.height(at)[0] == pytest.approx([0.25, 0.5, 0.0], abs=1e-12)


@pytest.mark.parametrize(
    ("surface", "width"),
    [
        (lambda x, y: 0.2 * np.sin(np.pi * x) + 0 * y, 1.0),
        (lambda x, y: 0.2 * np.sin(np.pi * x) + 0.3 * x - 0.1 * y, 1.0),
        (lambda x, y: 0.2 * np.sin(np.pi * x) * np.sin(np.pi * y), 1 / 2**0.5),
        (lambda x, y: 0.3 * x - 0.1 * y, np.inf),
        (lambda x, y: 0 * x * y, np.inf),
    ],
)
def test_the_width_of_the_parts_of_a_relief_is_that_of_its_sine(surface, width):
    lines = np.linspace(-6, 6, 121)
    assert ff.Relief.of(surface, lines, lines).feature == pytest.approx(width, rel=0.02)


def test_a_relief_is_read_from_a_picture_an_array_and_a_surface(tmp_path: Path):
    from matplotlib.image import imsave

    pixels = np.zeros((6, 8))
    pixels[0, 7] = 1.0  # the upper right corner
    imsave(tmp_path / "a.png", pixels, cmap="gray", format="png")
    read = ff.Relief.from_file(tmp_path / "a.png", pitch=0.5, height=0.3)
    assert (len(read.x), len(read.y)) == (8, 6)
    assert read.heights[7][5] == pytest.approx(0.3)
    assert np.sum(read.heights) == pytest.approx(0.3, abs=1e-6)
    assert read == ff.Relief.from_array(np.array(read.heights), 0.5)
    facets = [[(0, 0, 0), (4, 0, 1), (0, 4, 0)], [(4, 0, 1), (4, 4, 1), (0, 4, 0)]]
    (tmp_path / "a.stl").write_bytes(stl(facets))
    ramp = ff.Relief.from_file(tmp_path / "a.stl", pitch=0.5)
    assert (ramp.x[0], ramp.x[-1], len(ramp.y)) == (0.0, 4.0, 9)
    assert np.array(ramp.heights)[:, 0] == pytest.approx(np.linspace(0, 1, 9), abs=1e-6)


def test_the_sides_of_a_block_are_no_part_of_its_relief(tmp_path: Path):
    block = pv.Box((-1.1, 1.1, -1.1, 1.1, 0, 0.7)).triangulate()
    block.save(tmp_path / "block.stl")
    found = ff.Relief.from_file(tmp_path / "block.stl", pitch=0.1)
    assert len(found.x) == len(found.y) == 23
    assert np.array(found.heights) == pytest.approx(0.7, abs=1e-6)


def stl(facets: list) -> bytes:
    """Return a binary STL of triangles."""
    body = b"".join(
        struct.pack("<12fH", 0, 0, 1, *(x for corner in facet for x in corner), 0)
        for facet in facets
    )
    return bytes(80) + struct.pack("<I", len(facets)) + body


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.png", {"height": 1.0}, "indenter.pitch: missing; .* needs the distance in mm"),
        ("a.png", {"pitch": 1.0}, "indenter.height: missing; .* white over black"),
        ("a.csv", {"pitch": 1.0}, "indenter.file: expected a file of heights"),
        ("a.png", {"pitch": 1.0, "height": 1.0}, "cannot read the picture"),
        ("a.stl", {"pitch": 1.0}, "expected triangles in"),
        ("hole.stl", {"pitch": 0.5}, "leaves .* % of it open; cut it to a rectangle"),
    ],
)
def test_files_that_are_no_relief_get_a_sentence(tmp_path: Path, name, options, message):
    for damaged in ("a.png", "a.stl"):
        (tmp_path / damaged).write_bytes(b"no picture, no surface")
    (tmp_path / "hole.stl").write_bytes(stl([[(0, 0, 0), (4, 0, 1), (0, 4, 0)]]))
    with pytest.raises(InputError, match=message):
        ff.Relief.from_file(tmp_path / name, **options)


def test_a_relief_is_put_under_first_touch_and_says_where_it_lies(tmp_path: Path) -> None:
    rows = [f"{x},{y},{0.1 * ((x + y) % 2)}" for x in range(20) for y in range(30)]
    (tmp_path / "corner.csv").write_text("\n".join(["x,y,height", *rows]))
    table = {"kind": "relief", "file": "corner.csv"}
    scene = {"finger": {"subject": "a.h."}, "motion": {"kind": "ramp", "speed": 10, "depth": 1}}
    with refused("indenter") as caught:
        ff.Scene.from_dict(scene | {"indenter": table}, folder=tmp_path)
    assert "from x = 0 to 19 and y = 0 to 29 mm" in str(caught.value)
    assert "indenter.center = true" in str(caught.value)
    placed = ff.Scene.from_dict(scene | {"indenter": table | {"center": True}}, folder=tmp_path)
    assert placed.indenter.extent == ((-9.5, 9.5), (-14.5, 14.5))
    assert "x from -9.5 to 9.5 and y from -14.5 to 14.5 mm" in rim_reached(
        7, placed.indenter.profile
    )
    assert "indenter.center" not in rim_reached(7, ff.Pin(4).profile)


def test_a_relief_of_too_many_heights_is_refused_before_they_are_looked_at() -> None:
    with refused("indenter.heights"):
        ff.Relief.from_array(np.full((2000, 600), np.nan), 0.02)
    lines = np.arange(1100.0)
    with refused("indenter.heights"):
        ff.Relief.of(None, lines, lines)


def test_the_sharpest_crest_of_a_relief_on_lines_is_that_of_all_their_crossings() -> None:
    rng = np.random.default_rng(2)
    u, v = np.cumsum(rng.uniform(0.1, 0.3, 12)), np.cumsum(rng.uniform(0.1, 0.3, 9))
    relief = Relief(u, v, rng.uniform(0, 0.2, (12, 9)))
    fine = np.linspace(u[0], u[-1], 40), np.linspace(v[0], v[-1], 31)
    places = np.stack(np.meshgrid(*fine, indexing="ij"), axis=-1).reshape(-1, 2)
    expected = sharpest_radius(relief, places)
    assert relief.sharpest_radius(*fine) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("one", [ff.Fabric(), ff.Relief.of(lambda x, y: x * y, *[range(5)] * 2)])
def test_the_sharpest_crest_is_not_looked_for_place_by_place(one, monkeypatch) -> None:
    """The 2 million places of a coarse weave, or of a relief of 250 x 250, took 10 s."""
    monkeypatch.setattr(Relief, "height", None)
    assert 0 < one.least_radius < 10

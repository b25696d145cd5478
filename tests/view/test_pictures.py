"""Pictures come out where a renderer exists, and a sentence where none does."""

import dataclasses

import numpy as np
import pytest
from PIL import Image
from refusals import refused

from fefinger import view
from fefinger.__main__ import main
from fefinger.geometry.finger_mesh import FingerMesh
from fefinger.pages import viewer
from fefinger.scene.indenters import Flat
from fefinger.support.checks import InputError
from fefinger.view import figures, frames, pictures, quantities, renderer, section_figure, window
from fefinger.view import plot3d as stage
from fefinger.view.drawing import colors, drawing


needs_renderer = pytest.mark.skipif(
    bool(view.renderer_lacking()), reason=view.renderer_lacking() or "a renderer exists"
)


@pytest.fixture
def no_renderer(monkeypatch):
    """Make the probe end as VTK does where there is no renderer: by a crash of the process."""
    view.renderer_lacking.cache_clear()
    monkeypatch.setattr(renderer, "PROBE", "import os; os.abort()")
    yield
    view.renderer_lacking.cache_clear()


def picture(path):
    """Return the PNG as an array (h, w, 3)."""
    from matplotlib.image import imread

    return imread(path)[..., :3]


def section(result, path, **options):
    """Draw the medial section to a PNG file."""
    section_figure.draw(result, **options).savefig(path)


def test_a_crash_of_the_probe_becomes_a_sentence_with_the_packages(no_renderer):
    assert "libegl1 or libosmesa6" in view.renderer_lacking()


@pytest.mark.parametrize("draw", [view.screenshot, view.movie, view.show])
def test_without_a_renderer_views_in_space_are_refused(synthetic, tmp_path, no_renderer, draw):
    arguments = () if draw is view.show else (tmp_path / "a.gif",)
    with pytest.raises(InputError, match=r"libosmesa6.*`fefinger view DIR --html FILE` works"):
        draw(synthetic, *arguments)
    assert list(tmp_path.iterdir()) == []


def test_without_a_renderer_the_command_ends_with_the_sentence(
    saved, tmp_path, no_renderer, capsys
):
    assert main(["view", "out", "--screenshot", str(tmp_path / "a.png")]) == 2
    assert "No renderer for three-dimensional pictures was found" in capsys.readouterr().err
    assert main(["view", "out", "--html", str(tmp_path / "a.html")]) == 0


def straddling(result):
    """Return the result on a whole finger whose cells the medial plane passes through."""
    fields = frames.whole(result.response.fields)
    fields = dataclasses.replace(fields, points=fields.points - np.array([0.0, 0.4, 0.0]))
    return dataclasses.replace(result, response=dataclasses.replace(result.response, fields=fields))


@pytest.mark.parametrize("mesh", [lambda result: result, straddling], ids=["half", "whole"])
def test_the_section_has_the_colors_of_its_values(synthetic, mesh):
    """In the middle of every triangle of the section, as drawn, is the color of its mean value."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    shown = mesh(synthetic)
    drawn = section_figure.draw(shown, field="strain zz", time=2.5)
    canvas = FigureCanvasAgg(drawn)
    canvas.draw()
    cut = section_figure.medial(shown, "strain zz", 1)
    axis = drawn.axes[0]
    image = np.asarray(canvas.buffer_rgba())[..., :3] / 255
    middle = cut.places[cut.triangles].mean(axis=1)
    columns, rows = np.round(axis.transData.transform(middle) - 0.5).astype(int).T
    value = cut.values[cut.triangles].mean(axis=1)
    expected = cut.span.map()((value - cut.span.low) / (cut.span.high - cut.span.low))[:, :3]
    away = np.abs(image[image.shape[0] - 1 - rows, columns] - expected).max(axis=1)
    # A few lie under an end organ, the indenter or an outline.
    assert np.median(away) < 0.02
    assert (away < 0.1).mean() > 0.7


def test_a_stage_too_short_to_be_timed_is_told_as_such(synthetic):
    timed = dataclasses.replace(synthetic, seconds={"mesh": 1.5, "fields": 2.46e-6})
    (axis,) = figures.stages(timed).axes
    assert [each.get_text() for each in axis.texts] == [" 1.5 s", " < 1 ms"]


def test_halved_triangles_cover_the_same_and_keep_linear_values():
    corners = np.array([[0.0, 0, 1], [2, 0, 3], [0, 2, 5], [2, 2, 7]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]])
    finer, quarters = section_figure._halved(corners, triangles)
    assert len(finer) == 9
    assert len(quarters) == 8
    x, y, value = finer.T
    np.testing.assert_allclose(value, 1 + x + 2 * y)
    a, b, c = finer[quarters][:, :, :2].transpose(1, 0, 2)
    np.testing.assert_allclose(np.linalg.det(np.stack([b - a, c - a], axis=1)), 1.0)


@needs_renderer
@pytest.mark.parametrize("field", ["pressure", "strain xz"])
def test_a_view_in_space_shows_something(synthetic, tmp_path, field):
    view.screenshot(synthetic, tmp_path / "a.png", field, 0.0)
    drawn = picture(tmp_path / "a.png")
    assert drawn.shape == (*pictures.size(1)[::-1], 3)
    assert 0.05 < (drawn.min(axis=2) < 0.98).mean() < 0.9


def test_a_trimmed_picture_has_the_bars_beside_the_finger():
    width, height = pictures.size(1)
    drawn = np.full((height, width, 3), 255, np.uint8)
    drawn[200:400, 100:300] = 0
    drawn[100:150, pictures.PANEL[0] + 90 : pictures.PANEL[0] + 120] = 7
    found = pictures.trimmed(drawn)
    edge = pictures.GAP // 4
    assert found.shape == (300 + 2 * edge, 200 + pictures.GAP + 30 + 2 * edge, 3)
    assert (found == 0).sum() == 3 * 200 * 200
    assert (found[edge : edge + 50, -edge - 30 : -edge] == 7).all()
    assert pictures.trimmed(np.full_like(drawn, 255)).shape[0] == height + 2 * edge


@needs_renderer
def test_compared_results_have_one_scale(synthetic, weaker, tmp_path):
    both = [drawing(result, "tensile strain", "") for result in (synthetic, weaker)]
    strong, weak = (colors([each], "tensile strain") for each in both)
    assert weak.high < 0.6 * strong.high
    assert colors(both, "tensile strain") == strong
    plotter = renderer.plotter((400, 200), 2, aside=60)
    actors = pictures.compose(plotter, [synthetic, weaker], "tensile strain")
    assert [each.scales.field for each in actors] == [strong, strong]
    assert next(iter(plotter.scalar_bars.keys())).split() == ["tensile", "strain", "/", "%"]
    plotter.close()
    view.screenshot([synthetic, weaker], tmp_path / "a.png", "tensile strain", limits=(0, 3))
    assert picture(tmp_path / "a.png").shape[1] == pictures.size(2)[0]


@needs_renderer
def test_bars_of_all_panels_stand_beside_them_once(synthetic, tmp_path):
    silent = dataclasses.replace(synthetic, spikes=None)
    plotter = renderer.plotter((600, 200), 2, aside=100)
    actors = pictures.compose(plotter, [synthetic, silent], "tensile strain")
    named = [" ".join(title.split()) for title in plotter.scalar_bars.keys()]
    assert named == ["tensile strain / %", "pressure / kPa", "rate / Hz"]
    drawn = plotter.renderers[2].actors.values()
    assert all(bar in drawn for bar in plotter.scalar_bars.values())
    highest = [each.scales for each in actors]
    assert highest[0] == highest[1]
    for each in actors:
        each.show("rates", False)
    assert [bar.GetVisibility() for bar in plotter.scalar_bars.values()] == [1, 1, 0]
    plotter.close()


@needs_renderer
def test_labels_of_end_organs_stand_clear_of_the_finger_and_each_other(controls):
    (shown,) = controls.actors
    lines = next(
        prop.actor.mapper.dataset
        for prop in shown.props
        if prop.needs == ("end organs",) and prop.actor.GetClassName() == "vtkOpenGLActor"
        and getattr(prop.actor.mapper.dataset, "n_lines", 0) == 4
    )  # fmt: skip
    column = lines.points[4:]
    assert column[:, 2].min() > shown.shown.fields.points[:, 2].max()
    assert np.abs(np.diff(np.sort(column[:, 2]))).min() > 1.0


def turned(result, angle):
    scene = dataclasses.replace(result.scene, indenter=Flat(angle))
    return dataclasses.replace(result, scene=scene)


@needs_renderer
def test_every_panel_says_which_scene_it_is(synthetic):
    plotter = renderer.plotter((600, 200), 2, aside=100)
    both = [synthetic, turned(synthetic, 21.0)]
    actors = pictures.compose(plotter, both, "pressure", folders=("first", "second"))
    heads = [each.words().split("\n")[0] for each in actors]
    assert heads[0].startswith("first: ")
    assert heads[1].startswith("second: ")
    assert heads[1].endswith("indenter.angle 21 deg")
    for one in actors:
        column = one.where[1]
        one.at(0.1)
        written = plotter.renderers[column].actors[f"words {column}"].input
        assert max(map(len, written.split("\n"))) <= 250 / stage.LETTER
        assert written.split() == one.words().split()
    plotter.close()


@pytest.fixture
def weaker(synthetic):
    """Return the synthetic result with half of the strain."""
    fields = dataclasses.replace(synthetic.fields, strain=0.5 * synthetic.fields.strain)
    return dataclasses.replace(
        synthetic, response=dataclasses.replace(synthetic.response, fields=fields)
    )


@pytest.fixture
def controls(synthetic):
    """Return the window's controls on an off-screen plotter."""
    plotter = renderer.plotter((400, 200), aside=100)
    yield window.Controls(plotter, [synthetic], "compressive strain")
    plotter.close()


def surface(controls, part):
    """Return the first actor that needs a part."""
    return next(prop.actor for prop in controls.actors[0].props if part in prop.needs)


@needs_renderer
def test_the_slider_moves_the_finger_its_colors_and_the_indenter(synthetic, controls):
    fields = synthetic.fields
    depths = np.interp(fields.times, synthetic.time, synthetic.depth)
    axis = frames.pose(synthetic, 0.0).axis
    seen = []
    for number, depth in zip((1, 2, 3), depths, strict=True):
        controls.step(number)
        mesh = surface(controls, "subcutaneous tissue").mapper.dataset
        seen.append((mesh.points.copy(), mesh["field"].copy()))
        assert controls.time == fields.times[number - 1]  # exact: handed on
        assert f"t = {controls.time:.4g} s" in controls.actors[0].words()
        assert surface(controls, "indenter").position == pytest.approx(depth * axis)
    piece = next(p for p in controls.actors[0].shown.surfaces if p.name == "subcutaneous tissue")
    for frame, (points, values) in enumerate(seen):
        moved = fields.points + fields.displacement[frame]
        np.testing.assert_allclose(points, piece.at(moved), atol=1e-5)
        expected = piece.at(quantities.values(synthetic, "compressive strain", frame))
        np.testing.assert_allclose(values, expected, atol=1e-4)
    controls.step(99)
    assert controls.time == fields.times[-1]


@needs_renderer
def test_every_box_hides_its_part_and_brings_it_back(controls):
    first = controls.actors[0]
    assert first.parts == [part for part in stage.PARTS if part != "bone"]
    for part in first.parts:
        controls.toggle(part, False)
        hidden = [prop for prop in first.props if part in prop.needs]
        assert hidden
        assert not any(prop.actor.GetVisibility() for prop in hidden)
        controls.toggle(part, True)
        assert all(prop.actor.GetVisibility() for prop in hidden if prop.without is None)
    with refused("part"):
        first.show("nail", False)


@needs_renderer
def test_pad_and_end_organs_are_colored_by_one_thing_at_a_time(controls):
    instead = [prop for prop in controls.actors[0].props if prop.without is not None]
    assert {prop.without for prop in instead} == {"pressure", "rates"}
    assert not any(prop.actor.GetVisibility() for prop in instead)
    controls.toggle("pressure", False)
    controls.toggle("rates", False)
    assert all(prop.actor.GetVisibility() for prop in instead)


@needs_renderer
def test_end_organs_have_the_rate_of_their_units(synthetic, controls):
    controls.move(2.5)
    time = float(controls.actors[0].shown.fields.times[controls.actors[0].frame])
    actor = next(p.actor for p in controls.actors[0].props if p.needs == ("end organs", "rates"))
    rates = actor.mapper.dataset["rate"].reshape(4, -1)
    expected = [float(synthetic.spikes.rate(unit, time)) for unit in range(4)]
    assert expected[0] == pytest.approx(20.0)
    np.testing.assert_allclose(rates, np.tile(expected, (rates.shape[1], 1)).T)


@needs_renderer
def test_another_field_keeps_time_and_hidden_parts(controls):
    controls.step(1)
    controls.toggle("indenter", False)
    controls.color("strain xz")
    (now,) = controls.actors
    assert (now.field, now.frame) == ("strain xz", 0)
    assert not surface(controls, "indenter").GetVisibility()
    assert next(title.split()[1] for title in controls.plotter.scalar_bars.keys()) == "xz"
    controls.color("pressure")
    assert controls.actors[0].shown.whole
    controls.add_widgets()


@needs_renderer
def test_a_film_has_a_picture_per_stored_time(synthetic, tmp_path):
    view.movie(synthetic, tmp_path / "a.gif", "pressure")
    with Image.open(tmp_path / "a.gif") as film:
        assert film.n_frames >= 3
        assert film.size == pictures.size(1)
        for number in range(film.n_frames):  # the words stood above all but the first
            film.seek(number)
            title = np.asarray(film.convert("L"))[8:26, 8:300]
            assert (title < 100).sum() > 50
    assert [path.name for path in tmp_path.iterdir()] == ["a.gif"]


@needs_renderer
def test_without_a_display_the_window_is_refused(synthetic, monkeypatch):
    monkeypatch.setattr(renderer, "has_display", lambda: False)
    with pytest.raises(InputError, match="--screenshot"):
        view.show(synthetic)


@needs_renderer
@pytest.mark.parametrize("thicker", [0.5, 3.0])
def test_a_mesh_is_drawn_cut_open_between_title_and_legend(synthetic, tmp_path, thicker):
    fields = synthetic.fields
    mesh = FingerMesh(
        points=fields.points * [1.0, 1.0, thicker],
        cells=fields.cells,
        region=fields.region,
        facets={},
        pad_normals=np.zeros_like(fields.points),
        half=True,
        name="box",
        recipe={},
        quality={},
    )
    view.draw_mesh(mesh, tmp_path / "a.png")
    ink = picture(tmp_path / "a.png").min(axis=2) < 0.98
    rows, columns = (np.flatnonzero(ink[80:660].any(axis=axis)) for axis in (1, 0))
    assert ink.mean() > 0.05
    assert rows.max() < 560
    assert columns.min() > 50
    assert columns.max() < ink.shape[1] - 50
    assert np.ptp(rows) > 540 or np.ptp(columns) > 0.88 * ink.shape[1]


@pytest.mark.parametrize("draw", [section, view.screenshot, viewer.write])
def test_what_cannot_be_shown_is_refused_in_a_sentence(synthetic, without_fields, tmp_path, draw):
    with refused("field"):
        draw(synthetic, tmp_path / "a.png", field="presure")
    with pytest.raises(InputError, match=r"ask\.fields=true"):
        draw(without_fields, tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_the_nearest_stored_time_is_drawn(synthetic):
    assert synthetic.fields is not None
    nearest = [frames.nearest_frame(synthetic.fields, time) for time in (-1, 0.1, 2.4, 99)]
    assert nearest == [0, 0, 1, 2]


@pytest.mark.parametrize("draw", [view.screenshot, viewer.write])
def test_a_time_after_the_end_is_refused(synthetic, tmp_path, draw):
    with refused("time"):
        draw(synthetic, tmp_path / "a.png", time=99.0)
    assert list(tmp_path.iterdir()) == []


def test_a_time_a_step_after_the_end_is_that_of_the_end(synthetic):
    step = synthetic.time[-1] - synthetic.time[-2]
    frames.check("time", [synthetic], synthetic.time[-1] + 0.9 * step)
    assert "the last of its 3" in frames.deviations([synthetic], ["out"], 5.0 + 0.5 * step)[0]


@pytest.mark.parametrize("limits", [(-2.0, 6.0), (-6.0, 2.0), (-3.0, 3.0), (0.0, 5.0)])
def test_zero_has_the_middle_color_whatever_the_limits(limits):
    from matplotlib import colormaps

    shown = quantities.span([np.array([-9.0, 9.0])], "strain zz", limits)
    zero = (0.0 - shown.low) / (shown.high - shown.low)
    middle = colormaps[quantities.DIVERGING](0.5)
    assert shown.map()(zero) == pytest.approx(middle, abs=0.02)
    largest = 1.0 if limits[1] >= -limits[0] else 0.0
    assert shown.map()(largest) == pytest.approx(colormaps[quantities.DIVERGING](largest))


def test_limits_on_one_side_of_zero_take_the_even_map():
    shown = quantities.span([np.array([-9.0, 9.0])], "strain zz", (2.0, 6.0))
    assert shown.colors == quantities.EVEN
    assert shown.beyond("%") == "first color: 2 % and less, last color: 6 % and more"


def test_with_little_address_space_nothing_is_drawn_in_space(monkeypatch):
    """VTK and Mesa end the process where they run out of it."""
    view.renderer_lacking.cache_clear()
    monkeypatch.setattr(renderer, "address_space", lambda: renderer.LEAST_MEMORY - 1.0)
    assert view.renderer_lacking().startswith("The address space is limited to 1999 MB")
    view.renderer_lacking.cache_clear()

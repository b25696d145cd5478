"""Pictures come out where a renderer exists, and a sentence where none does."""

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fefinger import section, view
from fefinger.checks import InputError
from fefinger.mesh.record import FingerMesh
from fefinger.records import Result


needs_renderer = pytest.mark.skipif(
    bool(view.renderer_available()), reason=view.renderer_available() or "a renderer exists"
)


@pytest.fixture
def no_renderer(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Make the probe end as VTK does where there is no renderer: by a crash of the process."""
    view.renderer_available.cache_clear()
    monkeypatch.setattr(view, "PROBE", "import os; os.abort()")
    yield
    view.renderer_available.cache_clear()


def picture(path: Path) -> Any:
    """Return the PNG as an array (h, w, 3)."""
    from matplotlib.image import imread

    return imread(path)[..., :3]


def test_a_crash_of_the_probe_becomes_a_sentence_with_the_packages(no_renderer: None) -> None:
    assert "libegl1 or libosmesa6" in view.renderer_available()


def test_without_a_renderer_the_section_is_drawn_and_the_reason_told(
    synthetic: Result, tmp_path: Path, no_renderer: None
) -> None:
    said = view.section_png(synthetic, tmp_path / "a.png")
    assert said == view.renderer_available() != ""
    assert np.ptp(picture(tmp_path / "a.png")) > 0.5


@pytest.mark.parametrize("draw", [view.screenshot, view.show])
def test_without_a_renderer_views_in_space_are_refused(
    synthetic: Result, tmp_path: Path, no_renderer: None, draw: Callable[..., Any]
) -> None:
    arguments = (tmp_path / "a.png",) if draw is view.screenshot else ()
    with pytest.raises(InputError, match="libosmesa6"):
        draw(synthetic, *arguments)
    assert list(tmp_path.iterdir()) == []


@needs_renderer
def test_a_rendered_section_looks_like_the_one_of_matplotlib(
    synthetic: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert view.section_png(synthetic, tmp_path / "a.png", field="strain zz", time=5.0) is None
    monkeypatch.setattr(view, "renderer_available", lambda: "none")
    assert view.section_png(synthetic, tmp_path / "b.png", field="strain zz", time=5.0) == "none"
    rendered, plain = picture(tmp_path / "a.png"), picture(tmp_path / "b.png")
    assert rendered.shape == plain.shape
    assert np.abs(rendered - plain).mean() < 0.02


@needs_renderer
@pytest.mark.parametrize("field", ["pressure", "compressive strain", "strain xz"])
def test_a_view_in_space_shows_something(synthetic: Result, tmp_path: Path, field: str) -> None:
    view.screenshot(synthetic, tmp_path / "a.png", field, 0.0)
    drawn = picture(tmp_path / "a.png")
    assert drawn.shape == (view.SIZE[1], view.SIZE[0], 3)
    assert 0.05 < (drawn.min(axis=2) < 0.98).mean() < 0.9


@needs_renderer
def test_without_a_display_the_window_is_refused(
    synthetic: Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(view, "_has_display", lambda: False)
    with pytest.raises(InputError, match="--screenshot"):
        view.show(synthetic)


@needs_renderer
def test_a_mesh_is_drawn_cut_open(synthetic: Result, tmp_path: Path) -> None:
    fields = synthetic.fields
    assert fields is not None
    mesh = FingerMesh(
        points=fields.points,
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
    assert (picture(tmp_path / "a.png").min(axis=2) < 0.98).mean() > 0.05


def test_an_unknown_field_is_refused_with_the_nearest(synthetic: Result, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="Did you mean 'pressure'"):
        view.section_png(synthetic, tmp_path / "a.png", field="presure")


def test_a_result_without_fields_is_refused(synthetic: Result, tmp_path: Path) -> None:
    response = dataclasses.replace(synthetic.response, fields=None)
    with pytest.raises(InputError, match="fields = true"):
        view.section_png(dataclasses.replace(synthetic, response=response), tmp_path / "a.png")


def test_the_nearest_stored_time_is_drawn(synthetic: Result) -> None:
    assert synthetic.fields is not None
    assert [section.nearest_frame(synthetic.fields, t) for t in (-1, 0.1, 2.4, 99)] == [0, 0, 1, 2]

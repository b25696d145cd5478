"""Pictures of a Result and of a mesh with PyVista: sections, three-dimensional views, windows.

The only module that imports pyvista. VTK ends the process where no renderer exists, so
`renderer_available` asks in another process first.
"""

import functools
import os
import subprocess
import sys
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fefinger import figures, medial, section
from fefinger.checks import InputError, choice
from fefinger.profiles import Ellipsoid, Plane
from fefinger.records import Array, Fields, Integers, Result


if TYPE_CHECKING:
    from fefinger.mesh.record import FingerMesh


DEFAULT = "compressive strain"
PROBE = """
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(vtkRenderer())
window.Render()
"""
PATIENCE = 60  # s that the probe may take
SIZE = (1100, 780)  # pixels of a view in space
PIXELS = 1500  # of the section's longer side
BAR: dict[str, Any] = {
    "color": "#1f2933",
    "vertical": True,
    "position_x": 0.84,
    "position_y": 0.2,
    "height": 0.6,
    "width": 0.05,
    "title_font_size": 26,
    "label_font_size": 24,
}
LEGEND: dict[str, Any] = {
    "title": "region",
    "n_labels": 0,
    "vertical": False,
    "position_x": 0.2,
    "position_y": 0.05,
    "width": 0.6,
    "height": 0.08,
}
REGIONS = {1: ("skin", "#e8b89a"), 2: ("subcutaneous tissue", "#f4dc8c"), 3: ("bone", figures.BONE)}


@functools.cache
def renderer_available() -> str:
    """Return "" if VTK can draw off-screen here, else a sentence that says what is missing."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", PROBE], capture_output=True, timeout=PATIENCE, check=False
        )
        if done.returncode == 0:
            return ""
    except (OSError, subprocess.TimeoutExpired):
        pass
    return (
        "No renderer for three-dimensional pictures was found; on Debian or Ubuntu install the "
        "system package libegl1 or libosmesa6."
    )


def section_png(
    result: Result, path: str | PathLike[str], *, field: str = DEFAULT, time: float | None = None
) -> str | None:
    """Draw the medial section, deformed and colored by `field`, to the PNG file `path`.

    The stored frame next to `time` s is drawn, by default that of the largest force. Returns None,
    or a sentence where no renderer exists and matplotlib drew the section alone. Raises InputError
    if the result has no fields or the field is unknown.
    """
    fields, frame = _frame(result, field, time)
    cut = medial.medial(result, field, frame)
    missing = renderer_available()
    raster = None if missing else _raster(fields, frame, cut)
    with open(path, "wb") as file:
        file.write(figures.png(medial.draw(cut, raster)))
    return missing or None


def screenshot(
    result: Result,
    path: str | PathLike[str],
    field: str = DEFAULT,
    time: float | None = None,
) -> None:
    """Draw the deformed finger in space, colored by `field`, to the PNG file `path`.

    Pressure and displacement are shown on the whole finger from below, strains on the half finger
    behind the medial plane. Raises InputError if there is no renderer, there are no fields or the
    field is unknown.
    """
    fields, frame = _frame(result, field, time)
    _require_renderer()
    plotter = _plotter(list(SIZE))
    _add_finger(plotter, result, fields, frame, field)
    _finish(plotter, path)


def show(result: Result, field: str = DEFAULT) -> Any:
    """Open a window, or a view inside a notebook, with a slider over the stored times.

    Raises InputError if there is no renderer or no display, or the result has no fields.
    """
    import pyvista as pv

    fields, frame = _frame(result, field, None)
    _require_renderer()
    _quiet()
    plotter: Any = pv.Plotter(window_size=[1200, 850])
    if not (plotter.notebook or plotter.off_screen or _has_display()):
        message = (
            "show: expected a display for the window, found none; "
            "use `fefinger view DIR --screenshot PNG`, or a notebook"
        )
        raise InputError(message)
    _add_finger(plotter, result, fields, frame, field)

    def move(value: float) -> None:
        chosen = section.nearest_frame(fields, value)
        _add_finger(plotter, result, fields, chosen, field)

    if len(fields.times) > 1 and not (plotter.notebook or plotter.off_screen):
        limits = (float(fields.times[0]), float(fields.times[-1]))
        now = float(fields.times[frame])
        plotter.add_slider_widget(move, limits, value=now, title="time / s", fmt="%.3f")
    return plotter.show()


def draw_mesh(mesh: "FingerMesh", path: str | PathLike[str]) -> None:
    """Draw a mesh, cut open at the medial plane and colored by region, to the PNG file `path`.

    Raises InputError where no renderer exists.
    """
    _require_renderer()
    plotter = _plotter(list(SIZE))
    behind = mesh.points[mesh.cells][:, :, 1].mean(axis=1) > 0
    body = _grid(mesh.points, mesh.cells[behind])
    body["region"] = mesh.region[behind]
    surface = body.extract_surface(algorithm=None)
    kinds = [kind for kind in REGIONS if kind in body["region"]]
    plotter.add_mesh(
        surface,
        scalars="region",
        cmap=[REGIONS[kind][1] for kind in kinds],
        clim=(min(kinds) - 0.5, max(kinds) + 0.5),
        annotations={float(kind): REGIONS[kind][0] for kind in kinds},
        n_colors=len(kinds),
        show_edges=True,
        edge_color="#6b5d52",
        scalar_bar_args=BAR | LEGEND,
        ambient=0.6,
        diffuse=0.45,
    )
    title = f"{mesh.name}: {len(mesh.points)} points, {len(mesh.cells)} tetrahedra"
    plotter.add_text(title, font_size=16, color="#1f2933")
    _look(plotter, (0.55, -1.0, 0.35))
    _finish(plotter, path)


def _frame(result: Result, field: str, time: float | None) -> tuple[Fields, int]:
    """Return the fields and the number of the frame to draw."""
    choice("field", field, section.FIELDS)
    if result.fields is None:
        message = (
            "fields: expected a result with fields on the mesh, received one without; "
            "run the scene with fields = true in [ask] and a mechanics that has a mesh"
        )
        raise InputError(message)
    moment = section.peak_time(result) if time is None else time
    return result.fields, section.nearest_frame(result.fields, moment)


def _require_renderer() -> None:
    missing = renderer_available()
    if missing:
        raise InputError(missing)


def _quiet() -> None:
    """Keep VTK from warning on every start that there is no X server, before it takes EGL."""
    from vtkmodules.vtkCommonCore import vtkLogger

    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)


def _has_display() -> bool:
    """Return whether a window can open: only Linux runs without a desktop as a rule."""
    names = ("DISPLAY", "WAYLAND_DISPLAY")
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in names)


def _plotter(size: list[int]) -> Any:
    """Return an off-screen plotter with a white background."""
    import pyvista as pv

    _quiet()
    plotter: Any = pv.Plotter(off_screen=True, window_size=size)
    plotter.set_background("white")
    return plotter


def _finish(plotter: Any, path: str | PathLike[str]) -> None:
    """Write the picture as PNG under a temporary name, and move it to `path`."""
    final = Path(path)
    new = final.with_name(f".{final.stem}.new.png")
    try:
        plotter.screenshot(new)
        new.replace(final)
    finally:
        new.unlink(missing_ok=True)
        plotter.close()


def _look(plotter: Any, from_: tuple[float, float, float]) -> None:
    plotter.view_vector(from_, viewup=(0, 0, 1))
    plotter.camera.zoom(1.35)
    plotter.camera.SetWindowCenter(0.1, 0.0)


def _grid(points: Array, cells: Integers) -> Any:
    """Return an unstructured grid of tetrahedra."""
    import pyvista as pv

    return pv.UnstructuredGrid({pv.CellType.TETRA: np.asarray(cells)}, np.asarray(points))


def _behind(fields: Fields) -> NDArray[np.bool_]:
    """Return which cells (n_cells,) lie at y > 0."""
    return np.asarray(fields.points[fields.cells][:, :, 1].mean(axis=1) > 0)


def _face(cut: medial.Medial) -> Any:
    """Return the section as a surface at y = 0 with its values."""
    import pyvista as pv

    flat = np.zeros((len(cut.places), 3))
    flat[:, [0, 2]] = cut.places
    faces: Any = cut.triangles
    surface = pv.PolyData.from_regular_faces(flat, faces)
    surface["field"] = cut.values
    return surface


def _raster(fields: Fields, frame: int, cut: medial.Medial) -> medial.Raster:
    """Render the colored section, and the half finger behind it, without perspective."""
    x0, x1, z0, z1 = cut.extent
    scale = PIXELS / max(x1 - x0, z1 - z0)
    plotter = _plotter([round(scale * (x1 - x0)), round(scale * (z1 - z0))])
    moved = fields.points + fields.displacement[frame]
    behind = _grid(moved, fields.cells[_behind(fields)]).extract_surface(algorithm=None)
    plotter.add_mesh(behind, color=figures.BONE, ambient=0.6, diffuse=0.4)
    plotter.add_mesh(
        _face(cut), scalars="field", cmap=cut.span.colors, clim=cut.span[:2], lighting=False,
        show_scalar_bar=False, interpolate_before_map=True,
    )  # fmt: skip
    middle = ((x0 + x1) / 2, 0.0, (z0 + z1) / 2)
    plotter.camera_position = [(middle[0], -200.0, middle[2]), middle, (0, 0, 1)]
    plotter.enable_parallel_projection()
    plotter.parallel_scale = (z1 - z0) / 2
    plotter.reset_camera_clipping_range()
    picture = np.array(plotter.screenshot(return_img=True))
    plotter.close()
    return medial.Raster(picture, cut.extent)


def _add_finger(plotter: Any, result: Result, fields: Fields, frame: int, field: str) -> None:
    """Add the deformed finger, the end organs and the indenter at one frame, and the words."""
    on_skin = field in ("pressure", "displacement")
    shown = section.whole(fields) if on_skin else fields
    points = shown.points + shown.displacement[frame]
    kept = (shown.region != section.BONE) & (on_skin | _behind(shown))
    body = _grid(points, shown.cells[kept])
    body[field] = section.values(shown, field, frame)
    surface = body.extract_surface(algorithm=None)
    span = medial.span(surface[field], field)
    plotter.add_mesh(
        surface,
        scalars=field,
        cmap=span.colors,
        clim=span[:2],
        smooth_shading=True,
        split_sharp_edges=True,
        ambient=0.5,
        diffuse=0.55,
        scalar_bar_args=BAR | {"title": f"{field} / {section.unit(field)}", "fmt": "%.3g"},
        name="finger",
    )
    bone = shown.cells[_behind(shown) & (shown.region == section.BONE)]
    if len(bone) and not on_skin:
        solid = _grid(points, bone).extract_surface(algorithm=None)
        plotter.add_mesh(solid, color=REGIONS[3][1], ambient=0.6, diffuse=0.4, name="bone")
    _add_indenter(plotter, result, float(fields.times[frame]), on_skin)
    words = f"{result.scene.name}: {field} at t = {fields.times[frame]:.4g} s"
    plotter.add_text(words, font_size=16, color="#1f2933", name="words")
    _look(plotter, (0.75, -0.6, -0.75) if on_skin else (0.5, -1.0, 0.25))


def _front(pose: section.Pose) -> Any:
    """Return the front of an indenter as a surface, within 7 mm aside and 4 mm behind."""
    import pyvista as pv

    line = np.linspace(-7, 7, 281)
    across = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1)
    height = pose.profile.height(across)[0]
    places = np.where((height < 4.0)[..., None], pose.places(across), np.nan)
    grid = pv.StructuredGrid(*(places[..., k] for k in range(3)))
    seen: Any = np.isfinite(grid.points).all(axis=1)
    return grid.extract_points(seen, adjacent_cells=False).extract_surface(algorithm=None)


def _add_indenter(plotter: Any, result: Result, time: float, glass: bool) -> None:
    """Add the indenter: clear as glass where it would hide what is shown."""
    import pyvista as pv

    pose = section.pose(result, float(np.interp(time, result.time, result.depth)))
    if isinstance(pose.profile, Plane):
        shape = pv.Plane(center=pose.origin, direction=pose.axis, i_size=14, j_size=14)
    elif isinstance(pose.profile, Ellipsoid) and np.isfinite(pose.profile.radii).all():
        shape = pv.ParametricEllipsoid(*pose.profile.radii, u_res=80, v_res=80)
        turn = np.eye(4)
        turn[:3, :3] = pose.frame.T
        turn[:3, 3] = pose.origin - pose.profile.radii[2] * pose.axis
        shape = shape.transform(turn, inplace=False)
    else:
        shape = _front(pose)
    plotter.add_mesh(
        shape, color="#8fa3b5", opacity=0.12 if glass else 0.55, name="indenter",
        show_edges=False,
    )  # fmt: skip
    if isinstance(pose.profile, Plane):
        edges = shape.extract_feature_edges(feature_edges=False, manifold_edges=False)
        plotter.add_mesh(edges, color="#51606e", line_width=2, name="rim")

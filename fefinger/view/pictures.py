"""Pictures and films of a Result in files, and the picture of a mesh.

Films are GIF by Pillow, MP4 by the extra `film` (imageio-ffmpeg).
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fefinger.geometry.finger_mesh import BONE, SKIN, SUBCUTANEOUS, FingerMesh
from fefinger.results.result_record import ResultRecord
from fefinger.support.arrays import Array
from fefinger.support.atomic_write import in_place
from fefinger.support.checks import InputError
from fefinger.view import figures, frames, quantities, renderer, surfaces
from fefinger.view.drawing import colors, drawing, highest_rate, titles
from fefinger.view.plot3d import FingerActor, Prop, Scales
from fefinger.view.quantities import round_up


if TYPE_CHECKING:
    from pyvista import Plotter


Picture = NDArray[np.uint8]


def check_film(path: str | PathLike[str], option: str) -> None:
    """Raise InputError of `option` unless a film can be written to `path`, a GIF or MP4 file."""
    suffix = Path(path).suffix.lower()
    if suffix not in (".gif", ".mp4"):
        raise InputError(
            f"{option}: expected a file that ends in .gif or .mp4, received {Path(path).name!r}"
        )
    if suffix == ".mp4":
        try:
            from imageio_ffmpeg import get_ffmpeg_exe

            get_ffmpeg_exe()
        except (ImportError, RuntimeError):
            raise InputError(
                f"{option}: an MP4 needs imageio-ffmpeg, which is not there; "
                "run `pip install 'fefinger[film]'`, or name a file that ends in .gif"
            ) from None


def write(path: str | PathLike[str], pictures: Iterable[Picture], fps: float) -> None:
    """Write pictures (height, width, 3) to a GIF or MP4 file, which appears when it is complete."""
    check_film(path, "film")
    with in_place(path) as new:
        (_gif if new.suffix.lower() == ".gif" else _mp4)(new, pictures, fps)


def _gif(path: Path, pictures: Iterable[Picture], fps: float) -> None:
    """Write a GIF with one palette for all pictures, so that colors do not change in time."""
    from PIL import Image

    every = [Image.fromarray(picture) for picture in pictures]
    some = Image.fromarray(np.concatenate([np.asarray(p)[::2, ::2] for p in every[::4]]))
    # MAXCOVERAGE keeps rare colors, such as the ends of the color bars.
    palette = some.quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=1)
    # Dithered: 256 colors for three color maps and their shades would show as bands.
    first, *others = [p.quantize(palette=palette) for p in every]
    duration = round(1000 / fps)
    first.save(path, save_all=True, append_images=others, duration=duration, loop=0)


def _mp4(path: Path, pictures: Iterable[Picture], fps: float) -> None:
    """Write an MP4 (H.264) that browsers play; its sides are cut to even numbers of pixels."""
    from imageio_ffmpeg import write_frames

    rest = iter(pictures)
    first = next(rest)
    height, width = (2 * (side // 2) for side in first.shape[:2])
    with closing(write_frames(str(path), (width, height), fps=fps, macro_block_size=2)) as writer:
        writer.send(None)
        for picture in chain([first], rest):
            writer.send(np.ascontiguousarray(picture[:height, :width]))


BARS = 260  # pixels of width of the color bars
BAR: dict[str, Any] = {
    "color": figures.INK,
    "vertical": True,
    "position_x": 0.3,
    "width": 0.32,
    "height": 0.2,
    "fmt": "%.3g",
    "n_labels": 5,
    "title_font_size": 21,
    "label_font_size": 21,
    "unconstrained_font_size": True,
}
PLACES = (0.7, 0.43, 0.16)  # of the lower ends of bars: at most a field, the pressure and the rate
PANEL = (880, 780)  # pixels of a view in space, beside which the color bars are
GAP, WHITE = 32, 250  # pixels between finger and color bars; least byte of what counts as white
FPS, REST = 8, 8  # pictures per second of a film, and how many its last one is shown for
LEGEND: dict[str, Any] = {
    **{"title": "region", "n_labels": 0, "vertical": False},
    **{"position_x": 0.2, "position_y": 0.05, "width": 0.6, "height": 0.08},
}
ROOM = np.array([[-0.9, -0.62], [0.9, 0.8]])
"""Corners of the finger in the picture of a mesh, from -1 to 1 across and up: the title is above
and the legend below."""
REGIONS = {SKIN: "#e8b89a", SUBCUTANEOUS: "#f4dc8c", BONE: figures.BONE}  # their colors


def compose(
    plotter: "Plotter",
    results: Sequence[ResultRecord],
    field: str,
    limits: tuple[float, float] | None = None,
    folders: Sequence[str] = (),
) -> list[FingerActor]:
    """Put results side by side into a plotter, with one set of color bars in its last column.

    Raises InputError if the field is unknown or a result has no fields.
    """
    named = zip(results, titles(results, folders), strict=True)
    drawings = [drawing(result, field, title) for result, title in named]
    scales = Scales(
        field=colors(drawings, field, limits),
        pressure=round_up(max(float(each.fields.pressure.max()) for each in drawings) or 1.0),
        rate=round_up(max(highest_rate(result) for result in results) or 1.0),
    )
    actors = []
    for column, shown in enumerate(drawings):
        plotter.subplot(0, column)
        actors.append(FingerActor(plotter, shown, field, scales))
        actors[-1].look()
    plotter.link_views(range(len(actors)))
    _add_bars(plotter, actors)
    return actors


def _add_bars(plotter: "Plotter", actors: Sequence[FingerActor]) -> None:
    """Add a color bar for each quantity that any actor is colored by; the last actor owns them."""
    keys = {label: key for actor in reversed(actors) for label, key in actor.keys.items()}
    plotter.subplot(0, len(actors))
    for place, label in zip(PLACES, actors[0].keys | keys, strict=False):
        # 23 letters fit into the line above a color bar.
        title = (label if len(label) <= 23 else label.replace(" / ", "\n/ ")) + "\n"
        mapper, needs = keys[label]
        bar = plotter.add_scalar_bar(
            title=title, mapper=mapper, position_y=place, **BAR, render=False
        )
        actors[-1].props.append(Prop(bar, needs))
    actors[-1].refresh()


def stored_times(actors: Sequence[FingerActor]) -> Array:
    """Return the stored times of all actors in s, ascending."""
    return np.unique(np.concatenate([actor.shown.fields.times for actor in actors]))


def size(columns: int) -> tuple[int, int]:
    """Return the width and height in pixels of a picture with so many views side by side."""
    return PANEL[0] * columns + BARS, PANEL[1]


def screenshot(
    results: ResultRecord | Sequence[ResultRecord],
    path: str | PathLike[str],
    field: str = quantities.DEFAULT,
    time: float | None = None,
    limits: tuple[float, float] | None = None,
    folders: Sequence[str] = (),
) -> None:
    """Draw the deformed finger in space, colored by `field`, to the PNG file `path`.

    Pressure is shown on the whole finger from below, other fields on the half finger behind the
    medial plane. Several results stand side by side on one color scale, named by their `folders`.
    The stored frame next to `time` s is drawn, by default the frame of each result's largest force;
    `limits` are the ends of the color bar. Raises InputError if there is no renderer, a result has
    no fields, the field is unknown or the time is after the end.
    """
    shown = frames.requested(results, field, time)
    plotter, actors = _actors(shown, field, limits, folders)
    for actor in actors:
        actor.at(frames.peak_time(actor.shown.result) if time is None else time)
    _finish(plotter, path)


def trimmed(picture: Array) -> Array:
    """Return a picture of one result by `screenshot` with its white margins cut off.

    Pictures are arrays (height, width, 3) of bytes.
    """
    parts = [_inked(picture[:, : PANEL[0]]), _inked(picture[:, PANEL[0] :])]
    top = min(rows.start for rows, _ in parts)
    bottom = max(rows.stop for rows, _ in parts)
    white = np.full((bottom - top, GAP, 3), 255, picture.dtype)
    finger, bars = (
        part[top:bottom, columns]
        for part, (_, columns) in zip(np.split(picture, [PANEL[0]], axis=1), parts, strict=True)
    )
    return np.pad(
        np.concatenate([finger, white, bars], axis=1),
        ((GAP // 4,) * 2, (GAP // 4,) * 2, (0, 0)),
        constant_values=255,
    )


def _inked(picture: Array) -> tuple[slice, slice]:
    """Return the rows and columns between white margins; all of a white picture."""
    ink = picture.min(axis=2) < WHITE
    spans = []
    for axis in (1, 0):
        found = np.flatnonzero(ink.any(axis=axis))
        whole = (0, ink.shape[1 - axis] - 1)
        low, high = (found[0], found[-1]) if found.size else whole
        spans.append(slice(int(low), int(high) + 1))
    return spans[0], spans[1]


def movie(
    results: ResultRecord | Sequence[ResultRecord],
    path: str | PathLike[str],
    field: str = quantities.DEFAULT,
    limits: tuple[float, float] | None = None,
    folders: Sequence[str] = (),
) -> None:
    """Draw a film of all stored times, one picture each, to the GIF or MP4 file `path`.

    Arguments as of `screenshot`. Every picture shows its time, as times are not evenly
    spaced.
    """
    check_film(path, "--movie")
    plotter, actors = _actors(frames.requested(results, field), field, limits, folders)

    def pictures() -> Iterator[Picture]:
        for time in stored_times(actors):
            for actor in actors:
                actor.at(float(time))
            plotter.render()
            yield (picture := np.array(plotter.screenshot(return_img=True)))
        yield from [picture] * REST

    try:
        write(path, pictures(), FPS)
    finally:
        plotter.close()


def _actors(
    results: Sequence[ResultRecord],
    field: str,
    limits: tuple[float, float] | None,
    folders: Sequence[str],
) -> "tuple[Plotter, list[FingerActor]]":
    """Return a plotter off-screen with an actor for each result."""
    renderer.require()
    plotter = renderer.plotter(size(len(results)), len(results), aside=BARS)
    return plotter, compose(plotter, results, field, limits, folders)


def draw_mesh(mesh: FingerMesh, path: str | PathLike[str]) -> None:
    """Draw a mesh, cut open at the medial plane and colored by region, to the PNG file `path`.

    Raises InputError where no renderer exists.
    """
    import pyvista as pv

    renderer.require()
    plotter = renderer.plotter(size(1))
    behind = mesh.points[mesh.cells][:, :, 1].mean(axis=1) > 0
    body: Any = pv.UnstructuredGrid({pv.CellType.TETRA: mesh.cells[behind]}, mesh.points)
    body["region"] = mesh.region[behind]
    kinds = [kind for kind in REGIONS if kind in body["region"]]
    bar: Any = BAR | LEGEND
    plotter.add_mesh(
        body.extract_surface(algorithm=None),
        scalars="region",
        cmap=[REGIONS[kind] for kind in kinds],
        clim=(min(kinds) - 0.5, max(kinds) + 0.5),
        annotations={float(kind): surfaces.NAMES[kind] for kind in kinds},
        n_colors=len(kinds),
        show_edges=True,
        edge_color="#6b5d52",
        scalar_bar_args=bar,
        ambient=0.6,
        diffuse=0.45,
    )
    title = f"{mesh.name}: {len(mesh.points)} points, {len(mesh.cells)} tetrahedra"
    plotter.add_text(title, font_size=16, color=figures.INK)
    plotter.view_vector((0.55, -1.0, 0.35), viewup=(0, 0, 1))  # type: ignore[arg-type]  # pyvista's decorator loses self
    _fit(plotter, mesh.points[mesh.cells[behind]].reshape(-1, 3))
    _finish(plotter, path)


def _fit(plotter: "Plotter", points: Array) -> None:
    """Zoom and shift the camera so that points (n, 3) mm fill ROOM."""
    import pyvista as pv

    camera, (width, height) = plotter.camera, plotter.window_size
    matrix = camera.GetCompositeProjectionTransformMatrix(width / height, -1.0, 1.0)
    seen = np.column_stack([points, np.ones(len(points))]) @ pv.array_from_vtkmatrix(matrix).T
    seen = seen[:, :2] / seen[:, 3:]
    zoom = float((np.ptp(ROOM, axis=0) / np.ptp(seen, axis=0)).min())
    half = np.radians(camera.view_angle) / 2.0
    camera.view_angle = float(np.degrees(2.0 * np.arctan(np.tan(half) / zoom)))
    middle = (seen.min(axis=0) + seen.max(axis=0)) / 2.0
    camera.SetWindowCenter(*(zoom * middle - ROOM.mean(axis=0)))


def _finish(plotter: "Plotter", path: str | PathLike[str]) -> None:
    """Write the picture to a PNG file and close the plotter."""
    try:
        with in_place(path) as new:
            plotter.screenshot(new)
    finally:
        plotter.close()

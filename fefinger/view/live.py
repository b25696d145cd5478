"""Live view of a finger that is pressed and rolled: pressure, strain section and spikes.

The finger is stepped at 1 kHz of its own time; the picture is drawn every FRAME of it and says how
many steps a second the machine made.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.mechanics.realtime.show import FRAME, Frame, Show, compressive, status_line
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array, Integers
from fefinger.view import film


COLORS = {"SAI": "#1b6ca8", "SAII": "#5aa469", "FAI": "#d35d6e", "FAII": "#8d6cab"}
WINDOW = 2.0  # s of spikes on screen
LARGEST_PRESSURE, LARGEST_STRAIN = 60.0, 0.35  # kPa and 1, the ends of the color bars


def section_triangles(show: Show) -> Integers:
    """Return the triangles of the medial section, in the numbers of `show.section`."""
    space = show.rolling.solid.space
    return _within(space.scalar.mesh.facets.T, show.section, len(space.points))


def _within(faces: Integers, kept: Integers, count: int) -> Integers:
    """Return the faces that have all corners among `kept`, in their numbers."""
    number = np.full(count, -1)
    number[kept] = np.arange(len(kept))
    inside = number[faces]
    return inside[(inside >= 0).all(axis=1)]


class Picture:
    """The three panels of a recording, redrawn for every frame."""

    def __init__(self, show: Show) -> None:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.show, self.figure = show, Figure(figsize=(7, 8.5), dpi=80, layout="constrained")
        self.canvas = FigureCanvasAgg(self.figure)
        self.title = self.figure.suptitle("")
        top, middle, bottom = self.figure.subplots(3, 1, height_ratios=(3, 3, 2))
        solid, vertices = show.rolling.solid, show.rolling.vertices
        triangles = _within(solid.pad, vertices, len(solid.space.points))
        x, y, _ = solid.space.points[vertices].T
        both = np.concatenate([triangles, triangles + len(x)])
        self.pressure = self._field(
            top, (np.tile(x, 2), np.concatenate([y, -y])), both, "magma", LARGEST_PRESSURE
        )
        self.figure.colorbar(self.pressure, ax=top, label="pressure, kPa")
        top.set(ylabel="y, mm", title="pad, from below")
        x, _, z = solid.space.points[show.section].T
        self.strain = self._field(
            middle, (x, z), section_triangles(show), "viridis", LARGEST_STRAIN
        )
        self.figure.colorbar(self.strain, ax=middle, label="compressive strain")
        middle.set(ylabel="z, mm", xlabel="x, mm", title="medial section")
        self._draw_raster(bottom)

    def _field(
        self,
        axes: Any,
        at: tuple[Array, Array],
        triangles: Integers,
        colors: str,
        top: float,
    ) -> Any:
        axes.set(aspect="equal")
        return axes.tripcolor(
            *at, triangles, np.zeros(len(at[0])), shading="gouraud", cmap=colors, vmin=0, vmax=top
        )

    def _draw_raster(self, axes: Any) -> None:
        axes.set(xlabel="time, s", ylabel="unit", ylim=(-1, len(self.show.organs.types)))
        self.raster, self.spikes = axes, axes.scatter([], [], s=6, marker="|")
        self.colors = np.array([COLORS[kind] for kind in self.show.organs.types])
        for kind, color in COLORS.items():
            axes.plot([], [], "|", color=color, label=kind)
        axes.legend(loc="upper left", ncols=4, fontsize="small", frameon=False)

    def draw(self, frame: Frame) -> NDArray[np.uint8]:
        """Draw a frame in the panels and return the picture, (height, width, 3)."""
        self.pressure.set_array(np.tile(frame.pressure, 2))
        self.strain.set_array(compressive(frame.strain))
        recent = [(t, unit) for unit, t in frame.spikes if t > frame.time - WINDOW]
        self.spikes.set_offsets(np.array(recent).reshape(-1, 2))
        self.spikes.set_color(self.colors[[unit for _, unit in recent]] if recent else [])
        self.raster.set_xlim(frame.time - WINDOW, frame.time + 0.05)
        self.title.set_text(status_line(frame))
        self.canvas.draw()
        return np.asarray(self.canvas.buffer_rgba())[..., :3].copy()


def record(finger: Finger, path: Path) -> Frame:
    """Draw the show into a GIF or MP4 file and return its last frame.

    Raises
    ------
    InputError
        For another kind of file, or an MP4 without the extra `film`.
    """
    film.check(path, "-o")
    show = Show(finger)
    picture, last = Picture(show), list[Frame]()

    def pictures() -> Iterator[NDArray[np.uint8]]:
        for frame in show.frames():
            last[:] = [frame]
            yield picture.draw(frame)

    film.write(path, pictures(), round(1 / FRAME))
    return last[0]

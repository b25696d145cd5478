"""`fefinger live`: half of the finger in space, pressed and rolled, and the spikes beneath it.

The finger is stepped at 1 kHz of its own time; the picture is drawn every FRAME of it and says how
many steps a second the machine made.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.scene.finger import Finger
from fefinger.support.arrays import Integers
from fefinger.support.checks import InputError
from fefinger.view import film, renderer
from fefinger.view.live_demo import FRAME, Frame, Show, compressive, status_line


COLORS = {"SAI": "#1b6ca8", "SAII": "#5aa469", "FAI": "#d35d6e", "FAII": "#8d6cab"}
WINDOW = 2.0  # s of spikes on screen
LARGEST_PRESSURE, LARGEST_STRAIN = 60.0, 0.35  # kPa and 1, the ends of the color bars
SIZE = (900, 900)
BAR: dict[str, Any] = {"color": "black", "height": 0.08, "width": 0.4, "n_labels": 3}
NOWHERE = np.full(1, -1e3)  # a point beyond the axes: VTK draws no empty series


class Window:
    """The finger seen from below, cut open: pressure on the pad, strain in the section.

    `off_screen` draws the same where there is no display.

    Raises
    ------
    InputError
        Where no window can be opened.
    """

    def __init__(self, show: Show, *, off_screen: bool = False) -> None:
        require(off_screen=off_screen)
        import pyvista as pv

        self.show = show
        parts: dict[str, Any] = {"shape": (2, 1), "row_weights": [7, 3], "border": False}
        plotter: Any = pv.Plotter(off_screen=off_screen, window_size=list(SIZE), **parts)
        plotter.set_background("white", all_renderers=True)
        self.plotter = plotter
        solid, made = show.rolling.solid, pv.PolyData.from_regular_faces
        self.pad: Any = made(solid.space.points, np.asarray(solid.pad, int))
        self.pad["pressure, kPa"] = np.zeros(len(solid.space.points))
        triangles: Any = section_triangles(show)
        self.section: Any = made(solid.space.points[show.section], triangles)
        self.section["compressive strain"] = np.zeros(len(show.section))
        self._add_finger()
        self._add_chart()
        self.text = self.plotter.add_text("", color="black", font_size=10, name="status_line")
        self.open = True
        self.plotter.show(interactive_update=True, auto_close=False)
        if not off_screen:
            self.plotter.iren.add_observer("ExitEvent", self._close)

    def draw(self, frame: Frame) -> None:
        """Draw a frame, and process the mouse and keyboard."""
        self.pad["pressure, kPa"][self.show.vertices] = frame.pressure
        self.section["compressive strain"][:] = compressive(frame.strain)
        for part in (self.pad, self.section):
            part.Modified()
        kinds = np.array(self.show.organs.types)
        recent = [(t, unit) for unit, t in frame.spikes if t > frame.time - WINDOW]
        times, units = np.array(recent).reshape(-1, 2).T
        for kind, series in self.series.items():
            same = kinds[units.astype(int)] == kind
            series.update(*((times[same], units[same]) if same.any() else (NOWHERE, NOWHERE)))
        self.chart.x_range = [frame.time - WINDOW, frame.time + 0.05]
        self.text.set_text("upper_left", status_line(frame))
        self.plotter.update()

    def _add_finger(self) -> None:
        self.plotter.subplot(0, 0)
        for part, scalars, top, colors, place in (
            (self.pad, "pressure, kPa", LARGEST_PRESSURE, "YlOrRd", 0.07),
            (self.section, "compressive strain", LARGEST_STRAIN, "viridis", 0.53),
        ):
            bar = {"title": scalars, "position_x": place, "position_y": 0.03, **BAR}
            look = {"cmap": colors, "clim": (0, top), "ambient": 0.5}
            self.plotter.add_mesh(part, scalars=scalars, scalar_bar_args=bar, **look)
        self.plotter.camera_position = [(0, -26, -32), (-6, 0, 2), (0, 0, 1)]
        self.plotter.camera.zoom(1.2)

    def _add_chart(self) -> None:
        import pyvista as pv

        self.plotter.subplot(1, 0)
        self.chart: Any = pv.Chart2D(x_label="time, s", y_label="unit")
        self.series = {
            kind: self.chart.scatter(NOWHERE, NOWHERE, color=color, size=6, style="s", label=kind)
            for kind, color in COLORS.items()
        }
        self.chart.y_range = [-1, len(self.show.organs.types)]
        self.plotter.add_chart(self.chart)
        self.plotter.subplot(0, 0)

    def _close(self, *_: object) -> None:
        self.open = False


def section_triangles(show: Show) -> Integers:
    """Return the triangles of the medial section, in the numbers of `show.section`."""
    space = show.rolling.solid.space
    number = np.full(len(space.points), -1)
    number[show.section] = np.arange(len(show.section))
    inside = number[space.scalar.mesh.facets.T]
    return inside[(inside >= 0).all(axis=1)]


def record(finger: Finger, path: Path) -> Frame:
    """Draw the show into a GIF or MP4 file and return its last frame.

    Raises
    ------
    InputError
        For another kind of file, an MP4 without the extra `film`, or where VTK cannot draw.
    """
    film.check(path, "-o")
    window, last = Window(Show(finger), off_screen=True), list[Frame]()

    def pictures() -> Iterator[film.Picture]:
        for frame in window.show.frames():
            last[:] = [frame]
            window.draw(frame)
            yield window.plotter.screenshot(return_img=True)

    film.write(path, pictures(), round(1 / FRAME))
    window.plotter.close()
    return last[0]


def watch(finger: Finger) -> Frame:
    """Show the finger in a window, as fast as it goes, and return the last frame.

    Raises
    ------
    InputError
        Where no window can be opened.
    """
    require()
    show = Show(finger)
    window = Window(show)
    for frame in show.frames():
        window.draw(frame)
        if not window.open:
            break
    return frame


def require(*, off_screen: bool = False) -> None:
    """Raise InputError where VTK cannot draw, or there is no display for a window."""
    if missing := renderer.renderer_lacking():
        raise InputError(missing)
    if not (off_screen or renderer.has_display()):
        message = "live: expected a display for a window, found none. Record with -o FILE.gif"
        raise InputError(message)

"""`fefinger live`: half a finger that a script presses and rolls, drawn with its spikes.

The finger is stepped at 1 kHz of its own time; a picture is drawn every FRAME seconds of it, with
the number of steps that the machine makes in a second.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.fem.body import Solid
from fefinger.fem.elements.probe import inside
from fefinger.geometry.voigt import tensor_from_voigt
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press import operator
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.innervation import innervation
from fefinger.support.arrays import Array, Integers
from fefinger.support.checks import InputError
from fefinger.view import film, renderer
from fefinger.view.figures import COLORS


DT, FRAME = 1e-3, 0.04  # s between steps and between pictures

SCRIPT = (  # s, mm beyond first touch, degrees
    (0.0, 0.0, 25.0),
    (0.1, 1.0, 25.0),
    (0.6, 1.0, 25.0),
    (1.2, 1.0, 15.0),
    (2.2, 1.0, 38.0),
    (2.8, 0.8, 25.0),
    (3.2, 0.8, 25.0),
    (3.3, -0.2, 25.0),
    (3.6, -0.2, 25.0),
)

DEEPEST = 1.15
"""Depth in mm for which contact is prepared: beyond that of the script, as coarse facets need."""

PLACES = 16  # of the pad, with one unit of each type below
WINDOW = 2.0  # s of spikes on screen
LARGEST_PRESSURE, LARGEST_STRAIN = 60.0, 0.35  # kPa and 1, the ends of the color bars
SIZE = (900, 900)  # pixels
NOWHERE = np.full(1, -1e3)  # a point beyond the axes: VTK draws no empty series


@dataclass(frozen=True)
class Frame:
    """What a picture shows: time s, depth mm, angle degrees, force N; pressure (n,) kPa on the pad.

    strain (n_section, 6) in the medial section; spikes so far as (unit, time in s); steps so far
    and the seconds that they took.
    """

    time: float
    depth: float
    angle: float
    force: float
    pressure: Array
    strain: Array
    spikes: tuple[tuple[int, float], ...]
    steps: int
    seconds: float

    @property
    def rate(self) -> float:
        """Steps that the machine makes in a second."""
        return self.steps / self.seconds if self.seconds > 0 else 0.0


class Show:
    """The finger, its units, and the vertices of its medial section that is drawn."""

    def __init__(self, finger: Finger) -> None:
        solid = operator.operator(finger, half=True)
        self.section = np.flatnonzero(solid.space.points[:, 1] == 0)
        self.organs = end_organs(solid)
        angles = [angle for _, _, angle in SCRIPT]
        self.rolling = Loop(
            finger, mechanics="condensed", angles=angles, deepest=DEEPEST, sites=self.organs
        )
        self.drawn = self.rolling.prepared.strains(solid.space.points[self.section])
        both = self.rolling.prepared.on_pad.patch.vertices
        self.vertices = both[: len(both) // 2]
        self.units = self.rolling.afferents()

    def frames(self) -> Iterator[Frame]:
        """Step through the script and yield its frames."""
        times, depths, angles = np.array(SCRIPT).T
        spikes: list[tuple[int, float]] = []
        seconds = 0.0
        self.rolling.reset()
        self.units.reset()
        for k in range(round(times[-1] / DT) + 1):
            at = k * DT
            depth = float(np.interp(at, times, depths))
            angle = float(np.interp(at, times, angles))
            started = time.perf_counter()
            now = self.rolling.step(DT if k else 0.0, depth=depth, angle=angle)
            self.units.step(now.strain, DT if k else 0.0)
            seconds += time.perf_counter() - started
            spikes += self.units.fired()
            if k % round(FRAME / DT) == 0:
                strain = (self.drawn @ self.rolling.prepared.contact.elastic).reshape(-1, 6)
                pressure, fired = now.pressure.copy(), tuple(spikes)
                yield Frame(at, depth, angle, now.force, pressure, strain, fired, k + 1, seconds)


def end_organs(solid: Solid) -> Sites:
    """Return one site of each type below PLACES of the pad around first touch, in one half."""
    depths = {kind: organ.depth for kind, organ in innervation().items()}
    pad = np.unique(solid.pad)
    pad = pad[solid.normals[pad][:, 2] < -0.5]
    near = pad[np.argsort(np.linalg.norm(solid.space.points[pad], axis=1))]
    near = near[:: max(1, len(near) // (4 * PLACES))][:PLACES]
    normals = np.tile(solid.normals[near], (len(depths), 1))
    deep = np.repeat(list(depths.values()), len(near))
    below = np.tile(solid.space.points[near], (len(depths), 1)) - deep[:, None] * normals
    tissue = inside(solid.space, below)
    types = np.repeat(list(depths), len(near))[tissue]
    return Sites(below[tissue], normals[tissue], deep[tissue], tuple(types.tolist()))


class Window:
    """The finger seen from below, cut open: pressure on the pad, strain in the section.

    `off_screen` draws the same where there is no display. Raises InputError where no window can be
    opened.
    """

    def __init__(self, show: Show, *, off_screen: bool = False) -> None:
        require(off_screen=off_screen)
        import pyvista as pv

        self.show = show
        plotter: Any = pv.Plotter(
            off_screen=off_screen, window_size=list(SIZE), shape=(2, 1), row_weights=[7, 3],
            border=False,
        )  # fmt: skip
        plotter.set_background("white", all_renderers=True)
        self.plotter = plotter
        made: Any
        solid, made = show.rolling.solid, pv.PolyData.from_regular_faces
        self.pad = made(solid.space.points, np.asarray(solid.pad, int))
        self.pad["pressure, kPa"] = np.zeros(len(solid.space.points))
        self.section = made(solid.space.points[show.section], section_triangles(show))
        self.section["compressive strain"] = np.zeros(len(show.section))
        self._add_part(self.pad, "pressure, kPa", LARGEST_PRESSURE, "YlOrRd", 0.07)
        self._add_part(self.section, "compressive strain", LARGEST_STRAIN, "viridis", 0.53)
        self.plotter.camera_position = [(0, -26, -32), (-6, 0, 2), (0, 0, 1)]
        self.plotter.camera.zoom(1.2)
        self.plotter.subplot(1, 0)
        self.chart = pv.Chart2D(x_label="time, s", y_label="unit")
        self.series = {
            kind: self.chart.scatter(NOWHERE, NOWHERE, color=color, size=6, style="s", label=kind)
            for kind, color in COLORS.items()
        }
        self.chart.y_range = [-1, len(show.organs.types)]
        self.plotter.add_chart(self.chart)
        self.plotter.subplot(0, 0)
        self.text = self.plotter.add_text("", color="black", font_size=10, name="status_line")
        self.open = True
        self.plotter.show(interactive_update=True, auto_close=False)
        if not off_screen:
            self.plotter.iren.add_observer("ExitEvent", self._close)

    def _add_part(self, part: object, scalars: str, top: float, colors: str, place: float) -> None:
        """Add a surface with its color bar from 0 to `top`, whose left end is at `place`."""
        self.plotter.subplot(0, 0)
        bar = {"title": scalars, "position_x": place, "position_y": 0.03, "color": "black",
               "height": 0.08, "width": 0.4, "n_labels": 3}  # fmt: skip
        self.plotter.add_mesh(
            part, scalars=scalars, scalar_bar_args=bar, cmap=colors, clim=(0, top), ambient=0.5
        )

    def draw(self, frame: Frame) -> None:
        """Draw a frame, and process the mouse and keyboard."""
        self.pad["pressure, kPa"][self.show.vertices] = frame.pressure
        principal = np.linalg.eigvalsh(tensor_from_voigt(frame.strain))
        self.section["compressive strain"][:] = np.maximum(0.0, -principal[:, 0])
        for part in (self.pad, self.section):
            part.Modified()
        kinds = np.array(self.show.organs.types)
        recent = [(t, unit) for unit, t in frame.spikes if t > frame.time - WINDOW]
        times, units = np.array(recent).reshape(-1, 2).T
        for kind, series in self.series.items():
            same = kinds[units.astype(int)] == kind
            series.update(*((times[same], units[same]) if same.any() else (NOWHERE, NOWHERE)))
        self.chart.x_range = [frame.time - WINDOW, frame.time + 0.05]
        pose = f"{frame.time:.2f} s   {frame.depth:.2f} mm at {frame.angle:.0f}°"
        speed = f"{frame.rate:.0f} steps/s = {frame.rate * DT:.2f} x real time"
        self.text.set_text("upper_left", f"{pose}   {frame.force:.2f} N   {speed}")
        self.plotter.update()

    def _close(self, *_: object) -> None:
        self.open = False


def section_triangles(show: Show) -> Integers:
    """Return the triangles (n, 3) of the medial section, in the numbers of `show.section`."""
    space = show.rolling.solid.space
    number = np.full(len(space.points), -1)
    number[show.section] = np.arange(len(show.section))
    inside = number[space.scalar.mesh.facets.T]
    return np.asarray(inside[(inside >= 0).all(axis=1)])


def record(finger: Finger, path: Path) -> Frame:
    """Draw the show into a GIF or MP4 file and return its last frame.

    Raises InputError for another kind of file, an MP4 without the extra `film`, or where VTK
    cannot draw.
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
    """Show the finger in a window, as fast as it is computed, and return the last frame.

    Raises InputError where no window can be opened.
    """
    require()
    window = Window(Show(finger))
    for frame in window.show.frames():
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

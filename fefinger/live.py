"""A finger that is pressed and rolled while one watches: pressure, strain section and spikes.

The finger is stepped at 1 kHz of its own time; the picture is drawn every FRAME of it and says how
many steps a second the machine made.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger import films, library
from fefinger.checks import InputError
from fefinger.fem.body import Solid
from fefinger.fem.probe import inside
from fefinger.mechanics import _operator
from fefinger.neural.streaming import Afferents
from fefinger.realtime import afferents
from fefinger.records import Sites
from fefinger.rolling import Rolling
from fefinger.scene import Finger


Array = NDArray[np.float64]

DT, FRAME = 1e-3, 0.04  # s
SCRIPT = (  # s, mm beyond first touch, degrees
    (0.0, 0.0, 25.0),
    (0.1, 1.0, 25.0),
    (0.6, 1.0, 25.0),
    (1.2, 1.0, 12.0),
    (2.2, 1.0, 38.0),
    (2.8, 0.8, 25.0),
    (3.2, 0.8, 25.0),
    (3.3, -0.2, 25.0),
    (3.6, -0.2, 25.0),
)
COLORS = {"SAI": "#1b6ca8", "SAII": "#5aa469", "FAI": "#d35d6e", "FAII": "#8d6cab"}
PLACES = 16  # of the pad, with one unit of each type below
WINDOW = 2.0  # s of spikes on screen
LARGEST_PRESSURE, LARGEST_STRAIN = 60.0, 0.35  # kPa and 1, the ends of the color bars
INTERACTIVE = ("qt", "tk", "gtk", "wx", "macosx", "nbagg", "webagg", "widget")


@dataclass(frozen=True)
class Frame:
    """What is on screen: s, mm, degrees, N; spikes (unit, s) so far; steps and their seconds."""

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
    """The finger, its units, and the section of it that is drawn."""

    def __init__(self, finger: Finger) -> None:
        solid = _operator.operator(finger, half=True)
        self.section = np.flatnonzero(solid.space.points[:, 1] == 0)
        self.organs = end_organs(solid)
        drawn = solid.space.points[self.section]
        count = len(drawn)
        sites = Sites(
            points=np.concatenate([self.organs.points, drawn]),
            normals=np.concatenate([self.organs.normals, np.tile([0.0, 0.0, -1.0], (count, 1))]),
            depths=np.concatenate([self.organs.depths, np.zeros(count)]),
            types=self.organs.types + ("SAI",) * count,
        )
        angles = [angle for _, _, angle in SCRIPT]
        self.rolling = Rolling(finger, angles=angles, deepest=1.1, sites=sites)
        self.units: Afferents = afferents(finger, solid, self.organs)

    def frames(self) -> Iterator[Frame]:
        """Step through the script, and stop at every frame of it."""
        times, depths, angles = np.array(SCRIPT).T
        spikes: list[tuple[int, float]] = []
        count, seconds, organs = round(times[-1] / DT), 0.0, len(self.organs.types)
        self.rolling.reset()
        self.units.reset()
        for k in range(count + 1):
            at = k * DT
            depth = float(np.interp(at, times, depths))
            angle = float(np.interp(at, times, angles))
            started = time.perf_counter()
            now = self.rolling.step(depth, angle, DT if k else 0.0)
            self.units.step(now.strain[:organs], DT if k else 0.0)
            seconds += time.perf_counter() - started
            spikes += self.units.fired()
            if k % round(FRAME / DT) == 0:
                yield Frame(
                    time=at,
                    depth=depth,
                    angle=angle,
                    force=now.force,
                    pressure=now.pressure.copy(),
                    strain=now.strain[organs:].astype(np.float64),
                    spikes=tuple(spikes),
                    steps=k + 1,
                    seconds=seconds,
                )


def end_organs(solid: Solid) -> Sites:
    """Return one site of each type below the places of the pad around first touch, in one half."""
    depths = {kind: organ.depth for kind, organ in library.receptors().items()}
    pad = np.unique(solid.pad)
    pad = pad[solid.normals[pad][:, 2] < -0.5]
    near = pad[np.argsort(np.linalg.norm(solid.space.points[pad], axis=1))]
    near = near[:: max(1, len(near) // (4 * PLACES))][:PLACES]
    points, normals = solid.space.points[near], solid.normals[near]
    kinds = list(depths)
    below = np.concatenate([points - depths[kind] * normals for kind in kinds])
    kept = inside(solid.space, below)
    types = np.repeat(kinds, len(near))[kept]
    outward = np.tile(normals, (len(kinds), 1))[kept]
    deep = np.repeat([depths[kind] for kind in kinds], len(near))[kept]
    return Sites(below[kept], outward, deep, tuple(types.tolist()))


class Picture:
    """The three panels, drawn over and over."""

    def __init__(self, show: Show, figure: Any) -> None:
        self.show, self.figure = show, figure
        self.title = figure.suptitle("")
        top, middle, bottom = figure.subplots(3, 1, height_ratios=(3, 3, 2))
        self.pressure, self.strain, self.raster = top, middle, bottom
        points = show.rolling.solid.space.points[show.rolling.vertices]
        mirrored = np.concatenate([points, points * [1.0, -1.0, 1.0]])
        self.dots = top.scatter(
            mirrored[:, 0],
            mirrored[:, 1],
            c=np.zeros(len(mirrored)),
            s=26,
            cmap="magma",
            vmin=0,
            vmax=LARGEST_PRESSURE,
        )
        figure.colorbar(self.dots, ax=top, label="pressure, kPa")
        top.set(aspect="equal", ylabel="y, mm", title="pad, from below")
        self._draw_section(np.zeros(len(show.section)))
        bottom.set(xlabel="time, s", ylabel="unit", ylim=(-1, len(show.organs.types)))
        colors = [COLORS[kind] for kind in show.organs.types]
        self.spikes = bottom.scatter([], [], s=6, marker="|")
        self.colors = np.array(colors)
        for kind, color in COLORS.items():
            bottom.plot([], [], "|", color=color, label=kind)
        bottom.legend(loc="upper left", ncols=4, fontsize="small", frameon=False)

    def _draw_section(self, values: Array) -> None:
        solid, section = self.show.rolling.solid, self.show.section
        number = np.full(len(solid.space.points), -1)
        number[section] = np.arange(len(section))
        faces = solid.space.scalar.mesh.facets.T
        triangles = number[faces]
        triangles = triangles[(triangles >= 0).all(axis=1)]
        x, _, z = solid.space.points[section].T
        self.field = self.strain.tripcolor(
            x, z, triangles, values, shading="gouraud", cmap="viridis", vmin=0, vmax=LARGEST_STRAIN
        )
        self.figure.colorbar(self.field, ax=self.strain, label="compressive strain")
        self.strain.set(aspect="equal", ylabel="z, mm", xlabel="x, mm", title="medial section")

    def draw(self, frame: Frame) -> None:
        """Bring the panels up to date."""
        self.dots.set_array(np.tile(frame.pressure, 2))
        from fefinger.fem.probe import tensors

        self.field.set_array(np.maximum(0.0, -np.linalg.eigvalsh(tensors(frame.strain))[:, 0]))
        recent = [(t, unit) for unit, t in frame.spikes if t > frame.time - WINDOW]
        self.spikes.set_offsets(np.array(recent).reshape(-1, 2))
        self.spikes.set_color(self.colors[[unit for _, unit in recent]] if recent else [])
        self.raster.set_xlim(frame.time - WINDOW, frame.time + 0.05)
        self.title.set_text(
            f"{frame.time:.2f} s   {frame.depth:.2f} mm at {frame.angle:.0f}°   "
            f"{frame.force:.2f} N   {frame.rate:.0f} steps/s = {frame.rate * DT:.2f} x real time"
        )


def record(finger: Finger, path: Path) -> Frame:
    """Draw the show into a GIF or MP4 file and return its last frame.

    Raises
    ------
    InputError
        For another kind of file, or an MP4 without the extra `film`.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    films.check(path, "-o")
    show = Show(finger)
    figure = Figure(figsize=(7, 8.5), layout="constrained", dpi=80)
    picture, canvas = Picture(show, figure), FigureCanvasAgg(figure)
    frames: list[Frame] = []

    def pictures() -> Iterator[NDArray[np.uint8]]:
        for frame in show.frames():
            frames.append(frame)
            picture.draw(frame)
            canvas.draw()
            yield np.array(canvas.buffer_rgba())[..., :3]

    films.write(path, pictures(), 1 / FRAME)
    return frames[-1]


def watch(finger: Finger) -> Frame:
    """Show the finger in a window, as fast as it goes, and return the last frame.

    Raises
    ------
    InputError
        Where no window can be opened.
    """
    from matplotlib import pyplot

    if not pyplot.get_backend().lower().startswith(INTERACTIVE):
        message = "live: expected a display for a window, found none; record with -o FILE.gif"
        raise InputError(message)
    show = Show(finger)
    figure = pyplot.figure(figsize=(7, 8.5), layout="constrained")
    picture = Picture(show, figure)
    for frame in show.frames():
        picture.draw(frame)
        pyplot.pause(1e-3)
        if not pyplot.fignum_exists(figure.number):
            break
    return frame

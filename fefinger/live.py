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

from fefinger import films
from fefinger.fem.body import Solid
from fefinger.fem.elements.probe import inside, tensors
from fefinger.mechanics.press import operator
from fefinger.mechanics.realtime.condensed import afferents
from fefinger.mechanics.realtime.rolling import Rolling
from fefinger.neural.streaming import Afferents
from fefinger.results.records import Sites
from fefinger.scene import library
from fefinger.scene.finger import Finger


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
        solid = operator.operator(finger, half=True)
        self.section = np.flatnonzero(solid.space.points[:, 1] == 0)
        self.organs = end_organs(solid)
        angles = [angle for _, _, angle in SCRIPT]
        self.rolling = Rolling(finger, angles=angles, deepest=1.1, sites=self.organs)
        self.drawn = self.rolling.strains(solid.space.points[self.section])
        self.units: Afferents = afferents(finger, solid, self.organs)

    def frames(self) -> Iterator[Frame]:
        """Step through the script, and stop at every frame of it."""
        times, depths, angles = np.array(SCRIPT).T
        spikes: list[tuple[int, float]] = []
        count, seconds = round(times[-1] / DT), 0.0
        self.rolling.reset()
        self.units.reset()
        for k in range(count + 1):
            at = k * DT
            depth = float(np.interp(at, times, depths))
            angle = float(np.interp(at, times, angles))
            started = time.perf_counter()
            now = self.rolling.step(depth, angle, DT if k else 0.0)
            self.units.step(now.strain, DT if k else 0.0)
            seconds += time.perf_counter() - started
            spikes += self.units.fired()
            if k % round(FRAME / DT) == 0:
                yield Frame(
                    time=at,
                    depth=depth,
                    angle=angle,
                    force=now.force,
                    pressure=now.pressure.copy(),
                    strain=(self.drawn @ self.rolling.elastic).reshape(-1, 6),
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


def compressive(strain: Array) -> Array:
    """Return max(0, -smallest principal strain) of (n, 6)."""
    return np.maximum(0.0, -np.linalg.eigvalsh(tensors(strain))[:, 0])


def said(frame: Frame) -> str:
    """Return the line on screen: where the plate is, and how fast the machine is."""
    return (
        f"{frame.time:.2f} s   {frame.depth:.2f} mm at {frame.angle:.0f}°   {frame.force:.2f} N   "
        f"{frame.rate:.0f} steps/s = {frame.rate * DT:.2f} x real time"
    )


def section_triangles(show: Show) -> NDArray[np.int64]:
    """Return the triangles of the medial section, in the numbers of `show.section`."""
    space = show.rolling.solid.space
    return _within(space.scalar.mesh.facets.T, show.section, len(space.points))


def _within(faces: NDArray[np.int64], kept: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return the faces that have all corners among `kept`, in their numbers."""
    number = np.full(count, -1)
    number[kept] = np.arange(len(kept))
    inside = number[faces]
    return inside[(inside >= 0).all(axis=1)]


class Picture:
    """The three panels of a recording, drawn over and over."""

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
        triangles: NDArray[np.int64],
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
        """Bring the panels up to date and return them, (height, width, 3)."""
        self.pressure.set_array(np.tile(frame.pressure, 2))
        self.strain.set_array(compressive(frame.strain))
        recent = [(t, unit) for unit, t in frame.spikes if t > frame.time - WINDOW]
        self.spikes.set_offsets(np.array(recent).reshape(-1, 2))
        self.spikes.set_color(self.colors[[unit for _, unit in recent]] if recent else [])
        self.raster.set_xlim(frame.time - WINDOW, frame.time + 0.05)
        self.title.set_text(said(frame))
        self.canvas.draw()
        return np.asarray(self.canvas.buffer_rgba())[..., :3].copy()


def record(finger: Finger, path: Path) -> Frame:
    """Draw the show into a GIF or MP4 file and return its last frame.

    Raises
    ------
    InputError
        For another kind of file, or an MP4 without the extra `film`.
    """
    films.check(path, "-o")
    show = Show(finger)
    picture, last = Picture(show), list[Frame]()

    def pictures() -> Iterator[NDArray[np.uint8]]:
        for frame in show.frames():
            last[:] = [frame]
            yield picture.draw(frame)

    films.write(path, pictures(), round(1 / FRAME))
    return last[0]

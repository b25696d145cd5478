"""A finger that is pressed and rolled by a script, with its afferents, frame by frame."""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fefinger.fem.body import Solid
from fefinger.fem.elements.probe import inside
from fefinger.geometry.voigt import tensor_from_voigt
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press import operator
from fefinger.results.records import Sites
from fefinger.scene.finger import Finger
from fefinger.scene.innervation import innervation
from fefinger.support.arrays import Array


DT, FRAME = 1e-3, 0.04  # s

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


@dataclass(frozen=True)
class Frame:
    """State on screen: s, mm, degrees, N; spikes (unit, s) so far; steps and their seconds."""

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
        count, seconds = round(times[-1] / DT), 0.0
        self.rolling.reset()
        self.units.reset()
        for k in range(count + 1):
            at = k * DT
            depth = float(np.interp(at, times, depths))
            angle = float(np.interp(at, times, angles))
            started = time.perf_counter()
            now = self.rolling.step(DT if k else 0.0, depth=depth, angle=angle)
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
                    strain=(self.drawn @ self.rolling.prepared.contact.elastic).reshape(-1, 6),
                    spikes=tuple(spikes),
                    steps=k + 1,
                    seconds=seconds,
                )


def end_organs(solid: Solid) -> Sites:
    """Return one site of each type below the places of the pad around first touch, in one half."""
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


def compressive(strain: Array) -> Array:
    """Return max(0, -smallest principal strain) of (n, 6)."""
    return np.maximum(0.0, -np.linalg.eigvalsh(tensor_from_voigt(strain))[:, 0])


def status_line(frame: Frame) -> str:
    """Return the status line: pose of the plate, force, and speed of the computation."""
    return (
        f"{frame.time:.2f} s   {frame.depth:.2f} mm at {frame.angle:.0f}°   {frame.force:.2f} N   "
        f"{frame.rate:.0f} steps/s = {frame.rate * DT:.2f} x real time"
    )

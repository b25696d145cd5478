"""What the page draws: the shape once, and for every frame where it is and its colors."""

from dataclasses import dataclass
from typing import cast

import numpy as np

from fefinger.geometry.finger_mesh import Halves
from fefinger.live.player import RELAXED
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.press import placement
from fefinger.neural.trains import FEW
from fefinger.pages import viewer
from fefinger.pages.viewer import Blob, Json
from fefinger.results.records import Fields
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array
from fefinger.support.tensors import tensor_from_voigt
from fefinger.view import figures, frames, quantities, surfaces
from fefinger.view.drawing import OFF_PLANE
from fefinger.view.frames import Pose
from fefinger.view.quantities import Span


STRAIN, PRESSURE = "compressive strain", "pressure"


@dataclass(frozen=True)
class Shape:
    """What stays of a picture: a JSON table, and the buffer of its arrays."""

    table: Json
    arrays: bytes


class Picture:
    """The finger of a loop, cut open and whole, as of its present state."""

    def __init__(self, loop: Loop) -> None:
        self.loop = loop
        self._unit = unit = loop.prepared.fields()
        mesh, count = unit.mesh, len(unit.mesh.points)
        at_rest = Fields(
            mesh.points, mesh.cells, mesh.region, np.zeros(1),
            displacement=np.zeros((1, count, 3)),
            strain=np.zeros((1, count, 6)),
            pressure=np.zeros((1, count)),
        )  # fmt: skip
        at_rest.pressure[0, unit.pad] = 1.0
        self._halves = Halves.of(mesh.points, 1e-9 * float(np.ptp(mesh.points)))
        self._half = frames.is_half(mesh.points)
        whole = frames.whole(at_rest)
        self._points = whole.points
        self._surfaces = (*surfaces.cut_open(whole, inner=False), *surfaces.other_half(whole))
        self._lines = surfaces.outlines(whole)
        sites = loop.sites
        chosen = np.arange(len(sites.types))
        if len(chosen) > FEW:
            chosen = np.flatnonzero(np.abs(sites.points[:, 1]) <= OFF_PLANE)
        self._types = [sites.types[k] for k in chosen]
        self._labels = [f"{sites.types[k]} {sites.depths[k]:g} mm" for k in chosen]
        self._marks = surfaces.follow(whole, sites.points[chosen])

    def shape(self) -> Shape:
        """Return the part of the picture that is the same in all frames."""
        blob = Blob()
        spans = self._spans()
        table: Json = {
            **viewer.shape(self._surfaces, self._lines, blob),
            "rest": blob.add(viewer.at(self._surfaces, self._points), "f4"),
            "lineCount": len(self._lines.edges),
            "labels": self._labels,
            "colors": [figures.COLORS[kind] for kind in self._types],
            "indenter": viewer.surface(self._pose(), blob),
            "fields": {name: viewer.bar(span, name) for name, span in spans.items()},
            "maps": {viewer.color_map(span): viewer.colors_of(span) for span in spans.values()},
            "few": FEW,
        }
        return Shape(table, bytes(blob))

    def frame(self) -> bytes:
        """Return the present places and colors as little-endian floats.

        Places (n, 3) mm, compressive strain (n,) in % and pressure (n,) kPa of the vertices, then
        the places of the lines and of the end organs.
        """
        displacement, strain, pressure = self._values()
        places = self._points + displacement
        parts = (
            *(viewer.at(self._surfaces, each) for each in (places, strain, pressure)),
            *(self._lines.at(places), self._marks.moved(displacement)),
        )
        return np.concatenate([np.ravel(part) for part in parts]).astype("<f4").tobytes()

    def _values(self) -> tuple[Array, Array, Array]:
        """Displacement (n_points, 3) mm of the whole finger, strain (n_points,) %, pressure kPa."""
        loop, unit = self.loop, self._unit
        elastic = loop.prepared.contact.elastic.astype(np.float32)  # half the memory is read
        moved, strain = (
            np.asarray(np.tensordot(elastic, each, 1), np.float64)
            for each in (unit.displacement, unit.strain)
        )
        principal = np.asarray(np.linalg.eigvalsh(tensor_from_voigt(strain))[:, 0], np.float64)
        pressure = np.zeros(len(moved))
        pressure[unit.pad] = loop.now.pressure
        compression = np.maximum(-100.0 * principal, 0.0)
        if not self._half:
            return moved, compression, pressure
        halves = self._halves
        return halves.vectors(moved), halves.values(compression), halves.values(pressure)

    def _spans(self) -> dict[str, Span]:
        """Return the ranges of colors, of a finger held at its largest depth; it is at rest then.

        All of it is relaxed there: forces of a quick press are larger.
        """
        self.loop.rest(RELAXED, depth=self.loop.deepest)
        _, strain, pressure = self._values()
        self.loop.reset()
        shown = {STRAIN: strain, PRESSURE: pressure}
        return {
            name: quantities.span([values], name)._replace(extend="max")
            for name, values in shown.items()
        }

    def _pose(self) -> Pose:
        """Return the object at first touch."""
        indenter = cast(Indenter, self.loop.indenter)  # as of a setup
        first = placement.obstacle(indenter, self.loop.solid)
        return Pose(first.origin, first.axis, first.profile, first.roll)

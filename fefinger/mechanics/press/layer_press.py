"""Press and slide of any object on exact layers, on a grid as fine as the object and the ridges.

Contact is solved at the times that resolve the motion and the texture; in between, strain is a
cubic spline in time, so that it has a second derivative for FAII.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from fefinger.contact.gridded import GridContact, GridFriction, GridStepper, SoftGridContact
from fefinger.contact.stepper import Prescribed, Record, collected
from fefinger.geometry.profiles import frame
from fefinger.mechanics.press.axisymmetric import Touch
from fefinger.mechanics.press.layer_gap import LayerGap, first_touch, pad_of, window
from fefinger.mechanics.press.layer_grid import LayerGrid, StrainProbe, object_compliance
from fefinger.mechanics.press.mesh_limits import check_reached
from fefinger.mechanics.press.notes import told
from fefinger.mechanics.press.sites import end_organ_sites, spherical
from fefinger.mechanics.press.time_steps import time_grid
from fefinger.neural.drives import Reference
from fefinger.results.records import Lateral, Response, Sites
from fefinger.scene.indenter import direction
from fefinger.scene.indenters import STANDARD
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array, Flags
from fefinger.support.checks import InputError
from fefinger.support.progress import Stages
from fefinger.support.units import NEWTON_PER_MILLINEWTON


CHUNK = 256
"""Times or components that are interpolated at once."""


IMAGES = (
    "The grid repeats the contact at its period: in the contact that changes the displacement by "
    "at most {share:.1g} of the largest one, once its mean is taken away."
)


@dataclass(frozen=True)
class LayerPress:
    """A scene on a grid of layers; InputError for an object that is placed beyond the pad."""

    scene: Scene
    grid: LayerGrid

    @cached_property
    def first(self) -> Touch:
        """First touch."""
        first = first_touch(self.scene.finger, self.scene.indenter)
        if first is None:
            raise InputError(
                f"indenter.at: expected a place on the pad, a sphere of "
                f"{self.scene.finger.pad_radius:g} mm under the 30 degree plate, received "
                f"{self.scene.indenter.place}"
            )
        return first

    @cached_property
    def gap(self) -> LayerGap:
        """Gap at a depth of 0."""
        return LayerGap.of(self.scene, self.first.axis, self.grid)

    @cached_property
    def sites(self) -> Sites | None:
        """End organs, where strain is asked."""
        ask, finger = self.scene.ask, self.scene.finger
        if not (ask.wants("strain") or ask.spikes):
            return None
        skin = partial(spherical, finger.pad_radius, direction(STANDARD))
        return end_organ_sites(ask, finger.pulp, self.first.origin, self.first.axis, skin)

    @cached_property
    def time(self) -> Array:
        """Times (n_t,) s of the response."""
        return self._times(fast="FAII" in self.scene.ask.spikes)

    def _times(self, *, fast: bool, refine: int = 1) -> Array:
        motion = self.scene.motion
        feature = self.scene.indenter.feature if motion.slides else math.inf
        return time_grid(motion, fast=fast, feature=feature, refine=refine)

    def solve(self, stages: Stages, *, refine: int = 1) -> "Solved":
        """March the contact through the motion; `refine` divides every step."""
        motion, time = self.scene.motion, self._times(fast=False, refine=refine)
        contact = self._contact()
        value = motion.value(time) / (NEWTON_PER_MILLINEWTON if motion.by_force else 1.0)
        prescribed = Prescribed(motion.control, time, value, motion.shift(time))
        read = self._reader(contact)
        with stages.stage("contact") as report:
            return Solved(time, collected(contact, prescribed, read, report))

    def _contact(self) -> GridStepper:
        grid, indenter, branches = self.grid, self.scene.indenter, self.scene.finger.prony.branches
        shape, rest = (grid.points, grid.points), (grid.spacing, self.gap, branches)
        if indenter.soft_body is not None:
            own = object_compliance(indenter.soft_body, grid)
            soft = own, indenter.soft_prony.branches
            return SoftGridContact(soft, grid.compliance, shape, *rest)
        if not indenter.friction:
            return GridContact(grid.compliance, shape, *rest)
        return GridFriction(grid.flexibility, shape, (indenter.friction, indenter.kinetic), *rest)

    @cached_property
    def block(self) -> int:
        """Side in points of a block whose mean pressure is kept."""
        wider = 2.2  # width of the skin under a motion, over the radius of the contact
        side = min(self.grid.period, wider * 2 * self.grid.width) / self.grid.spacing
        # Pressures that a response holds, 240 MB; of more the means of blocks of points are.
        held = 30_000_000
        return max(1, math.ceil(side * math.sqrt(len(self.time) / held)))

    def _reader(self, contact: GridStepper) -> Callable[[], Record]:
        """Return the function that reads a contact after each step."""
        n, sites, block = self.grid.points, self.sites, self.block
        places, edge = self.grid.places.reshape(-1, 2), border(n).ravel()
        friction, probe = isinstance(contact, GridFriction), None
        if sites is not None:
            probe = StrainProbe(self.grid, *placed(self.first, sites), friction=friction)
        looked = np.zeros(2)  # the largest force, and what images leave there

        # Growth of the force after which the error by periodic images is estimated again.
        risen = 1.1

        def read() -> Record:
            p, area = contact.pressure, contact.area
            if contact.force > risen * looked[0]:
                looked[:] = contact.force, self._images(contact)
            total = float(p.sum())
            center = p @ places / total if total else np.full(2, np.nan)
            row: Record = {
                "depth": contact.depth,
                "force": contact.force,
                "area": np.count_nonzero(p) * area,
                "moment": p @ places * area,
                "push": self.gap.push((contact.pose[0], contact.pose[1]), p) * area,
                "bordering": bool(p[edge].any()),
                "images": looked[1],
            }
            if isinstance(contact, GridFriction):
                row |= gripped(contact, places, center)
            if self.scene.ask.wants("pressure"):
                row["pressure"] = blocks(p.reshape(n, n), block).astype(np.float32)
            if probe is not None:
                row["strain"] = probe.strain(contact.elastic)
            return row

        return read

    def _images(self, contact: GridStepper) -> float:
        """Return the displacement by periodic images over the largest one in the contact."""
        shape = (self.grid.points, self.grid.points)
        pressure = contact.pressure.reshape(shape)
        moved = contact.displacement(contact.solver.x)[: pressure.size].reshape(shape)
        return self.grid.images(pressure, moved) / float(np.abs(moved[pressure > 0]).max())


def gripped(contact: GridFriction, places: Array, center: Array) -> Record:
    """Return the friction of a contact.

    Pull (2,) mN, its torque in mN mm about the center (2,) mm of pressure, the area that sticks in
    mm², the work lost in µJ, and the distance from Coulomb's law.
    """
    (first, second), area = contact.traction, contact.area
    x, y = (places - np.nan_to_num(center)).T
    return {
        "pull": contact.traction.sum(axis=1) * area,
        "torque": float(x @ second - y @ first) * area,
        "stick": np.count_nonzero(contact.sticking) * area,
        "lost": contact.lost,
        "cone": contact.coulomb.residual,
    }


@dataclass(frozen=True)
class Solved:
    """A solved motion: times (n,) s, and values (n, ...) that were read, by name."""

    time: Array
    rows: Mapping[str, Array]

    def smooth(self, values: Array, time: Array) -> Array:
        """Return values at times (n_t,) s by a cubic spline, whose second derivative is smooth."""
        if self._same(time):
            return values
        flat = values.reshape(len(values), -1)
        out = np.empty((len(time), flat.shape[1]))
        for start in range(0, flat.shape[1], CHUNK):
            part = slice(start, start + CHUNK)
            out[:, part] = CubicSpline(self.time, flat[:, part])(time)
        return out.reshape(-1, *values.shape[1:])

    def joined(self, name: str, time: Array) -> Array:
        """Return values at times (n_t,) s by lines."""
        values = self.rows[name]
        if self._same(time):
            return np.asarray(values, dtype=np.float64)
        return linear(self.time, values, time)

    def _same(self, time: Array) -> bool:
        # exact: both are made by `time_grid`, and are the same without FAII
        return np.array_equal(time, self.time)


def linear(at: Array, values: Array, time: Array) -> Array:
    """Join values (n, ...) at times (n,) by lines, at times (n_t,)."""
    after = np.clip(np.searchsorted(at, time), 1, len(at) - 1)
    part = (time - at[after - 1]) / (at[after] - at[after - 1])
    part = part.reshape(-1, *(1,) * (values.ndim - 1))
    out = np.empty((len(time), *values.shape[1:]))
    for start in range(0, len(time), CHUNK):
        k = slice(start, start + CHUNK)
        out[k] = values[after[k] - 1] * (1 - part[k]) + values[after[k]] * part[k]
    return out


def blocks(values: Array, size: int) -> Array:
    """Return the means (m, m) of square blocks of `size` points; beyond the grid there is 0."""
    if size == 1:
        return values
    short = -len(values) % size
    padded = np.pad(values, ((0, short), (0, short)))
    m = len(padded) // size
    return np.asarray(padded.reshape(m, size, m, size).mean(axis=(1, 3)))


def placed(first: Touch, sites: Sites) -> tuple[Array, Array]:
    """Return where sites lie under the flat skin of a grid, (n, 2) mm, and their depths (n,)."""
    over = sites.points + sites.depths[:, None] * sites.normals - first.origin
    return over @ frame(first.axis)[:2].T, sites.depths


def turned(strain: Array, first: Touch, sites: Sites) -> Array:
    """Return strains (n_t, n, 3, 3) in the frame of the finger; z runs along a site's normal."""
    inward = -sites.normals
    u = frame(first.axis)[0]
    one = u - (inward @ u)[:, None] * inward
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    rows = np.stack([one, np.cross(inward, one), inward], axis=1)
    return np.asarray(np.swapaxes(rows, 1, 2) @ strain @ rows)


def border(points: int) -> Flags:
    """Flag the points (n, n) at the border of a grid."""
    inside = np.zeros((points, points), dtype=bool)
    edge = 2  # grid points at the border of a grid that contact must not reach
    inside[edge:-edge, edge:-edge] = True
    return ~inside


def respond(
    scene: Scene,
    grid: LayerGrid,
    reference: Callable[[], Reference],
    stages: Stages,
    *,
    mechanics: str,
    notes: tuple[str, ...],
    refine: int = 1,
) -> Response:
    """Solve a scene on a grid; `reference` gives the press that scales strain.

    InputError if contact reaches the end of the object or of the grid. ConvergenceError if a
    contact is not found.
    """
    press, motion = LayerPress(scene, grid), scene.motion
    solved = press.solve(stages, refine=refine)
    rows = solved.rows
    _check(scene, grid, rows)
    time = press.time
    parts: dict[str, Any] = {}
    if scene.ask.wants("pressure"):
        with stages.stage("pressure"):
            parts |= _pressure(press, solved, time)
    if press.sites is not None:
        with stages.stage("strain"):
            strain = turned(rows["strain"], press.first, press.sites)
            parts |= {"sites": press.sites, "strain": solved.smooth(strain, time)}
    if motion.slides or scene.indenter.friction:
        parts["lateral"] = _lateral(scene, solved, time)
    return Response(
        mechanics=mechanics,
        time=time,
        depth=solved.joined("depth", time) if motion.by_force else motion.value(time),
        force=solved.joined("force", time) * NEWTON_PER_MILLINEWTON,
        reference=reference() if scene.ask.spikes else None,
        status=f"Solved: the contact on {grid.points} x {grid.points} points at {len(solved.time)} "
        "times, each gap closed to 1e-6 of the largest displacement.",
        seconds=stages.seconds,
        notes=(*notes, IMAGES.format(share=float(rows["images"].max()))),
        numbers={
            "grid_points": grid.points,
            "grid_spacing_mm": grid.spacing,
            "images_over_displacement": float(rows["images"].max()),
        },
        **parts,
    )


def _lateral(scene: Scene, solved: Solved, time: Array) -> Lateral:
    """Return path, lateral force, and friction where there is any; of traction only its sum."""
    motion, unit = scene.motion, NEWTON_PER_MILLINEWTON
    shift, push = motion.shift(time), solved.joined("push", time) * unit
    if not scene.indenter.friction:
        return Lateral(shift, push)
    rows, moving = solved.rows, np.linalg.norm(motion.velocity(solved.time), axis=-1) > 0
    path, cone = motion.shift(solved.time), float(rows["cone"].max())
    return Lateral(
        shift,
        push + solved.joined("pull", time) * unit,
        torque=solved.joined("torque", time) * unit,
        stick_area=solved.joined("stick", time),
        work=solved.joined("lost", time) * 1e-3,  # mJ from µJ
        outcome=told(solved.time, rows["area"], rows["stick"], path, moving, cone),
    )


def _check(scene: Scene, grid: LayerGrid, rows: Mapping[str, Array]) -> None:
    """Check that the press went no deeper than the tissue, and no wider than the grid."""
    check_reached(scene.motion, scene.finger.pulp, float(rows["depth"].max()))
    if rows["bordering"].any():
        raise InputError(
            f"motion: expected a contact within the {grid.period:.3g} mm of skin that are solved, "
            "received one that reaches their border; press less, or keep the object over the pad"
        )


def _pressure(press: LayerPress, solved: Solved, time: Array) -> dict[str, Any]:
    """Return the quantities of a Response that are read from the pressure."""
    kept, across = solved.rows["pressure"], frame(press.first.axis)[:2]
    part = window(kept)
    inside = Solved(solved.time, {"pressure": kept[:, part[0], part[1]]})
    pressure = inside.joined("pressure", time).reshape(len(time), -1)
    force = solved.joined("force", time)[:, None]
    # The moment is 0 without contact, where there is no center to join to the next.
    center = np.full((len(time), 2), np.nan)
    np.divide(solved.joined("moment", time), force, out=center, where=force > 0)
    return {
        "pad": pad_of(press.first, press.grid, press.gap, press.block, part),
        "pressure": pressure,
        "contact_area": solved.joined("area", time),
        "centroid": (press.first.origin + center @ across)[:, :2],
    }

"""What a tactile finger feels at a step."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse

from fefinger.contact.pad_worlds import Softness
from fefinger.support.arrays import Array, Flags, Floats, Integers


VERDICTS = (
    "",
    "the object is deeper in the skin than `deepest`",
    "contact has reached the border of the pad",
    "the object moved deeper than `deepest` through the skin within the step",
    "no contact was found that obeys the laws of contact: the state is as before",
)
"""Reasons why a step is not valid, by its verdict."""


@dataclass(frozen=True)
class Maps:
    """What readings are linear in, of one finger.

    compliance A (3n, 3n) mm³/kPa; strain (6 n_sites, 3n) per elastic traction in kPa; taxels
    (n_taxels, n) N/kPa, whose columns add up to the areas; areas (n,) mm².
    """

    compliance: Floats
    strain: Array
    taxels: sparse.csr_matrix
    areas: Array


class TouchError(NamedTuple):
    """Errors of force, contact area and strain at the end organs, each over the largest so far.

    What 95 % of the presses of a.h. keep at this depth that the factor of finite strain was not
    fitted to, whatever finger and object this is (nan: deeper, small strain alone, or a soft
    object).
    """

    force: Array
    area: Array
    strain: Array


@dataclass(frozen=True)
class Touch:
    """Contact of a finger at the end of a step; with leading axis `worlds` where poses had one.

    Vectors are in the frame of the finger, x distal, z dorsal.

    wrench (bodies, 6): force in N and moment in N mm about the origin, on the finger; depth
    (bodies,) mm: deepest penetration of the undeformed skin, into the deformed object where
    that is soft; contact_area and stick_area (bodies,) mm²; pressure (n,) kPa and traction (n,
    3) kPa at the vertices of the pad; slip (n, 3) mm of the skin over the object in this step;
    touched (n,): the object near each vertex, or -1; valid: whether the step is within what the
    finger can answer, else `reason` says why not; error: what is known of the errors at this
    depth.
    """

    wrench: Array
    depth: Array
    contact_area: Array
    stick_area: Array
    pressure: Array
    traction: Array
    slip: Array
    touched: Integers
    verdict: Integers
    error: TouchError
    linear: Array = field(repr=False)
    frame: Array = field(repr=False)
    hit: Array = field(repr=False)
    stiffness: Array = field(repr=False)
    friction: float
    maps: Maps = field(repr=False)
    soft: Softness | None = field(default=None, repr=False)

    @property
    def valid(self) -> Flags:
        """Whether the finger can answer the step (() or (worlds,))."""
        return np.asarray(self.verdict == 0)

    @property
    def reason(self) -> str | list[str]:
        """Why it is not valid, "" if it is; a list with worlds."""
        if self.verdict.ndim == 0:
            return VERDICTS[int(self.verdict)]
        return [VERDICTS[each] for each in self.verdict.tolist()]

    @cached_property
    def taxels(self) -> Array:
        """Force (n_taxels, 3) N on the skin under each taxel; together they are the force."""
        n = self.traction.shape[-2]
        flat = np.moveaxis(self.traction, -2, 0).reshape(n, -1)
        forces = (self.maps.taxels @ flat).reshape(-1, *self.traction.shape[:-2], 3)
        return np.asarray(np.moveaxis(forces, 0, -2))

    @cached_property
    def strain(self) -> Array:
        """Strain (n_sites, 6) at the end organs: xx yy zz xy yz xz of the tensor."""
        loaded = np.flatnonzero(self.linear.any(axis=tuple(range(self.linear.ndim - 1))))
        strain = self.linear[..., loaded] @ self.maps.strain[:, loaded].T
        return np.asarray(strain.reshape(*strain.shape[:-1], -1, 6))

    @cached_property
    def tangent(self) -> Array:
        """Stiffness (bodies, 6, 6) of the wrench, in N, N mm per mm and rad of an object's motion.

        d wrench = tangent @ (translation, rotation about the origin), of contact that stays where
        it is: vertices that stick follow the object, those that slip stay at the bound of friction.
        The turn of the directions of pressure is left out. Objects on one pad are coupled; the
        rows of one object follow its own motion.
        """
        if self.verdict.ndim == 0:
            return self._tangent(())
        return np.array([self._tangent((w,)) for w in range(len(self.verdict))])

    def _tangent(self, world: tuple[int, ...]) -> Array:
        bodies = self.wrench.shape[-2]
        tangent, pressure = np.zeros((bodies, 6, 6)), self.pressure[world]
        active = np.flatnonzero(pressure > 0)
        if len(active) == 0:
            return tangent
        rows, columns, owner = self._directions(world, active)
        compliance = self.maps.compliance.reshape(len(pressure), 3, len(pressure), 3)
        block = compliance[owner][:, :, owner].astype(float)
        flexibility = np.einsum("ic,icjd,jd->ij", rows, block, columns)
        flexibility += self._given_way(world, owner)
        areas, hit = self.maps.areas[owner, None], self.hit[world][owner]
        moved = np.hstack([areas * rows, np.cross(hit, rows)])
        wrench = np.hstack([areas * columns, np.cross(hit, columns)])
        touched = self.touched[world][owner]
        for b in range(bodies):
            own = touched == b
            only = np.where(own[:, None], moved, 0.0)
            response = np.linalg.solve(flexibility, only) * self.stiffness[world]
            tangent[b] = 1e-3 * wrench[own].T @ response[own]
        return tangent

    def _given_way(self, world: tuple[int, ...], owner: Integers) -> Array | float:
        """Return g t C (k, k) of vertices (k,) that touch the same soft object."""
        if self.soft is None:
            return 0.0
        touched = self.touched[world][owner]
        body = np.where(touched >= 0, self.soft.body[touched], -1)
        same = (touched[:, None] == touched) & (body >= 0)[:, None]
        own = self.soft.matrix[body[:, None], owner[:, None], owner]
        return np.where(same, own, 0.0) * self.stiffness[world]

    def _directions(
        self, world: tuple[int, ...], active: Integers
    ) -> tuple[Array, Array, Integers]:
        """Return constraint and force directions (k, 3) of the unknowns, and their vertices (k,).

        The pressure of a vertex that slips takes its traction along.
        """
        frame, traction = self.frame[world], self.traction[world][active]
        normal = frame[0, active]
        if not self.friction:
            return normal, normal, active
        pressure = self.pressure[world][active, None]
        across = traction - np.sum(traction * normal, axis=1, keepdims=True) * normal
        size = np.linalg.norm(across, axis=1)
        stuck = size < self.friction * pressure[:, 0] * (1 - 1e-6)
        pull = normal + np.where(stuck[:, None], 0.0, across / pressure)
        held = active[stuck]
        rows = np.vstack([normal, frame[1, held], frame[2, held]])
        columns = np.vstack([pull, frame[1, held], frame[2, held]])
        return rows, columns, np.concatenate([active, held, held])

"""A scene with the derived quantities of the rules of refusal, error and cost, cached."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

from fefinger.mechanics.evidence import presses
from fefinger.mechanics.evidence.presses import Features
from fefinger.mechanics.press.mesh_limits import refinement_location
from fefinger.mechanics.press.notes import Reason
from fefinger.mechanics.press.time_steps import MOST_OF_FORCE, moving, time_grid, too_long
from fefinger.scene.ask import OUTPUTS, Ask
from fefinger.scene.finger import AUTO, RESOLUTIONS, Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


@dataclass(frozen=True)
class Situation:
    """A scene on one candidate mesh, with cached derived quantities that the planner's rules read.

    Such as depth ratio, times and features. Each is computed when it is first read, and
    shared by all mechanics that are rated on that mesh.
    """

    finger: Finger
    indenter: Indenter
    motion: Motion
    ask: Ask

    @classmethod
    def of(cls, scene: Scene) -> Self:
        """Return the situation of a scene, on the mesh that it states or the standard one.

        Outputs that the scene leaves open are asked for.
        """
        return cls(scene.finger, scene.indenter, scene.motion, scene.ask.settled(OUTPUTS))

    def on(self, resolution: str) -> "Situation":
        """Return the situation on the mesh of a resolution; the same object at every call."""
        if resolution == self.finger.resolution:
            return self
        if resolution not in self._on:
            finger = replace(self.finger, resolution=resolution)
            self._on[resolution] = replace(self, finger=finger)
        return self._on[resolution]

    @cached_property
    def _on(self) -> "dict[str, Situation]":
        return {}

    @cached_property
    def meshes(self) -> "tuple[Situation, ...]":
        """The situation on each mesh that may be chosen: one if the scene states its mesh.

        With spikes the coarsest mesh is left out, as their counts are checked on a coarser one.
        """
        if self.finger.resolution != AUTO:
            return (self,)
        return tuple(map(self.on, RESOLUTIONS[1:] if self.ask.spikes else RESOLUTIONS))

    @property
    def mesh(self) -> str:
        """Resolution of the mesh."""
        return self.finger.mesh

    @cached_property
    def half(self) -> bool:
        """Whether the scene is its own mirror image, so that half a finger answers it."""
        return self.indenter.mirrored and self.motion.mirrored

    @cached_property
    def touch(self) -> float | tuple[float, float] | None:
        """Center of the fine part of the mesh, as `touch` of `mesh.recipe.Recipe`."""
        return refinement_location(self.indenter)

    @cached_property
    def times(self) -> Array:
        """Times (n_t,) s of the answer, also of more than a contact can have (`too_long`).

        InputError for more than any mechanics can answer, which are not counted one by one.
        """
        return time_grid(self.motion, most=MOST_OF_FORCE, **self._resolved)

    @cached_property
    def changes(self) -> int:
        """Number of time steps in which the contact changes."""
        return moving(self.motion, self.times)

    @property
    def feels_texture(self) -> bool:
        """Whether strain or spikes are asked where a texture slides over the skin."""
        felt = self.ask.wants("strain") or bool(self.ask.spikes)
        return felt and self.motion.slides and math.isfinite(self.indenter.feature)

    @cached_property
    def too_long(self) -> tuple[Reason, ...]:
        """Reasons against time steps of the motion that exceed memory; empty if they fit."""
        return tuple(Reason("motion", each) for each in too_long(self.motion, **self._resolved))

    @cached_property
    def _resolved(self) -> "dict[str, Any]":
        feature = self.indenter.feature if self.motion.slides else math.inf
        return {"fast": "FAII" in self.ask.spikes, "feature": feature}

    @cached_property
    def features(self) -> Features:
        """What compares the scene with measured presses."""
        return Features.of(self.finger, self.indenter)

    @cached_property
    def as_pressed(self) -> bool:
        """Whether the finger has the form and the bone of those that were pressed."""
        return presses.as_pressed(self.finger)

    @cached_property
    def depth_over_thickness(self) -> float:
        """Largest depth over the finger's thickness, once tissue has relaxed.

        Where the motion prescribes the force, it is read from the press nearest to the scene.
        """
        if self.motion.deepest is not None:
            return self.motion.deepest / self.finger.thickness
        thickness, modulus = self.finger.thickness, self.finger.subcutaneous.modulus
        return presses.pressed(self.features).depth_under(self.motion.peak, thickness, modulus)

"""The real-time classes before `ff.Loop`, for one version: thin constructors, which say so."""

import warnings
from collections.abc import Sequence
from functools import cached_property
from typing import Any

from numpy.typing import ArrayLike

from fefinger.contact.frictionless import FrictionlessContact
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.loop_setup import CONDENSED, MODAL, SUBSTEP
from fefinger.mechanics.vibrations import Vibrations
from fefinger.results.records import Fields, Harmonic, Step
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import STANDARD
from fefinger.support.arrays import Array
from fefinger.support.tolerances import COMPLEMENTARITY


class _Former(Loop):
    """A loop with the steps of a former class."""

    instead: str

    def __init__(self, finger: Finger, indenter: Any = STANDARD, **options: Any) -> None:
        name = type(self).__name__
        warnings.warn(
            f"ff.{name} is ff.Loop now and goes with the next version: {self.instead}",
            DeprecationWarning,
            stacklevel=2,
        )
        super().__init__(finger, indenter, **options)

    def step_force(self, force: float, dt: float) -> Step:
        """Load the indenter with `force` N in `dt` s."""
        return super().step(dt, force=force)


class Pressed(_Former):
    """`ff.Loop(finger, indenter)`."""

    instead = "ff.Loop(finger, indenter).step(dt, depth=...)"

    def step(self, depth: float, dt: float) -> Step:  # type: ignore[override]  # as it was
        """Move the indenter to `depth` mm in `dt` s."""
        return super().step(dt, depth=depth)


class Condensed(_Former):
    """`ff.Loop(finger, indenter, mechanics="condensed")`."""

    instead = 'ff.Loop(finger, indenter, mechanics="condensed").step(dt, depth=...)'

    def __init__(self, finger: Finger, indenter: Any = STANDARD, **options: Any) -> None:
        tolerance = options.pop("tolerance", COMPLEMENTARITY)
        super().__init__(finger, indenter, mechanics=CONDENSED, **options)
        contact = self.prepared.contact
        if isinstance(contact, FrictionlessContact):  # one with friction has its own
            contact.tolerance = tolerance

    def step(self, depth: float, dt: float) -> Step:  # type: ignore[override]  # as it was
        """Move the indenter to `depth` mm in `dt` s."""
        return Loop.step(self, dt, depth=depth)

    def step_contact(self, depth: float, dt: float) -> Step:
        """Move as `step` does, without the strain."""
        return Loop.step(self, dt, depth=depth, strain=False)

    def energy(self) -> tuple[float, float]:
        """Return the stored energy in µJ and the dissipated power in µW."""
        contact = self.prepared.contact
        assert isinstance(contact, FrictionlessContact)
        stored, lost = contact.energy()
        return self.solid.sides * stored, self.solid.sides * lost


class Sliding(_Former):
    """`ff.Loop(finger, indenter, mechanics="condensed", reach=...)`."""

    instead = 'ff.Loop(finger, indenter, mechanics="condensed", reach=0).step(dt, shift=..., ...)'

    def __init__(
        self, finger: Finger, indenter: Indenter, *, reach: float = 0.0, **options: Any
    ) -> None:
        super().__init__(finger, indenter, mechanics=CONDENSED, reach=reach, **options)

    def step(  # type: ignore[override]  # as it was
        self, depth: float, shift: tuple[float, float], dt: float
    ) -> Step:
        """Move the object to `depth` mm and (x, y) mm in `dt` s."""
        return Loop.step(self, dt, depth=depth, shift=shift)

    def step_force(  # type: ignore[override]  # as it was
        self, force: float, shift: tuple[float, float], dt: float
    ) -> Step:
        """Move the object to (x, y) mm in `dt` s under `force` N."""
        return Loop.step(self, dt, force=force, shift=shift)


class Rolling(_Former):
    """`ff.Loop(finger, mechanics="condensed", angles=...)`."""

    instead = 'ff.Loop(finger, mechanics="condensed", angles=(10, 40)).step(dt, angle=..., ...)'

    def __init__(
        self, finger: Finger, *, angles: Sequence[float] = (10.0, 40.0), **options: Any
    ) -> None:
        super().__init__(finger, mechanics=CONDENSED, angles=angles, **options)

    def step(self, depth: float, angle: float, dt: float) -> Step:  # type: ignore[override]
        """Move the plate to `depth` mm beyond its first touch at `angle` degrees in `dt` s."""
        return Loop.step(self, dt, depth=depth, angle=angle)

    def strains(self, points: Array) -> Array:
        """Return the strains (6 n_points, 2n) at points mm under a unit elastic traction."""
        return self.prepared.strains(points)


class Modal(_Former):
    """`ff.Loop(finger, indenter, mechanics="modal")`, and `ff.Vibrations`."""

    instead = (
        'ff.Loop(finger, indenter, mechanics="modal").step(dt, depth=...), and ff.Vibrations for '
        "the harmonic answer and the modes"
    )

    def __init__(
        self, finger: Finger, indenter: Any = STANDARD, *, dt: float = SUBSTEP, **options: Any
    ) -> None:
        super().__init__(finger, indenter, mechanics=MODAL, substep=min(dt, SUBSTEP), **options)

    def step(self, depth: float, dt: float) -> Step:  # type: ignore[override]  # as it was
        """Move the indenter to `depth` mm in `dt` s."""
        return Loop.step(self, dt, depth=depth)

    def rest(self, depth: float, seconds: float) -> Step:  # type: ignore[override]  # as it was
        """Hold a depth in mm for some s, in one step without inertia."""
        return Loop.rest(self, seconds, depth=depth)

    @cached_property
    def vibrations(self) -> Vibrations:
        """The modes and the harmonic answer."""
        return Vibrations.of(self.prepared, self.deepest)

    @property
    def frequencies(self) -> Array:
        """Frequencies (n,) in Hz of the free finger with relaxed tissue."""
        return self.vibrations.frequencies

    def harmonic(self, frequency: ArrayLike, **preload: float) -> Harmonic:
        """Return the harmonic answer, as `Vibrations.harmonic`."""
        return self.vibrations.harmonic(frequency, **preload)

    def shape(self, which: int, *, frames: int = 24) -> Fields:
        """Return one cycle of a free mode, as `Vibrations.shape`."""
        return self.vibrations.shape(which, frames=frames)

    def save_shape(self, path: str, which: int) -> None:
        """Write one cycle of a free mode, as `Vibrations.save_shape`."""
        self.vibrations.save_shape(path, which)

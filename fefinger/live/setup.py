"""What can be chosen on the page: subject, object, mechanics, units; and the loop of a choice."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from functools import partial
from typing import Any, Self

import numpy as np

from fefinger.fem.body import solid
from fefinger.geometry.finger_mesh import SKIN, SUBCUTANEOUS
from fefinger.mechanics.loop import Loop
from fefinger.mechanics.loop_setup import MECHANICS, PRESSED
from fefinger.mechanics.press.mesh_limits import needs_continuation, refinement_location
from fefinger.mechanics.press.sites import end_organ_sites, meshed
from fefinger.mesh.store import load_or_build
from fefinger.results.records import Sites
from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter, direction
from fefinger.scene.indenters import STANDARD, Bar, Cylinder, Flat, Sphere
from fefinger.scene.motions import Ramp
from fefinger.scene.population import Scatter
from fefinger.support.checks import boolean, choice, number, reject_unknown
from fefinger.support.progress import Progress
from fefinger.support.vocabulary import TYPES


PLATE, BALL, CYLINDER, BAR = OBJECTS = ("plate", "ball", "cylinder", "bar")

ONE, MANY = UNITS = ("4 units", "population")
"""One unit of each type under first touch, or some 300 about it."""

DEEPEST = 1.5
"""Depth in mm to which the finger may be pressed."""

STEEPEST = 45.0
"""Largest angle in degrees of a plate here; contact on the tip of a steeper one is shallow."""

SIZES = (0.5, 20.0)
"""Least and largest radius of a ball or a cylinder, and width of a bar, in mm."""

MODULI = (5.0, 2000.0)
"""Least and largest modulus in kPa of a soft object."""


@dataclass(frozen=True)
class Setup:
    """A choice of the page.

    kind: of the object; angle: degrees of a plate; size: mm, radius of a ball or cylinder, width of
    a bar; along: a cylinder or bar lies along the finger instead of across; modulus: kPa of a soft
    plate, ball or cylinder, None of a rigid one. InputError for a value out of its limits.
    """

    subject: str = "a.h."
    kind: str = PLATE
    angle: float = 30.0
    size: float = 5.0
    along: bool = False
    modulus: float | None = None
    mechanics: str = PRESSED
    units: str = ONE

    def __post_init__(self) -> None:
        """Check every value."""
        choice("subject", self.subject, subjects())
        choice("kind", self.kind, OBJECTS)
        number("angle", self.angle, at_least=0, at_most=STEEPEST, unit="degrees")
        number("size", self.size, at_least=SIZES[0], at_most=SIZES[1], unit="mm")
        boolean("along", self.along)
        if self.modulus is not None:
            number("modulus", self.modulus, at_least=MODULI[0], at_most=MODULI[1], unit="kPa")
        choice("mechanics", self.mechanics, MECHANICS)
        choice("units", self.units, UNITS)

    @classmethod
    def of(cls, table: Mapping[str, object]) -> Self:
        """Read a choice from a message; what it leaves out has its default."""
        reject_unknown("setup", table, [field.name for field in fields(cls)])
        given: dict[str, Any] = dict(table)  # checked in __post_init__
        return cls(**given)

    def to_dict(self) -> dict[str, object]:
        """Convert to plain values."""
        return asdict(self)

    def finger(self, resolution: str) -> Finger:
        """Return the finger on a mesh of this resolution."""
        return Finger.subject(self.subject, resolution=resolution)

    @property
    def indenter(self) -> Indenter:
        """The object."""
        roll = 90.0 if self.along else 0.0
        if self.kind == PLATE:
            return Flat(float(self.angle), modulus=self.modulus)
        if self.kind == BALL:
            return Sphere(float(self.size), modulus=self.modulus)
        if self.kind == CYLINDER:
            return Cylinder(float(self.size), roll, modulus=self.modulus)
        rounded = 0.2  # radius of the corners of a bar over its width
        return Bar(float(self.size), rounded * self.size, roll)

    @property
    def ask(self) -> Ask:
        """What a scene of it asks for."""
        radius = 6.0  # radius in mm of the population
        population = Scatter(radius=radius) if self.units == MANY else None
        return Ask(spikes=TYPES, population=population, mechanics=self.mechanics)

    def loop(self, resolution: str, progress: Progress | None = None) -> Loop:
        """Prepare the loop; errors as those of `Loop`."""
        sites = population_sites(self, resolution) if self.units == MANY else None
        return Loop(
            self.finger(resolution),
            self.indenter,
            mechanics=self.mechanics,
            deepest=DEEPEST,
            sites=sites,
            progress=progress,
        )


def subjects() -> tuple[str, ...]:
    """Return the names of the subjects whose fingers were measured."""
    return tuple(library.lumped())


def population_sites(setup: Setup, resolution: str) -> Sites:
    """Return the end organs of the population of a choice, at the places that a run gives them."""
    finger, indenter, ask = setup.finger(resolution), setup.indenter, setup.ask
    touch = refinement_location(indenter) if setup.mechanics == PRESSED else None
    long = needs_continuation(finger, indenter, Ramp(1.0, DEEPEST, corner=0.0))
    mesh = load_or_build(finger, half=True, touch=touch, with_continuation=long)
    body = solid(mesh, (SKIN, SUBCUTANEOUS))
    skin = partial(meshed, body.space.points, body.pad, body.normals, half=True)
    return end_organ_sites(ask, finger.pulp, np.zeros(3), direction(STANDARD), skin)

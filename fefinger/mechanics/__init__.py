"""Interchangeable ways from a Scene to a Response, one file each, cheapest first.

Each is a module with `name`, `refuse(scene)`, `cost(scene)`, `error(scene)`, `coarser(scene)`
and `respond(scene, progress)`; see `Mechanics`.
"""

from importlib import import_module
from typing import Protocol, cast

from fefinger.results.records import Refusal, Response
from fefinger.scene.scene import Scene
from fefinger.support.checks import choice
from fefinger.support.progress import Progress


LADDER = ("lumped", "hertz", "layered", "condensed", "linear", "solid")

MESHED = ("condensed", "linear", "solid")
"""Those with a mesh, whose resolution is the planner's to choose."""

QUICKEST = 0.1
"""Seconds on the machine of the reports that no answer with a mesh is faster than."""


class Mechanics(Protocol):
    """What every mechanics offers."""

    name: str

    def refuse(self, scene: Scene) -> tuple[Refusal, ...]:
        """Return why it should not answer; empty if it can."""

    def cost(self, scene: Scene) -> float:
        """Return the expected wall time in s."""

    def error(self, scene: Scene) -> tuple[float, str]:
        """Return the expected relative error and the report that measured it."""

    def coarser(self, scene: Scene) -> Scene | None:
        """Return the scene on a coarser mesh, to see what depends on it; None if there is none."""

    def respond(self, scene: Scene, progress: Progress | None = None) -> Response:
        """Answer the scene."""


def names() -> tuple[str, ...]:
    """Return the names of all mechanics, cheapest first."""
    return LADDER


def get(name: str) -> Mechanics:
    """Return the mechanics called `name`, or raise InputError with the nearest name."""
    return cast(Mechanics, import_module(f"fefinger.mechanics.{choice('mechanics', name, LADDER)}"))

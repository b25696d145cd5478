"""Contact models of a finger, one file each, cheapest first: they turn a Scene into a Response.

The files say when a model applies, how wrong and how slow it is; the finite-element solvers behind
them are in `press/`, those for real-time loops in `realtime/`, the formulas in `theory/`.

Each is a module with `name`, the rules `refuse`, `cost`, `once` and `error` for a `Situation`, and
`coarser(scene)` and `respond(scene, progress)`; see `Mechanics`.
"""

from importlib import import_module
from typing import Protocol, cast

from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.support.checks import choice
from fefinger.support.progress import Progress


QUICKEST = 0.1
"""Least time in s of a mechanics with a mesh, on the machine of the reports."""


class Mechanics(Protocol):
    """Interface of a contact model."""

    name: str

    def refuse(self, case: Situation) -> tuple[Refusal, ...]:
        """Return the reasons against this model for a scene; empty if it can answer."""

    def cost(self, case: Situation) -> float:
        """Return the expected CPU time in s."""

    def once(self, case: Situation) -> float:
        """Return the one-time part of it, in s: what is built and cached for the next run."""

    def error(self, case: Situation, quantity: str = "force") -> tuple[float, str]:
        """Return the expected relative error of a quantity, and the report that measured it.

        Not a number where it is not known; quantities: `evidence.stated_errors.STATED`.
        """

    def coarser(self, scene: Scene) -> Finger | None:
        """Return the finger on the next coarser mesh, for a convergence check; None without one."""

    def respond(self, scene: Scene, progress: Progress | None = None) -> Response:
        """Solve the scene.

        Raises
        ------
        InputError
            If the indenter does not touch the pad, or goes deeper than the model allows.
        ConvergenceError
            If a contact, an equilibrium or the modes of the finger are not found.
        """


def names() -> tuple[str, ...]:
    """Return the names of all mechanics, cheapest first."""
    return tuple(MECHANICS)


def get(name: str) -> Mechanics:
    """Return the mechanics called `name`, or raise InputError with the nearest name."""
    return cast(
        Mechanics, import_module(f"fefinger.mechanics.{choice('mechanics', name, MECHANICS)}")
    )

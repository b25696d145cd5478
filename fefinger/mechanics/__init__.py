"""Contact models of a finger, one file each, cheapest first: they turn a Scene into a Response.

The files say when a model applies, how wrong and how slow it is; the finite-element solvers behind
them are in `press/`, those for loops in real time in `loop.py`, the formulas in `theory/`.

Each is a module with `name`, `traits`, the rules `refuse`, `cost`, `once` and `error` for a
`Situation`, and `coarser(scene)` and `respond(scene, progress)`: the protocol `Mechanics`, which a
class of a user's own derives from.
"""

from abc import abstractmethod
from typing import Protocol, cast

import numpy as np

from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.support import registry
from fefinger.support.checks import InputError
from fefinger.support.progress import Progress


QUICKEST = 0.1
"""Least time in s of a mechanics with a mesh, on the machine of the reports."""


class Mechanics(Protocol):
    """Interface of a contact model, and base of one of a user's own.

    A class that derives from it has a `name`, `cost` and `respond`, and overrides what else it
    knows. `traits`: whether it has a mesh, finite strain and inertia.
    """

    name: str
    traits: Traits = Traits(meshed=False, finite=False)

    def refuse(self, case: Situation) -> tuple[Refusal, ...]:
        """Return the reasons against this model for a scene; empty if it can answer."""
        return ()

    @abstractmethod
    def cost(self, case: Situation) -> float:
        """Return the expected CPU time in s."""

    def once(self, case: Situation) -> float:
        """Return the one-time part of it, in s: what is built and cached for the next run."""
        return 0.0

    def error(self, case: Situation, quantity: str = "force") -> tuple[float, str]:
        """Return the expected relative error of a quantity, and the report that measured it.

        Not a number where it is not known; quantities: `evidence.stated_errors.STATED`.
        """
        return np.nan, "not known"

    def coarser(self, scene: Scene) -> Finger | None:
        """Return the finger on the next coarser mesh, for a convergence check; None without one."""
        return None

    @abstractmethod
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
    """Return the names of all mechanics, cheapest first, then the user's own."""
    return tuple(registry.MECHANICS)


def get(name: str) -> Mechanics:
    """Return the mechanics called `name`, or raise InputError with the nearest name."""
    return cast(Mechanics, registry.MECHANICS.named("mechanics", name))


SHAPES = {
    "time": (),
    "depth": (),
    "force": (),
    "contact_area": (),
    "centroid": (2,),
    "pressure": ("n_pad",),
    "gap": ("n_pad",),
    "strain": ("n_sites", 3, 3),
    "moment": (3,),
}
"""Shapes of the arrays of a response, after the times."""


def checked(response: object, name: str) -> Response:
    """Return the response of a mechanics of a user's own, if its arrays fit each other.

    Raises InputError for what is no Response, an array of another shape, times that do not
    increase, or a time, depth or force that is not finite.
    """
    if not isinstance(response, Response):
        raise InputError(f"mechanics {name!r}: expected a Response, received {response!r}")
    sizes = {
        "n_pad": None if response.pad is None else len(response.pad.points),
        "n_sites": None if response.sites is None else len(response.sites.points),
    }
    for field, after in SHAPES.items():
        value = getattr(response, field)
        if value is None:
            continue
        wanted = (len(response.time), *(sizes.get(str(each), each) for each in after))
        if np.shape(value) != wanted:
            raise InputError(
                f"mechanics {name!r}: expected a {field} of shape {wanted}, received "
                f"{np.shape(value)}"
            )
    for field in ("time", "depth", "force"):
        if not np.isfinite(getattr(response, field)).all():
            raise InputError(f"mechanics {name!r}: expected a finite {field}, received nan or inf")
    if not (np.diff(response.time) >= 0).all():
        raise InputError(f"mechanics {name!r}: expected times that increase, received others")
    return response

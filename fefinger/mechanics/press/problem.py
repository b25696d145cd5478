"""What a finite-element press is given: the method, and the contact that is solved."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fefinger.fem.body import Reduced
from fefinger.fem.contact.obstacle import Rigid
from fefinger.fem.contact.viscoelastic import History
from fefinger.results.records import Sites
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array


REACH = 1.25  # candidate vertices are those whose gap at first touch is below this times the depth


GROW = 1.4  # factor on the reach when contact meets the border of the candidates


ATTEMPTS = 4


FORCE_DEPTH = 0.22  # first guess of the depth under force control, of the finger's thickness


@dataclass(frozen=True)
class Method:
    """How a mechanics solves: the solid, its reduction to a patch, its march and its fields.

    solid(scene, mesh, report); reduce and march as in `fem.body` and `fem.march`; unknowns(solid,
    loads) gives the displacement under loads on the pad; touch(indenter) where the mesh is fine.
    """

    solid: Callable[..., Any]
    reduce: Callable[..., Reduced]
    march: Callable[..., History]
    unknowns: Callable[[Any, Array], Array]
    touch: Callable[[Indenter], float | tuple[float, float] | None]


@dataclass(frozen=True)
class Contact:
    """The solved contact: where, on what, when, and the end organs that it strains."""

    touch: Rigid
    reduced: Reduced
    sites: Sites | None
    time: Array
    history: History

"""Finite-strain finite elements on the whole finger: hyperelastic, relaxing, exact contact.

The reference for everything cheaper: the same mesh, elements and contact as `linear`, without its
small strain. What it still leaves out is in `NOTES`.
"""

from typing import TYPE_CHECKING

from fefinger.mechanics import linear
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.evidence.stated_errors import error_of
from fefinger.mechanics.press import notes
from fefinger.mechanics.press.notes import refusals
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Traits
from fefinger.results.records import Refusal, Response
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress


if TYPE_CHECKING:
    from fefinger.fem.hyperelastic.load_path import FactorizationBudget


name = "solid"
traits = Traits(meshed=True, finite=True)

NOTES = (
    notes.LOGARITHMIC,
    "The skin may slide along the indenter, frictionless unless the indenter has a coefficient of "
    "friction. Gaps are closed as weighted means over the facets around each vertex, not at every "
    "point.",
    "The second Piola-Kirchhoff stress of the soft tissues relaxes (Fung's quasi-linear "
    "viscoelasticity); solved at steps of the motion and interpolated between them.",
    notes.QUASISTATIC,
)


def refuse(case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against it: too many steps, or a mesh error that is not measured."""
    return refused(name, case)


def refused(mechanics: str, case: Situation) -> tuple[Refusal, ...]:
    """Return the reasons against finite strain for a scene, as refusals of `mechanics`."""
    sliding = notes.finite_sliding_reasons(case.motion, case.indenter)
    elastic = notes.relaxing_object_reasons(case.indenter)
    unable = [*sliding, *elastic, *case.too_long, *linear.unmeshable(case)]
    if unable:
        return refusals(mechanics, "ability", unable)
    reasons = [*linear.too_small(case), *linear.unmeasured(case.finger)]
    return linear.beyond_cut(mechanics, case) + refusals(mechanics, "accuracy", reasons)


cost, once, coarser = costs.solid_seconds, costs.mesh_seconds, linear.coarser
error = error_of(name)


def respond(
    scene: Scene,
    progress: Progress | None = None,
    *,
    allowance: "FactorizationBudget | None" = None,
) -> Response:
    """Solve the scene with finite-strain finite elements.

    allowance: limit on tangent factorizations, by default `finite_strain.BUDGET`.

    Raises
    ------
    InputError
        If the indenter does not touch the pad, or goes deeper than the tissue or the pad allows.
    ConvergenceError
        If an equilibrium is not reached by steps however short, or not within the allowance.
    """
    from fefinger.mechanics.press import finite_strain

    stated = (*NOTES, *notes.hard_parts_notes(scene.finger))
    return finite_strain.respond(scene, progress, mechanics=name, notes=stated, allowance=allowance)

"""Finite-strain finite elements on the whole finger: hyperelastic, relaxing, exact contact.

The reference for everything cheaper: the same mesh, elements and contact as `linear`, without its
small strain. What it still leaves out is in `NOTES`.
"""

from typing import TYPE_CHECKING

from fefinger.mechanics import linear
from fefinger.mechanics.evidence import reports, solid_cost, tradeoff
from fefinger.mechanics.press import proximal_cut
from fefinger.mechanics.press.notes import hard
from fefinger.mechanics.press.time_steps import too_long
from fefinger.results.records import Refusal, Response
from fefinger.scene.scene import Scene
from fefinger.support.progress import Progress


if TYPE_CHECKING:
    from fefinger.fem.hyperelastic.load_path import Allowance


name = "solid"

SOLVERS = ("single", "multifrontal")
"""Its factors: the first, and the second where that fails."""

NOTES = (
    "Finite strain: strains are logarithmic, in the directions of the undeformed finger; pressures "
    "are per undeformed area, contact areas are those of the deformed skin.",
    "Frictionless contact with a rigid indenter, which the skin may slide along. Gaps are closed "
    "as weighted means over the facets around each vertex, not at every point.",
    "The second Piola-Kirchhoff stress of the soft tissues relaxes (Fung's quasi-linear "
    "viscoelasticity); solved at steps of the motion and interpolated between them.",
    "Quasi-static: no inertia and no waves.",
)


def refuse(scene: Scene) -> tuple[Refusal, ...]:
    """Return why it should not answer: too many steps, or a mesh error that is not measured."""
    unable = [*too_long(scene.motion, fast="FAII" in scene.ask.spikes), *linear.unmeshable(scene)]
    if scene.ask.solver not in (None, *SOLVERS):
        reason = f"ask.solver = {scene.ask.solver!r}: it follows finite strain with its own factors"
        unable.append(reason)
    if unable:
        return tuple(Refusal(name, "ability", reason) for reason in unable)
    doubts = (*linear.too_small(scene), *linear.unmeasured(scene.finger))
    measured = tradeoff.stated(f"{name} {scene.finger.mesh}", scene) is not None
    radius, least = scene.indenter.least_radius, reports.linear_radius(scene)
    if radius < least and not measured:
        reason = f"radius = {radius:.3g} mm < {least:g} mm: the mesh error is not measured there"
        doubts = (reason, *doubts)
    return (
        *proximal_cut.reached(name, scene),
        *(Refusal(name, "accuracy", reason) for reason in doubts),
    )


def cost(scene: Scene) -> float:
    """Return the expected wall time in s."""
    return solid_cost.seconds(scene)


def error(scene: Scene) -> tuple[float, str]:
    """Return the expected relative error of the force against a converged mesh, and its source."""
    candidate = f"{name} {scene.finger.mesh}"
    found = tradeoff.stated(candidate, scene)
    if found is not None:
        return found.error, found.source
    return tradeoff.instead(candidate, scene, *reports.solid_error(scene))


def coarser(scene: Scene) -> Scene | None:
    """Return the scene on the next coarser mesh, if that is at hand."""
    return linear.coarser(scene)


def respond(
    scene: Scene, progress: Progress | None = None, *, allowance: "Allowance | None" = None
) -> Response:
    """Answer the scene with finite-strain finite elements.

    Without an `allowance` its steps may take any work.

    Raises
    ------
    InputError
        If the indenter does not touch the pad, or goes deeper than the tissue or the pad allows.
    ConvergenceError
        If an equilibrium is not reached by steps however short, or not within the allowance.
    """
    from fefinger.mechanics.press import finite_strain

    notes = (*NOTES, *hard(scene.finger))
    return finite_strain.respond(scene, progress, mechanics=name, notes=notes, allowance=allowance)

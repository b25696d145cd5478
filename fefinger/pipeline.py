"""From a scene to its result: plan, mechanics, spikes.

plan.choose           which mechanics answers, and on which mesh, by the errors and costs that
                      `mechanics/evidence/` states from `reports/`
mesh/store.py         the mesh: shipped, cached, or made by `mesh/build.py`
mechanics/            `respond` of the chosen one: force, pressure, strain. All but the law `lumped`
                      go on to `mechanics/press/`, whose `__init__` lists the parts:
                      problem.Press (mesh, body, obstacle, end organs), small_strain, finite_strain
contact/              time steps at small strain: `frictionless.py`, each solved in `active_set.py`;
                      `stepper.march` takes any kind of contact through a motion
fem/                  elements; equilibria at finite strain in `fem/hyperelastic/newton.py`. The
                      displacement gradient at the end organs is a linear map of the displacements,
                      made in `fem/elements/probe.py` and applied in `mechanics/press/`:
                      response.py, finite_strain.py and tabulated_press.py
afferents.fire        the spikes of that strain: `neural/recorded_compiled.py`, which
                      `neural/recorded.py` calls, or, of the family `thesis`,
                      `neural/membranes/vectorized.py`, which `neural/afferent_units.py` calls
result.Result         `save`, `load` and `show`; its page is written by `pages/report.py`

Where else to look:

textures, ridges      of `layered`: `mechanics/press/layer_press.py`, solved on a grid in
                      `contact/grid_solver.py`
friction              `mechanics/press/moving_contact.py` at small strain (in
                      `contact/frictional.py`), `mechanics/press/finite_sliding.py` at finite
                      strain (in `fem/hyperelastic/linearized.py`)
table of `pressed`    `mechanics/press/elastic_press.py`: `load_or_solve` reads it, or solves and
                      stores it; its files are written by `depth_table.write`
stated error          `plan._rung`: `error` of the mechanics, and the error of neglecting inertia
"""

from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from fefinger.result import Result
    from fefinger.results.result_record import Plan
    from fefinger.scene.scene import Scene
    from fefinger.support.progress import Progress


def run(
    scene: "Scene | str | Path",
    *,
    changes: "Mapping[str, object] | None" = None,
    mechanics: str | None = None,
    progress: "Progress | None" = None,
) -> "Result":
    """Solve a scene: choose the mechanics, compute its response and the spikes.

    Parameters
    ----------
    scene
        A Scene, the name of a built-in one, or a TOML file.
    changes
        Values of fields of the scene by their path, as {"motion.depth": 1.0}.
    mechanics
        Name of the mechanics to use; by default the cheapest that does not refuse. If that finds
        while it solves that the scene is beyond its limits, as a force that presses through its
        tissue, the next one answers, and a note says so.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        A scene that cannot be used, or that no mechanics answers.
    ConvergenceError
        A failed iteration; `Stopped` holds the Result up to there.
    """
    # Imported here, so that `import fefinger` and its command line stay quick.
    from fefinger.plan import choose
    from fefinger.results.records import Refusal
    from fefinger.scene import builtin
    from fefinger.support.checks import BeyondError

    scene = builtin.given(scene, changes)
    tried: tuple[Refusal, ...] = ()
    while True:
        plan = choose(scene, mechanics, tried=tried)
        try:
            return _answer(scene, plan, progress)
        except BeyondError as error:
            if mechanics is not None or scene.ask.mechanics is not None:
                raise
            tried += (Refusal(plan.mechanics, "ability", str(error), error.field),)


def _answer(scene: "Scene", plan: "Plan", progress: "Progress | None") -> "Result":
    """Answer a scene with the chosen mechanics; BeyondError where it finds that it cannot."""
    from fefinger.afferents import fire, mesh_check
    from fefinger.mechanics import checked as fitting
    from fefinger.mechanics import get
    from fefinger.plan import settled
    from fefinger.result import Result
    from fefinger.support.checks import Stopped
    from fefinger.support.progress import Stages
    from fefinger.support.registry import MECHANICS

    chosen, planned, stages = get(plan.mechanics), settled(scene, plan), Stages(progress)
    with mesh_check(chosen, planned, plan.chosen.seconds) as checked:
        try:
            with MECHANICS.guarded(plan.mechanics):
                response = fitting(chosen.respond(planned, progress), plan.mechanics)
        except Stopped as stop:  # without spikes: their trains need the whole motion
            raise Stopped(str(stop), Result.of(scene, plan, stop.reached)) from stop
        with stages.stage("neural"):
            since = scene.motion.recorded_from
            spikes = fire(scene.ask, response, since=since) if scene.ask.spikes else None
        if spikes is not None:
            with stages.stage("spike check"):
                spikes = checked(spikes)
    return Result.of(scene, plan, response, spikes, stages.seconds)

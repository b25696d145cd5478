"""The main path: scene, plan, mechanics, neural, result."""

from typing import TYPE_CHECKING, Any


if TYPE_CHECKING:
    from pathlib import Path

    from fefinger.mechanics import Mechanics
    from fefinger.neural.trains import SpikeTrains
    from fefinger.result import Result
    from fefinger.results.records import Plan, Response
    from fefinger.scene.scene import Scene
    from fefinger.support.progress import Progress


def run(
    scene: "Scene | str | Path",
    *,
    mechanics: str | None = None,
    progress: "Progress | None" = None,
) -> "Result":
    """Answer a scene.

    Parameters
    ----------
    scene
        A Scene, the name of a built-in one, or a TOML file.
    mechanics
        Name of the mechanics to use; by default the cheapest that does not refuse.
    progress
        Called with the name of a stage and the fraction of it that is done.

    Raises
    ------
    InputError
        A scene that cannot be used, or that no mechanics answers.
    ConvergenceError
        An iteration that failed; `Stopped` holds the Result up to there.
    """
    from dataclasses import replace

    from fefinger.mechanics import get
    from fefinger.plan import choose, settled
    from fefinger.result import Result
    from fefinger.scene import builtin
    from fefinger.support.checks import Stopped
    from fefinger.support.progress import Stages

    scene = builtin.given(scene)
    plan = choose(scene, mechanics)
    chosen, solved = get(plan.mechanics), settled(scene, plan)
    try:
        response = _noted(scene, chosen.respond(solved, progress))
    except Stopped as stop:
        raise Stopped(str(stop), _kept(scene, plan, _noted(scene, stop.reached))) from stop
    stages = Stages(progress)
    with stages.stage("neural"):
        spikes = fire(scene, response) if scene.ask.spikes else None
    if spikes is not None:
        with stages.stage("mesh check"):
            spikes = _checked(spikes, chosen, solved)
    return Result(
        scene=scene,
        plan=plan,
        response=response if scene.ask.strain else replace(response, strain=None),
        spikes=spikes,
        status=_status(response, spikes),
        seconds={**response.seconds, **stages.seconds},
        provenance=_provenance(scene) | response.sources,
    )


def _noted(scene: "Scene", response: "Response") -> "Response":
    """Return the response with notes on a subject's other sizes, and where statics do not hold."""
    from dataclasses import replace

    from fefinger.scene.finger import origin_notes
    from fefinger.scene.inertia import jump, quasistatic

    found = origin_notes(scene.finger) + jump(scene.motion)
    found += quasistatic(scene, response.time, response.depth)
    return replace(response, notes=response.notes + found)


def _kept(scene: "Scene", plan: "Plan", response: "Response") -> "Result":
    """Return what a run that had to stop has reached; without spikes, which need the whole."""
    from fefinger.result import Result

    sources = _provenance(scene) | response.sources
    return Result(scene, plan, response, None, response.status, response.seconds, sources)


def fire(scene: "Scene", response: "Response") -> "SpikeTrains":
    """Return what the population fires, or one unit of each type asked, under the strain."""
    from dataclasses import replace

    from fefinger import afferents
    from fefinger.neural.afferents import from_strain
    from fefinger.support.checks import InputError

    if scene.ask.population is not None:
        return afferents.fire(response, scene.ask)

    if response.strain is None or response.sites is None or response.reference is None:
        msg = f"ask.spikes: {response.mechanics!r} gives no strain under the skin to make them from"
        raise InputError(msg)
    sites, reference = response.sites, response.reference
    trains = from_strain(
        response.time,
        response.strain,
        sites.normals,
        sites.types,
        reference_depth=reference.depth,
        reference_types=reference.types,
        reference_strain=reference.strain,
        reference_normals=reference.normals,
        drives=scene.ask.drives,
        generator=scene.ask.generator,
        positions=sites.points,
    )
    return replace(trains, depths=sites.depths)


def _checked(spikes: "SpikeTrains", chosen: "Mechanics", scene: "Scene") -> "SpikeTrains":
    """Return the spikes with a note on whether their counts survive a coarser mesh."""
    from dataclasses import replace

    coarser = chosen.coarser(scene)
    if coarser is None:
        return spikes
    asked = replace(coarser, ask=replace(coarser.ask, fields=False, pressure=False))
    mesh = f"the mesh is {coarser.finger.mesh}"
    try:
        notes = _compared(spikes, fire(asked, chosen.respond(asked)), mesh)
    except Exception as error:  # Whatever it is, the answer itself is finished.
        notes = (f"Spike counts could not be checked when {mesh}: {error}",)
    return replace(spikes, notes=spikes.notes + notes)


def _compared(spikes: "SpikeTrains", again: "SpikeTrains", mesh: str) -> tuple[str, ...]:
    """Return notes on the units, by name, that both have; a coarser skin may end elsewhere."""
    from fefinger.neural.checked_signals import count_changes

    both = set(again.names)
    names = [name for name in spikes.names if name in both]
    one, other = ([trains.times[trains.index(n)] for n in names] for trains in (spikes, again))
    alone = len(spikes.names) - len(names)
    left = (
        f"Not compared: {alone} of {len(spikes)} units, whose places lie beside the skin when "
        f"{mesh}."
    )
    same = f"All spike counts are the same when {mesh}."
    changes = count_changes(names, one, other, mesh) or ((same,) if names else ())
    return (*changes, left) if alone else changes


def _status(response: "Response", spikes: "SpikeTrains | None") -> str:
    if spikes is None:
        return response.status
    return f"{response.status} Spikes: {spikes.summary()}."


def _provenance(scene: "Scene") -> dict[str, Any]:
    """Return what is needed to make the same result again."""
    import hashlib

    from fefinger.support.provenance import software

    return {**software(), "scene_sha256": hashlib.sha256(scene.to_toml().encode()).hexdigest()}

"""Which mechanics answers a scene, on which mesh: the cheapest that is good enough."""

import math
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from fefinger import mechanics as ladder
from fefinger.mechanics.evidence import force_control, machine, tradeoff
from fefinger.results.plan_text import ladder as written
from fefinger.results.plan_text import trust
from fefinger.results.records import Plan, Refusal, Rung, Settings
from fefinger.scene import builtin
from fefinger.scene.finger import AUTO, RESOLUTIONS, STANDARD
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError, choice
from fefinger.support.text import beyond, duration, percent


LEFT_OUT = (
    "They are of solving: saving with a report takes some 3 to 10 s more, and compiling, once "
    "after the installation, some 20 s."
)
"""What expected times leave out, as timed on the machine of the reports."""


def explain(scene: Scene | str | Path) -> Plan:
    """Return the choice for a scene and the whole ladder that it was chosen from; solve nothing.

    `scene` is a Scene, the name of a built-in one, or a TOML file.

    The first time it also measures how fast this machine is, in about a second.

    Raises
    ------
    InputError
        A scene that cannot be used, or that every mechanics refuses; the message then shows the
        ladder and what to relax.
    """
    return choose(scene, every=True)


def choose(scene: Scene | str | Path, mechanics: str | None = None, *, every: bool = False) -> Plan:
    """Return the plan for a scene, with the cheapest mechanics or with the one named.

    `scene` is a Scene, the name of a built-in one, or a TOML file.

    A mechanics that is named runs in spite of refusals about accuracy or time, which the plan
    records; refusals about ability stand. Unless `every` one is to be asked, those with a mesh are
    left out where one without is good enough.

    Raises
    ------
    InputError
        A scene that cannot be used, that every mechanics refuses, or that the one that is named is
        not able to answer.
    """
    scene = builtin.given(scene)
    if every or scene.ask.seconds is not None:
        machine.seconds()
    if mechanics is not None:
        choice("mechanics", mechanics, ladder.names())
    asked = _ladder(scene, every=every, named=mechanics)
    chosen = _cheapest(scene, asked) if mechanics is None else _named(asked, mechanics)
    settings = _settings(scene, chosen)
    how = "the cheapest that does not refuse" if mechanics is None else "as named"
    sentence = f"{chosen.mechanics}, {how}; {_expectation(scene, chosen)}. {_told(settings)}"
    left_out = [name for name in ladder.names() if name not in {rung.mechanics for rung in asked}]
    if left_out and mechanics is None:
        sentence += f" Not asked, because slower and not needed: {', '.join(left_out)}."
    if chosen.refusals:
        reasons = "; ".join(refusal.reason for refusal in chosen.refusals)
        sentence += f" It would have refused: {reasons}."
    return Plan(
        chosen.mechanics,
        asked,
        sentence,
        chosen.refusals,
        settings,
        machine=f"{machine.sentence()} {LEFT_OUT}",
        trust=trust(chosen, scene.ask),
    )


def rungs(scene: Scene) -> tuple[Rung, ...]:
    """Return the whole ladder for a scene."""
    return _ladder(scene, every=True, named=None)


def settled(scene: Scene, plan: Plan) -> Scene:
    """Return the scene with what the plan has chosen written into it, for the mechanics."""
    resolution = plan.settings.resolution if plan.settings else None
    if resolution is None:
        return scene
    return replace(scene, finger=replace(scene.finger, resolution=resolution))


def _ladder(scene: Scene, *, every: bool, named: str | None) -> tuple[Rung, ...]:
    """Ask the mechanics in turn, on every mesh that the scene leaves open."""
    found: list[Rung] = []
    for name in ladder.names():
        willing = [rung for rung in found if not rung.refusals and not math.isnan(rung.error)]
        quick = any(rung.seconds < ladder.QUICKEST * machine.slowness({}) for rung in willing)
        if quick and name in ladder.MESHED and not every and named is None:
            continue
        if named in (None, name) or every:
            found += _rungs(name, scene)
    return tuple(found)


def _rungs(name: str, scene: Scene) -> Iterator[Rung]:
    """Give the rungs of one mechanics, one for each mesh; one alone where it is not able."""
    candidate = ladder.get(name)
    for resolution, settled_scene in _candidates(name, scene):
        refusals = candidate.refuse(settled_scene)
        if any(refusal.about == "ability" for refusal in refusals):
            yield Rung(name, math.nan, math.nan, "not able", refusals)
            return
        yield _rung(name, resolution, settled_scene, refusals)


def _candidates(name: str, scene: Scene) -> Iterator[tuple[str | None, Scene]]:
    """Give the meshes that a mechanics may take, and the scene with each.

    Spike counts are checked on the next coarser mesh, so the coarsest is none for them.
    """
    if name not in ladder.MESHED:
        yield None, scene
    elif scene.finger.resolution != AUTO:
        yield scene.finger.resolution, scene
    else:
        for resolution in RESOLUTIONS[1:] if scene.ask.spikes else RESOLUTIONS:
            yield resolution, replace(scene, finger=replace(scene.finger, resolution=resolution))


def _rung(name: str, resolution: str | None, scene: Scene, refusals: tuple[Refusal, ...]) -> Rung:
    """Ask one candidate what it would cost and how wrong it would be, against what is asked."""
    candidate, asked = ladder.get(name), scene.ask
    seconds, (error, evidence) = candidate.cost(scene), candidate.error(scene)
    if math.isnan(error):
        refusals = (*refusals, Refusal(name, "accuracy", f"its error here is {evidence}"))
    elif math.isinf(error):
        refusals = (*refusals, Refusal(name, "accuracy", f"its error has no limit: {evidence}"))
    elif error > asked.rel_error:
        reason = f"expected relative error = {beyond(error, asked.rel_error)} (ask.rel_error)"
        refusals = (*refusals, Refusal(name, "accuracy", reason))
    if asked.seconds is not None and seconds > asked.seconds:
        reason = f"expected time = {beyond(seconds, asked.seconds, ' s')} (ask.seconds)"
        refusals = (*refusals, Refusal(name, "time", reason))
    label = f"{name} {resolution or ''}".strip()
    errors = tradeoff.others(label, scene)
    if scene.motion.control == "force" and math.isfinite(error):
        errors = force_control.errors(errors, error, scene)
    errors |= tradeoff.spikes(label, scene) if asked.spikes else {}
    return Rung(name, seconds, error, evidence, refusals, resolution, errors)


def _cheapest(scene: Scene, rungs: tuple[Rung, ...]) -> Rung:
    willing = [rung for rung in rungs if not rung.refusals and not math.isnan(rung.error)]
    if willing:
        return min(willing, key=lambda rung: rung.seconds)
    relax = _relaxing(rungs) + _unchecked(scene)
    msg = (
        f"ask: no mechanics can answer this scene as it is asked\n\n{written(rungs)}\n\n"
        f"{relax}{'Or name' if relax else 'Name'} a mechanics to run it all the same (where it is "
        "able to); the result then records the refusals."
    )
    raise InputError(msg)


def _relaxing(rungs: tuple[Rung, ...]) -> str:
    """Return which error or time would have to be allowed, and what would answer then."""
    said = ""
    for about, field in (("accuracy", "error"), ("time", "seconds")):
        name = {"error": "ask.rel_error", "seconds": "ask.seconds"}[field]
        close = [
            rung
            for rung in rungs
            if rung.refusals and all(_of_ask(r, name) and r.about == about for r in rung.refusals)
        ]
        if close:
            best = min(close, key=lambda rung: float(getattr(rung, field)))
            least = float(f"{1.005 * getattr(best, field):.2g}")
            while least < getattr(best, field):
                least *= 1.01
            mesh = f" on the {best.resolution} mesh" if best.resolution else ""
            said += f"Relax {name} to {least:.3g} and {best.mechanics}{mesh} answers. "
    return said


def _unchecked(scene: Scene) -> str:
    """Return what the coarsest mesh would answer, which the check of spike counts leaves out."""
    if not scene.ask.spikes or scene.finger.resolution != AUTO:
        return ""
    coarse = replace(scene, finger=replace(scene.finger, resolution=RESOLUTIONS[0]))
    able = [rung for name in ladder.MESHED for rung in _rungs(name, coarse) if not rung.refusals]
    if not able:
        return ""
    best = min(able, key=lambda rung: rung.seconds)
    return (
        f"Or set finger.resolution to {RESOLUTIONS[0]!r} and {best.mechanics} answers in "
        f"{duration(best.seconds)}, with spike counts that no coarser mesh checks. "
    )


def _of_ask(refusal: Refusal, name: str) -> bool:
    return f"({name})" in refusal.reason


def _named(rungs: tuple[Rung, ...], mechanics: str) -> Rung:
    """Return the rung of a mechanics: the cheapest that does not refuse, or the standard mesh."""
    own = [rung for rung in rungs if rung.mechanics == mechanics]
    unable = [refusal for refusal in own[0].refusals if refusal.about == "ability"]
    if unable:
        reasons = "\n".join(f"  {mechanics}: ability: {refusal.reason}" for refusal in unable)
        msg = f"mechanics: {mechanics!r} cannot answer this scene\n{reasons}"
        raise InputError(msg)
    willing = [rung for rung in own if not rung.refusals]
    if willing:
        return min(willing, key=lambda rung: rung.seconds)
    return next((rung for rung in own if rung.resolution == STANDARD), own[0])


def _settings(scene: Scene, chosen: Rung) -> Settings:
    """Return what of the scene the chosen mechanics builds."""
    from fefinger.mechanics.press.discretization import symmetric
    from fefinger.mechanics.press.time_steps import time_grid

    ask, meshed = scene.ask, chosen.resolution is not None
    fast = chosen.mechanics != "lumped" and "FAII" in ask.spikes
    # What is too long for the mechanics it has refused itself.
    times = time_grid(scene.motion, fast=fast, most=sys.maxsize)
    return Settings(
        resolution=chosen.resolution,
        half=symmetric(scene) if meshed else None,
        times=len(times),
        computed=("force", *(x for x in ("pressure", "strain", "fields") if getattr(ask, x))),
        afferents=ask.spikes,
    )


def _told(settings: Settings) -> str:
    """Return the settings in a sentence."""
    mesh = ""
    if settings.resolution is not None:
        half = "half a" if settings.half else "the whole"
        mesh = f" on the {settings.resolution} mesh of {half} finger"
    what = ", ".join(settings.computed)
    fibers = f" and the spikes of {', '.join(settings.afferents)}" if settings.afferents else ""
    return f"It computes {what}{fibers} at {settings.times} times{mesh}."


def _expectation(scene: Scene, rung: Rung) -> str:
    """Return error and time in words, and what of the time only the first answer takes."""
    error = (
        f"expected error {percent(rung.error)}" if math.isfinite(rung.error) else "error unknown"
    )
    said = f"{error} ({rung.evidence}), about {duration(rung.seconds)}"
    if rung.resolution is None:
        return said
    from fefinger.mechanics.evidence.reports import once

    finger = replace(scene.finger, resolution=rung.resolution)
    first = once(rung.mechanics, replace(scene, finger=finger))
    return f"{said}, {duration(first)} of it for what is built once and kept" if first else said

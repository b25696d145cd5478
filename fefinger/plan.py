"""Which mechanics answers a scene, on which mesh: the cheapest within the requested accuracy."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from fefinger.mechanics import QUICKEST, Mechanics, get, names
from fefinger.mechanics.evidence import costs, stated_errors, vibration
from fefinger.mechanics.evidence.stated_errors import STATED
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import MECHANICS, Candidate, meshed
from fefinger.results.records import Refusal, Rung
from fefinger.results.result_record import ERROR, SECONDS, Plan, Settings, relaxing, trust
from fefinger.results.result_record import ladder as written
from fefinger.scene import builtin
from fefinger.scene.ask import OUTPUTS
from fefinger.scene.cautions import unusual
from fefinger.scene.finger import AUTO, PULP, RESOLUTIONS, STANDARD
from fefinger.scene.scene import Scene
from fefinger.support import machine, registry
from fefinger.support.checks import InputError, choice
from fefinger.support.text import duration, format_excess
from fefinger.support.units import FORCE


if TYPE_CHECKING:
    # mypy holds the modules of the package against the protocol.
    from fefinger.mechanics import condensed, hertz, layered, linear, lumped, modal, pressed, solid

    _LADDER: tuple[Mechanics, ...] = (
        *(lumped, hertz, layered),
        *(condensed, pressed, modal, linear, solid),
    )

MODAL = "modal"
"""The mechanics with inertia."""

NOT_TIMED = (
    "They are of solving: saving with a report takes some 3 to 10 s more, and compiling, once "
    "after the installation, some 20 s."
)
"""What expected times leave out, as timed on the machine of the reports."""


def explain(scene: Scene | str | Path, *, changes: Mapping[str, object] | None = None) -> Plan:
    """Return the choice for a scene and the whole ladder that it was chosen from; solve nothing.

    `scene` is a Scene, the name of a built-in one, or a TOML file; `changes` are values of its
    fields by their path, as {"motion.depth": 1.0}.

    The first time it also measures how fast this machine is, in about a second.

    Raises
    ------
    InputError
        A scene that cannot be used, or that every mechanics refuses; the message then shows the
        ladder and what to relax.
    """
    return choose(builtin.given(scene, changes), every=True)


def choose(
    scene: Scene | str | Path,
    mechanics: str | None = None,
    *,
    every: bool = False,
    tried: tuple[Refusal, ...] = (),
) -> Plan:
    """Return the plan for a scene, with the cheapest mechanics or with the one named.

    `scene` is a Scene, the name of a built-in one, or a TOML file.

    A mechanics that is named, here or in the scene (`ask.mechanics`), runs in spite of refusals
    about accuracy or time, which the plan records; refusals about ability stand. Unless `every` one
    is wanted, those with a mesh are left out where one without is good enough. `tried` are refusals
    of mechanics that found the scene beyond their limits while they answered it.

    Raises
    ------
    InputError
        A scene that cannot be used, that every mechanics refuses, or that the one that is named is
        not able to answer.
    """
    scene = builtin.given(scene)
    if mechanics is not None:
        choice("mechanics", mechanics, names())
    elif (mechanics := scene.ask.mechanics) is not None:
        choice("ask.mechanics", mechanics, names())
    if mechanics is not None:
        scene = replace(scene, ask=scene.ask.settled(MECHANICS[mechanics].outputs))
    case = Situation.of(scene)
    if every or case.ask.seconds is not None:
        machine.seconds()
    if mechanics is None:
        _check_force(case)
    considered = _ladder(case, every=every, named=mechanics, tried=tried)
    chosen = _cheapest(case, considered) if mechanics is None else _named(considered, mechanics)
    settings = _settings(case, chosen)
    return Plan(
        chosen.mechanics,
        considered,
        _sentence(case, chosen, considered, settings, named=mechanics is not None),
        chosen.refusals,
        settings,
        machine=f"{machine.sentence()} {NOT_TIMED}",
        trust=trust(chosen, case.ask),
        tried=tried,
    )


def rungs(scene: Scene) -> tuple[Rung, ...]:
    """Return the whole ladder for a scene."""
    return _ladder(Situation.of(scene), every=True, named=None)


def settled(scene: Scene, plan: Plan) -> Scene:
    """Return the scene with the mesh resolution that the plan has chosen, and what it computes."""
    resolution = plan.settings.resolution if plan.settings else None
    finger = replace(scene.finger, resolution=resolution) if resolution else scene.finger
    ask = scene.ask.settled(MECHANICS[plan.mechanics].outputs)
    return replace(scene, finger=finger, ask=ask)


def _ladder(
    case: Situation, *, every: bool, named: str | None, tried: tuple[Refusal, ...] = ()
) -> tuple[Rung, ...]:
    """Rate the mechanics in turn, on every mesh that the scene leaves open."""
    considered: list[Rung] = []
    inertia = _Inertia(case)
    for name in names():
        willing = [rung for rung in considered if _willing(rung)]
        quick = any(rung.seconds < QUICKEST * machine.slowness({}) for rung in willing)
        if quick and MECHANICS[name].meshed and not every and named is None:
            continue
        if refusals := tuple(refusal for refusal in tried if refusal.mechanics == name):
            considered.append(_unable(name, refusals))
        elif named in (None, name) or every:
            with registry.MECHANICS.guarded(name):
                considered += _rungs(name, case, inertia)
    return tuple(considered)


class _Inertia:
    """Error of neglecting inertia, over the peak of the force, in all mechanics but `modal`.

    vibration, and reason: the error of the oscillation or of the ramp itself.
    """

    def __init__(self, case: Situation) -> None:
        self.case = case
        self.error, self.evidence = vibration.left_out(case)
        self.vibration, self.reason = vibration.statics_error(case)

    @cached_property
    def avoidable(self) -> bool:
        """Whether `modal` can solve the scene; else a motion that is too fast gets a warning."""
        if MODAL not in names():
            return False
        return not _about_ability(get(MODAL).refuse(self.case.meshes[0]))

    def refusals(self, name: str) -> tuple[Refusal, ...]:
        """Refuse where the oscillation without inertia is off by more than what is allowed."""
        allowed = self.case.ask.rel_error
        if self.vibration <= allowed or not self.avoidable:
            return ()
        error = format_excess(self.vibration, allowed)
        reason = f"error of leaving inertia out = {error}: {self.reason} ({ERROR})"
        return (Refusal(name, "accuracy", reason, ERROR),)


def _about_ability(refusals: Sequence[Refusal]) -> list[str]:
    """Return the reasons why a mechanics is not able to answer."""
    return [refusal.reason for refusal in refusals if refusal.about == "ability"]


def _willing(rung: Rung) -> bool:
    return not rung.refusals and not math.isnan(rung.error)


def _rungs(name: str, case: Situation, inertia: _Inertia) -> Iterator[Rung]:
    """Yield the rungs of one mechanics, one per mesh; a single one where it is not able."""
    meshed = MECHANICS[name].meshed
    for each in case.meshes if meshed else (case,):
        refusals = get(name).refuse(each)
        if _about_ability(refusals):
            yield _unable(name, refusals)
            return
        yield _rung(Candidate(name, each.mesh if meshed else None), each, refusals, inertia)


def _unable(name: str, refusals: tuple[Refusal, ...]) -> Rung:
    return Rung(name, math.nan, math.nan, "not able", refusals)


def _rung(
    candidate: Candidate, case: Situation, refusals: tuple[Refusal, ...], inertia: _Inertia
) -> Rung:
    """Look up cost and error of one candidate, with refusals where `ask` allows less."""
    name = candidate.mechanics
    mechanics, ask = get(name), case.ask
    static, evidence = mechanics.error(case)
    check = _check_seconds(mechanics, case)
    seconds = mechanics.cost(case) + costs.spike_seconds(case) + check
    with_inertia = MECHANICS[name].inertia
    left_out = () if with_inertia else inertia.refusals(name)
    whole = static
    if not with_inertia:
        whole, evidence = math.hypot(static, inertia.error), evidence + inertia.evidence
    # Inertia that no mechanics can solve is warned of; but a slide may always be slower.
    counts = static <= ask.rel_error < whole and (case.motion.slides or inertia.avoidable)
    judged = whole if counts else static
    if math.isnan(judged):
        refusals = (*refusals, Refusal(name, "accuracy", f"its error here is {evidence}"))
    elif math.isinf(judged):
        refusals = (*refusals, Refusal(name, "accuracy", f"its error has no limit: {evidence}"))
    elif judged > ask.rel_error:
        reason = f"expected relative error = {format_excess(judged, ask.rel_error)} ({ERROR})"
        refusals = (*refusals, Refusal(name, "accuracy", reason, ERROR))
    error = max(whole, inertia.vibration) if left_out else whole
    if case.finger.raised_ridges is not None and not MECHANICS[name].ridges:
        reason = "finger.ridges: this mechanics has a smooth pad"
        refusals = (*refusals, Refusal(name, "accuracy", reason, "finger.ridges"))
    refusals = (*refusals, *left_out)
    wall = costs.wall(name, case, seconds)
    if costs.beside(seconds):
        wall -= check
    if ask.seconds is not None and wall > ask.seconds:
        reason = f"expected time = {format_excess(wall, ask.seconds, ' s')} ({SECONDS})"
        refusals = (*refusals, Refusal(name, "time", reason, SECONDS))
    wanted = (*STATED[1:], *map(stated_errors.strain_of, ask.spikes))
    errors = {what: mechanics.error(case, what)[0] for what in wanted}
    errors = {what: each for what, each in errors.items() if math.isfinite(each)}
    if "strain" in errors:
        errors["strain"] = stated_errors.worst(errors, ask.spikes)
    if case.motion.by_force and math.isfinite(error):
        errors = stated_errors.at_force(errors, error, case)
    return Rung(name, seconds, error, evidence, refusals, candidate.resolution, errors, wall)


def _check_seconds(mechanics: Mechanics, case: Situation) -> float:
    """Return the expected CPU time in s of the check of spike counts on the coarser mesh."""
    if not (case.ask.spikes and case.ask.check):
        return 0.0
    scene = Scene(finger=case.finger, indenter=case.indenter, motion=case.motion, ask=case.ask)
    finger = mechanics.coarser(scene)
    if finger is None:
        return 0.0
    lean = replace(case, finger=finger, ask=replace(case.ask, fields=False, pressure=False))
    return mechanics.cost(lean) + costs.spike_seconds(lean)


def _check_force(case: Situation) -> None:
    """Raise InputError for a force that no tissue bears, with the unit that it is likely in."""
    force = case.motion.hardest
    if force is None or case.depth_over_thickness < PULP:
        return
    raise InputError(
        f"motion.force: expected N, at most what the tissue under the pad bears ({PULP:g} of the "
        f"finger's thickness), received {force:.4g} N, which would press to some "
        f"{case.depth_over_thickness:.2g} of it{FORCE.hint(force)}; convert it, or press less"
    )


def _cheapest(case: Situation, rungs: tuple[Rung, ...]) -> Rung:
    willing = [rung for rung in rungs if _willing(rung)]
    if willing:
        blurs = {each: case.feels_texture and MECHANICS[each].meshed for each in names()}
        return min(willing, key=lambda rung: (blurs[rung.mechanics], rung.seconds))
    _check_meshable(rungs)
    odd = "".join(f"{each[0].upper()}{each[1:]}. " for each in unusual(case))
    deepest = case.motion.deepest
    # A scene that is refused may have been written in m.
    if deepest is not None and deepest < 0.01:
        odd = f"It presses {deepest:g} mm deep: lengths are in mm, not in m. "
    raise InputError(
        f"ask: no mechanics is known to answer this scene within the limits. {odd}{relaxing(rungs)}"
        f"{_unchecked(case)}{vibration.advice(case)}{_by_name(rungs)}\n\n{written(rungs)}"
    )


def _check_meshable(rungs: tuple[Rung, ...]) -> None:
    """Raise InputError for a finger that no mesh can be made of where nothing else answers."""
    unable = {rung.mechanics: _about_ability(rung.refusals) for rung in rungs}
    if not all(unable.values()):
        return
    faults = {
        refusal.reason
        for rung in rungs
        if MECHANICS[rung.mechanics].meshed
        for refusal in rung.refusals
        if refusal.field == "finger"
    }
    if len(faults) == 1 and all(faults <= set(unable[name]) for name in meshed() if name in unable):
        raise InputError(
            f"{faults.pop()}. No mesh can be made of this finger, and no mechanics without one "
            "answers this scene"
        )


def _by_name(rungs: tuple[Rung, ...]) -> str:
    """Suggest the mechanics to name: of those refused for their error or time alone the most exact.

    Else the one with the fewest other refusals, of those whose errors are not known one of finite
    strain. Each counts on the mesh that it has when it is named.
    """
    able = [rung for rung in rungs if not _about_ability(rung.refusals)]
    if not able:  # By the reason that most of them share, if there is one.
        reasons = Counter(reason for rung in rungs for reason in _about_ability(rung.refusals))
        reason, count = reasons.most_common(1)[0]
        shared = f" {count} of {len(rungs)} refuse because of {reason}." if count > 1 else ""
        return f"None is able to.{shared} The table says what would have to change."

    def ranked(rung: Rung) -> tuple[float, ...]:
        error = math.inf if math.isnan(rung.error) else rung.error
        others = sum(refusal.field not in (ERROR, SECONDS) for refusal in rung.refusals)
        return others, error, not MECHANICS[rung.mechanics].finite, rung.seconds

    named = [_named(rungs, name) for name in dict.fromkeys(rung.mechanics for rung in able)]
    best = min(named, key=ranked)
    return (
        f"To run it all the same, in about {duration(best.wall)}, name {best.mechanics} "
        f"(--mechanics {best.mechanics}); the result then notes: "
        f"{'; '.join(refusal.reason for refusal in best.refusals)}."
    )


def _unchecked(case: Situation) -> str:
    """Suggest the coarsest mesh, which the check of spike counts leaves out."""
    if not case.ask.spikes or case.finger.resolution != AUTO:
        return ""
    coarse = case.on(RESOLUTIONS[0])
    inertia = _Inertia(coarse)
    able = [
        rung for name in meshed() for rung in _rungs(name, coarse, inertia) if not rung.refusals
    ]
    if not able:
        return ""
    best = min(able, key=lambda rung: rung.seconds)
    return (
        f"Or set finger.resolution to {RESOLUTIONS[0]!r} and {best.mechanics} answers in "
        f"{duration(best.wall)}, with spike counts that no coarser mesh checks. "
    )


def _named(rungs: tuple[Rung, ...], mechanics: str) -> Rung:
    """Return the rung of a mechanics: the cheapest that does not refuse, or the standard mesh."""
    candidates = [rung for rung in rungs if rung.mechanics == mechanics]
    unable = _about_ability(candidates[0].refusals)
    if unable:
        reasons = "\n".join(f"  {mechanics}: ability: {reason}" for reason in unable)
        raise InputError(f"mechanics: {mechanics!r} cannot answer this scene\n{reasons}")
    willing = [rung for rung in candidates if not rung.refusals]
    if willing:
        return min(willing, key=lambda rung: rung.seconds)
    return next((rung for rung in candidates if rung.resolution == STANDARD), candidates[0])


def _settings(case: Situation, chosen: Rung) -> Settings:
    ask = case.ask
    return Settings(
        resolution=chosen.resolution,
        half=None if chosen.resolution is None else case.half,
        times=len(case.times),
        computed=("force", *(x for x in OUTPUTS if ask.wants(x))),
        afferents=ask.spikes,
    )


def _sentence(
    case: Situation, chosen: Rung, considered: Sequence[Rung], settings: Settings, *, named: bool
) -> str:
    """Return the choice in words: why, what is computed and built, what was left out."""
    how = "as named" if named else "the cheapest that does not refuse"
    if not named and case.feels_texture and not MECHANICS[chosen.mechanics].meshed:
        how = "the cheapest without a mesh that does not refuse: units feel the vertices of a mesh"
    sentence = f"{chosen.mechanics}, {how}. {settings.described}{_built(case, chosen)}"
    sentence += "".join(f" Caution: {each}." for each in unusual(case))
    tried = {rung.mechanics for rung in considered}
    left_out = [name for name in names() if name not in tried]
    if left_out and not named:
        sentence += f" Not considered, because slower and not needed: {', '.join(left_out)}."
    if chosen.refusals:
        reasons = "; ".join(refusal.reason for refusal in chosen.refusals)
        sentence += f" It would have refused: {reasons}."
    return sentence


def _built(case: Situation, rung: Rung) -> str:
    """State the part of the expected time that is spent once; "" where there is none."""
    if rung.resolution is None:
        return ""
    on_mesh = case.on(rung.resolution)
    again = rung.seconds - get(rung.mechanics).once(on_mesh)
    spent, without = (costs.wall(rung.mechanics, on_mesh, each) for each in (rung.seconds, again))
    first = spent - without
    return f" What is built once and kept takes {duration(first)} of the time." if first else ""

"""Which mechanics answers a scene: the cheapest one that does not refuse."""

import math

from fefinger import mechanics as ladder
from fefinger.checks import InputError, choice
from fefinger.records import Plan, Refusal, Rung
from fefinger.scene import Scene


def explain(scene: Scene) -> Plan:
    """Return the choice for a scene and the ladder that it was chosen from; nothing is solved.

    Raises
    ------
    InputError
        If every mechanics refuses; the message lists their reasons.
    """
    return choose(scene)


def choose(scene: Scene, mechanics: str | None = None) -> Plan:
    """Return the plan for a scene, with the cheapest mechanics or with the one named.

    A mechanics that is named runs in spite of refusals about accuracy or time, which the plan
    records; refusals about ability stand.

    Raises
    ------
    InputError
        If every mechanics refuses, or the one that is named is not able to answer.
    """
    rungs = tuple(_rung(name, scene) for name in ladder.names())
    if mechanics is None:
        return _cheapest(rungs)
    choice("mechanics", mechanics, ladder.names())
    named = next(rung for rung in rungs if rung.mechanics == mechanics)
    unable = [refusal for refusal in named.refusals if refusal.about == "ability"]
    if unable:
        msg = f"mechanics: {mechanics!r} cannot answer this scene\n{_listed([named])}"
        raise InputError(msg)
    sentence = f"{mechanics}, as named; {_expectation(named)}."
    if named.refusals:
        reasons = "; ".join(refusal.reason for refusal in named.refusals)
        sentence += f" It would have refused: {reasons}."
    return Plan(mechanics, rungs, sentence, named.refusals)


def _cheapest(rungs: tuple[Rung, ...]) -> Plan:
    willing = [rung for rung in rungs if not rung.refusals]
    if not willing:
        msg = (
            f"ask: no mechanics can answer this scene as it is asked\n{_listed(rungs)}\n"
            "Relax ask.rel_error or ask.seconds, or name a mechanics to run it all the same "
            "(where it is able to); the result then records the refusals."
        )
        raise InputError(msg)
    chosen = min(willing, key=lambda rung: rung.seconds)
    sentence = f"{chosen.mechanics}, the cheapest that does not refuse; {_expectation(chosen)}."
    return Plan(chosen.mechanics, rungs, sentence)


def _rung(name: str, scene: Scene) -> Rung:
    """Ask one mechanics what it would cost, how wrong it would be and why it refuses."""
    candidate = ladder.get(name)
    refusals = candidate.refuse(scene)
    if any(refusal.about == "ability" for refusal in refusals):
        return Rung(name, math.nan, math.nan, "not able", refusals)
    seconds, (error, evidence) = candidate.cost(scene), candidate.error(scene)
    asked = scene.ask
    if error > asked.rel_error:
        reason = f"expected relative error = {error:.2g} > {asked.rel_error:g} (ask.rel_error)"
        refusals = (*refusals, Refusal(name, "accuracy", reason))
    if asked.seconds is not None and seconds > asked.seconds:
        reason = f"expected time = {seconds:.2g} s > {asked.seconds:g} s (ask.seconds)"
        refusals = (*refusals, Refusal(name, "time", reason))
    return Rung(name, seconds, error, evidence, refusals)


def _expectation(rung: Rung) -> str:
    return f"expected error {rung.error:.2g} ({rung.evidence}), about {rung.seconds:.2g} s"


def _listed(rungs: list[Rung] | tuple[Rung, ...]) -> str:
    return "\n".join(
        f"  {rung.mechanics}: {refusal.about}: {refusal.reason}"
        for rung in rungs
        for refusal in rung.refusals
    )

"""Text about a plan: the table of mechanics with their refusals, and expected errors."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from fefinger.results.candidate import MECHANICS
from fefinger.scene.ask import OUTPUTS
from fefinger.support.processes import threads
from fefinger.support.text import duration, percent, table


if TYPE_CHECKING:
    from fefinger.results.records import Rung
    from fefinger.scene.ask import Ask


QUANTITIES = {
    "force": "force",
    "pressure": "highest pressure over 1 mm²",
    "area": "contact area",
    "strain": "strain at the end organs",
}
"""Names of the quantities whose errors are stated."""


ERROR, SECONDS = "ask.rel_error", "ask.seconds"
"""Fields of the scene that limit the error and the time of an answer."""

WIDE = 0.3
"""Error above which the range of the true value is shown."""


def true_range(error: float) -> tuple[float, float]:
    """Return the least and the largest true value over the answer, for an error of the true value.

    The answer is within 1 - error and 1 + error of the true value: for 1 or more there is no upper
    limit (inf).
    """
    return 1 / (1 + error), 1 / (1 - error) if error < 1 else math.inf


def range_text(error: float, answer: float, unit: str) -> str:
    """Return the range of the true value in words, as in "true value 0.09 to 1.4 N"."""
    if math.isinf(error):
        return "its error has no limit"
    low, high = (f"{float(f'{answer * end:.2g}'):g}" for end in true_range(error))
    # The upper limit would be 20 times the answer or more.
    if error >= 0.95:
        return f"true value at least {low} {unit}, upper limit not known"
    return f"true value {low} to {high} {unit}"


def ladder(rungs: Sequence["Rung"], chosen: "Rung | None" = None) -> str:
    """Return the table of the ladder, a line per reason of refusal, and the sources of the errors.

    A star marks the chosen rung.
    """
    rows, before = [], None
    for rung in rungs:
        reasons = _reasons(rung)
        if before and rung.mechanics == before.mechanics and reasons == _reasons(before) != []:
            reasons = [f"as on the {before.resolution} mesh"]
        before = rung
        star = "*" if rung is chosen else ""
        mesh, error, seconds = rung.resolution or "-", percent(rung.error), duration(rung.wall)
        first = reasons[0] if reasons else "chosen" if star else "good enough"
        rows.append((star, rung.mechanics, mesh, error, seconds, first))
        rows += [("", "", "", "", "", more) for more in reasons[1:]]
    heading = ("", "mechanics", "mesh", "error", "time", "verdict")
    sources = _sources(rungs)
    return table(rows, heading) + (f"\n\n{sources}" if sources else "")


def _reasons(rung: "Rung") -> list[str]:
    """Return the refusals of a rung; refusals for the same reason share a line."""
    fields_of: dict[tuple[str, str], list[str]] = {}
    for refusal in rung.refusals:
        named = bool(refusal.field) and refusal.reason.startswith(refusal.field)
        rest = refusal.reason.removeprefix(refusal.field) if named else refusal.reason
        fields_of.setdefault((refusal.about, rest), []).append(refusal.field if named else "")
    return [f"{about}: {', '.join(names)}{rest}" for (about, rest), names in fields_of.items()]


def choice_line(rung: "Rung") -> str:
    """Return mechanics, mesh, expected error of the force and expected time in one line."""
    mesh = f" on the {rung.resolution} mesh" if rung.resolution else ""
    known = math.isfinite(rung.error)
    error = f"force within {percent(rung.error)}" if known else "error of the force not known"
    return f"{rung.mechanics}{mesh}: {error}, solved in about {expected_time(rung)}."


def expected_time(rung: "Rung") -> str:
    """Return the expected wall time, with the number of cores if several share the work."""
    shared = rung.wall < rung.seconds
    return duration(rung.wall) + (f" on {threads()} cores" if shared else "")


def trust(rung: "Rung", ask: "Ask") -> str:
    """Return sentences on the expected errors of the requested quantities.

    Where the motion prescribes the force, errors are of the force at the depth of the answer, of
    the largest depth, and of the others at that force.
    """
    errors = {"force": rung.error, **rung.errors}
    pressure = ask.wants("pressure")
    requested = ask.force, pressure, pressure, ask.wants("strain") or ask.spikes
    wanted = [name for name, wish in zip(QUANTITIES, requested, strict=True) if wish]
    known = [name for name in wanted if math.isfinite(errors.get(name, math.nan))]
    unknown = [QUANTITIES[name] for name in wanted if name not in known]
    words = QUANTITIES
    if "depth" in errors:
        known = ["depth", *known]
        words = QUANTITIES | {"force": "force at the depth", "depth": "largest depth"}
    bounds = ", ".join(f"{words[name]} {_bound(errors[name])}" for name in known)
    sentences = [f"Expected within: {bounds}."] if known else []
    if ask.spikes:
        unknown.append("spikes")
    sentences += [f"Error not known: {', '.join(unknown)}."] if unknown else []
    return " ".join(sentences)


def _bound(error: float) -> str:
    """Return an error in percent, with the range of the true value if it is large."""
    wide = f" ({range_text(error, 1.0, 'times the answer')})" if error > WIDE else ""
    return f"{percent(error)}{wide}"


def _sources(rungs: Sequence["Rung"]) -> str:
    """Return a table of the sources of errors and the mechanics they are of; "" without any."""
    by_source: dict[str, list[str]] = {}
    for rung in rungs:
        if not math.isnan(rung.error):
            by_source.setdefault(rung.evidence, []).append(rung.candidate.label)
    rows = [(", ".join(names), source) for source, names in by_source.items()]
    return table(rows, ("error of", "evidence")) if rows else ""


def left_out(ask: "Ask", mechanics: str) -> tuple[str, ...]:
    """Return a note on outputs that a scene leaves open and its mechanics cannot give."""
    given = MECHANICS[mechanics].outputs
    names = [f"ask.{each}" for each in OUTPUTS if getattr(ask, each) is None and each not in given]
    if not names:
        return ()
    return (f"Left out, as {mechanics} cannot give it: {', '.join(names)}.",)


def relaxing(rungs: "tuple[Rung, ...]") -> str:
    """Suggest the smallest error or time to allow, and name the mechanics that then answers."""
    sentences = ""
    for quantity, field in (("error", ERROR), ("wall", SECONDS)):
        close = [
            rung
            for rung in rungs
            if rung.refusals
            and all(refusal.field == field for refusal in rung.refusals)
            # An error of 1 or more is not worth allowing.
            and rung.error < 1.0
        ]
        if close:
            best = min(close, key=lambda rung: float(getattr(rung, quantity)))
            needed = float(getattr(best, quantity))
            least = float(f"{1.005 * needed:.2g}")
            while least < needed:
                least *= 1.01
            mesh = f" on the {best.resolution} mesh" if best.resolution else ""
            sentences += f"Relax {field} to {least:.3g} and {best.mechanics}{mesh} answers. "
    return sentences

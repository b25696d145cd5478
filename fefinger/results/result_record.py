"""Records of a plan, with its text, and of a result; `netcdf` saves and loads them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.results.records import Fields, Harmonic, Lateral, Pad, Refusal, Response, Rung, Sites
from fefinger.scene.ask import OUTPUTS
from fefinger.scene.cautions import quasistatic, unmodeled, warnings
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.processes import threads
from fefinger.support.text import duration, percent, table


if TYPE_CHECKING:
    from fefinger.neural.trains import SpikeTrains
    from fefinger.results.records import Rung
    from fefinger.scene.ask import Ask


@dataclass(frozen=True)
class Settings:
    """Settings of a run.

    resolution of the mesh, and half: whether half a finger is meshed, both None without a mesh;
    times: number of output times; computed: of "force", "pressure", "strain", "fields"; afferents:
    simulated types.
    """

    resolution: str | None
    half: bool | None
    times: int
    computed: tuple[str, ...]
    afferents: tuple[str, ...]

    @property
    def described(self) -> str:
        """What is computed, at how many times, and on which mesh, in a sentence."""
        mesh = ""
        if self.resolution is not None:
            half = "half a" if self.half else "the whole"
            mesh = f" on the {self.resolution} mesh of {half} finger"
        what = ", ".join(self.computed)
        fibers = f" and the spikes of {', '.join(self.afferents)}" if self.afferents else ""
        return f"It computes {what}{fibers} at {self.times} times{mesh}."


@dataclass(frozen=True)
class Plan:
    """The chosen mechanics, its settings, and all candidates that were compared.

    sentence: why it was chosen; overridden: refusals of a mechanics that the user named; machine:
    what the times of the rungs mean; trust: expected errors of the requested quantities, in words;
    tried: refusals of the mechanics that were chosen first and found the scene beyond their limits.
    """

    mechanics: str
    rungs: tuple[Rung, ...]
    sentence: str
    overridden: tuple[Refusal, ...] = ()
    settings: Settings | None = None
    machine: str = ""
    trust: str = ""
    tried: tuple[Refusal, ...] = ()

    def __repr__(self) -> str:
        """Show the choice, its reason, its expected errors, and the ladder."""
        rung = self.chosen
        parts = choice_line(rung), self.sentence, self.trust, ladder(self.rungs, rung)
        return "\n\n".join(filter(None, parts))

    @property
    def on(self) -> str:
        """Mechanics and mesh, as in "pressed on the standard mesh"."""
        mesh = self.settings.resolution if self.settings else None
        return Candidate(self.mechanics, mesh).on

    @property
    def chosen(self) -> Rung:
        """The rung of the chosen mechanics, on its mesh."""
        wanted = Candidate(self.mechanics, self.settings.resolution if self.settings else None)
        rungs = [rung for rung in self.rungs if rung.mechanics == self.mechanics]
        return next((rung for rung in rungs if rung.candidate == wanted), rungs[0])


@dataclass(frozen=True)
class ResultRecord:
    """Result of a scene: response of the mechanics, spikes, plan and provenance."""

    scene: Scene
    plan: Plan
    response: Response
    spikes: "SpikeTrains | None"
    status: str
    seconds: dict[str, float]
    provenance: dict[str, Any]

    @property
    def time(self) -> Array:
        """Times (n_t,) in s."""
        return self.response.time

    @property
    def depth(self) -> Array:
        """Travel of the indenter (n_t,) in mm, 0 at first touch."""
        return self.response.depth

    @property
    def force(self) -> Array | None:
        """Force of the whole finger (n_t,) in N, along the indenter's normal."""
        return self.response.force if self.scene.ask.force else None

    @property
    def peak(self) -> int:
        """Step of the largest force; where the force is prescribed, of the largest depth.

        A held force differs only by rounding from step to step, while the tissue creeps: then the
        deepest step is the end of the hold.
        """
        answer = self.scene.motion.control.of(self.response.force, self.depth)
        return int(np.argmax(answer))

    @property
    def peak_name(self) -> str:
        """The quantity that is largest at the step `peak`, in words."""
        return f"the largest {self.scene.motion.control.other}"

    @property
    def contact_area(self) -> Array | None:
        """Contact area (n_t,) in mm²."""
        return self.response.contact_area

    @property
    def centroid(self) -> Array | None:
        """Pressure centroid (n_t, 2) in mm (x, y)."""
        return self.response.centroid

    @property
    def lateral(self) -> Lateral | None:
        """Path, lateral force, stick and slip of an indenter that slides or grips."""
        return self.response.lateral

    @property
    def pad(self) -> Pad | None:
        """Points of the pad where the pressure is reported."""
        return self.response.pad

    @property
    def pressure(self) -> Array | None:
        """Contact pressure (n_t, n_pad) in kPa, positive in compression."""
        return self.response.pressure

    @property
    def meshed(self) -> bool:
        """Whether pressure is known at the vertices of a mesh, not at the points of a grid."""
        return MECHANICS[self.response.mechanics].meshed

    @property
    def one_point(self) -> str:
        """What a highest pressure at one place is that of, in words."""
        return "a vertex of the mesh" if self.meshed else "a point of the grid"

    @property
    def sites(self) -> Sites | None:
        """The end-organ sites."""
        return self.response.sites

    @property
    def harmonic(self) -> Harmonic | None:
        """Response to small oscillations about the preload; None unless the motion is a sweep."""
        return self.response.harmonic

    @property
    def strain(self) -> Array | None:
        """Strain tensor (n_t, n_sites, 3, 3) at the sites, positive in tension.

        Small strain; logarithmic strain where `Response.finite`, as of `pressed` and `solid`.
        """
        return self.response.strain

    @cached_property
    def principal(self) -> tuple[Array, Array]:
        """Smallest and largest principal strain at the sites, (n_t, n_sites) each."""
        if self.strain is None:
            raise InputError("ask.strain: expected true for principal strains, received false")
        from fefinger.support.tensors import extremes  # compiled

        return extremes(self.strain)

    @property
    def green_lagrange(self) -> Array | None:
        """Green-Lagrange strain (n_t, n_sites, 3, 3) at the sites, where the strain is finite.

        E = (F'F - I) / 2 = (exp(2 H) - I) / 2, from the logarithmic strain H = ln(F'F) / 2 in
        `strain`, both in the directions of the undeformed finger. None where `strain` is small
        strain, for which the two measures agree.
        """
        if self.strain is None or not self.response.finite:
            return None
        values, vectors = np.linalg.eigh(self.strain)
        scaled = vectors * (np.expm1(2 * values) / 2)[..., None, :]
        return np.asarray(scaled @ np.swapaxes(vectors, -1, -2))

    @property
    def fields(self) -> Fields | None:
        """Fields on the mesh; None unless requested."""
        return self.response.fields

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about samples of the motion, and about its speed if inertia is left out."""
        of_motion = warnings(self.scene.motion)
        if self.response.inertia:
            return of_motion
        return of_motion + quasistatic(self.scene, self.time, self.depth)

    @property
    def unmodeled(self) -> tuple[str, ...]:
        """Types of units whose cause to fire is not in the mechanics (`scene.cautions`)."""
        spikes = self.spikes is not None and not self.response.inertia
        return unmodeled(self.scene) if spikes else ()

    @property
    def notes(self) -> tuple[str, ...]:
        """Simplifications and choices that a reader of the result must know."""
        return self.response.notes + (self.spikes.notes if self.spikes is not None else ())


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

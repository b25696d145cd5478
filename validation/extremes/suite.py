"""Suite `extremes`: scenes and problems at the edges of every range, named and drawn by seed.

Each ends as an answer whose invariants hold, or as a refusal in a sentence. The value of a case is
the worst violation of an invariant over the most that is allowed, 0 for a refusal; a crash, a
warning of Python, a number that is not finite and too long a time fail.
"""

from collections.abc import Callable, Iterator
from functools import partial

from fefinger.validation.case import Case, Expected, Noted
from fefinger.validation.extremes import bodies, drawings, drawn, nerve, scenes, theory
from fefinger.validation.extremes.trial import Trial, ending


PARTS: tuple[Callable[[], tuple[Trial, ...]], ...] = (
    scenes.trials,
    drawn.trials,
    theory.trials,
    bodies.trials,
    nerve.trials,
)

QUICK = ("lumped", "hertz", "theory")
"""Groups whose trials take milliseconds."""

SLOW = ("cycles", "stack", "contact in and out")
"""Edges of them that take seconds."""

SOURCES = {
    "answered": "invariants, closed forms, twins; has to answer",
    "refused": "has to refuse in a sentence",
    "either": "invariants, closed forms, twins; or a refusal in a sentence",
}

EVERY = 3
"""Of the trials of QUICK, one in so many is for a quick look."""

MESHED = (
    ("linear", "time step", "a jump to 0.6 mm"),
    ("condensed", "time step", "a jump to 0.6 mm"),
    ("solid", "finite strain", "at 1e4 mm/s"),
)
"""Group, edge and name of those on a mesh, the coarse one, that a quick look takes too."""


def trials(*, quick: bool) -> tuple[Trial, ...]:
    """Return all trials; `quick` takes some of those that take milliseconds, and MESHED."""
    every = tuple(trial for part in PARTS for trial in part())
    if not quick:
        return every
    fast = [trial for trial in every if trial.group in QUICK and trial.edge not in SLOW]
    meshed = [trial for trial in every if (trial.group, trial.edge, trial.name) in MESHED]
    return (*fast[::EVERY], *meshed)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield one case per trial."""
    for trial in trials(quick=quick):
        name = f"{trial.group}, {trial.edge}: {trial.name}"
        limits = Expected(0.0, 1.0, "of the limit")
        yield Case(name, partial(_measured, trial), limits, SOURCES[trial.wants or "either"])


def _measured(trial: Trial) -> Noted:
    end = ending(trial)
    return Noted(end.worst, f"{end.kind}: {end.text}")


figures_of = drawings.figures
finding_of = drawings.finding

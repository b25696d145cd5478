"""List and run the validation suites by name."""

import math
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, cast

from fefinger.validation.case import Case, Noted, Outcome

from fefinger.support.checks import InputError, suggestion
from fefinger.support.registry import load_plugin
from fefinger.view.figures import style


ABOUT = {
    "fem": "Finite elements against Hertz, exact layers, Ting and closed forms at finite strain.",
    "finger": "Whole fingers: equilibrium, mirror images, and what each assumption of Hertz costs.",
    "condensed": "The condensed finger against the whole mesh that it was reduced from.",
    "friction": "Sliding and friction: Mindlin, limits, other methods, and what fingers show.",
    "pressed": "Tabulated presses at finite strain through time, against `solid` on the same mesh.",
    "soft": "Soft objects: what stands for them, against meshed bodies at finite strain.",
    "waves": "Inertia and vibration against closed forms, a second method and published fingers.",
    "calibration": "Recovery of known tissue from synthetic fingers, and the calibrated subjects.",
    "neural": "Membranes, filters, end organs and spikes against adaptive and closed solutions.",
    "afferents": "The afferents of the family recorded against published recordings.",
    "human": "The default finger against what was measured on people.",
    "thesis": "Every table, figure and claim of the source thesis that can be reproduced.",
    "tradeoff": "Error and cost of every mechanics and setting, from which the planner chooses.",
    "extremes": "Extreme scenes: each ends as a checked answer or as a refusal.",
}
"""What each suite compares."""

SUITES = tuple(ABOUT)

QUICK = (
    "A quick run: cases that take more than a few seconds are left out, and with them all figures "
    "and tables, which are computed from the whole suite."
)


GROUP = "fefinger.suites"
"""Group of the entry points by which a distribution offers suites."""


def module_of(suite: str) -> ModuleType:
    """Import a suite: one of the package, an entry point, or a module of the user's own.

    A module is looked up in the working folder, and then on the path of Python; its code is run.

    Raises InputError for no such suite, a module whose code fails, or one without a function
    `cases`.
    """
    if suite in SUITES:
        return import_module(f"fefinger.validation.{suite}.suite")
    offered = {point.name: point for point in entry_points(group=GROUP)}
    if suite in offered:
        module = offered[suite].load()
    elif os.path.isfile(f"{suite}.py") or (suite.isidentifier() and find_spec(suite)):
        load_plugin(suite, Path())
        module = sys.modules[suite]
    else:
        expected = (*SUITES, *offered)
        raise InputError(
            f"suite: expected one of {', '.join(expected)}, or a module of your own in this folder "
            f"or on the path of Python, received {suite!r}.{suggestion(suite, expected)}"
        )
    if not callable(getattr(module, "cases", None)):
        raise InputError(
            f"suite {suite!r}: expected a module with a function cases(quick), which returns Cases "
            "(fefinger.validation.case), received one without it"
        )
    return cast(ModuleType, module)


def about(suite: str) -> str:
    """Return what a suite compares: of a user's own, the first line of its docstring."""
    return ABOUT.get(suite) or (module_of(suite).__doc__ or suite).strip().split("\n")[0]


def cases(suite: str, *, quick: bool) -> tuple[Case, ...]:
    """Return the cases of a suite; `quick` leaves out what takes more than a few seconds."""
    return tuple(module_of(suite).cases(quick=quick))


def figures(record: dict[str, Any]) -> dict[str, list[tuple[str, Any]]]:
    """Return the figures (caption, matplotlib Figure) of those suites of a record that draw some.

    A suite draws what it knows (`figures`), or what came out of its cases (`figures_of`).
    """
    drawn = {}
    with style():
        for suite, module, cases in _recorded(record):
            if hasattr(module, "figures_of"):
                drawn[suite] = list(module.figures_of(cases))
            elif hasattr(module, "figures"):
                drawn[suite] = list(module.figures())
    return drawn


def findings(record: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Collect the subject of the suites of a record, with texts and tables of their findings.

    A suite says what it knows (`finding`), or what came out of its cases (`finding_of`).
    """
    results = {}
    for suite, module, cases in _recorded(record):
        finding = module.finding_of(cases) if hasattr(module, "finding_of") else {}
        finding = module.finding() if hasattr(module, "finding") else finding
        results[suite] = {"about": about(suite)} | finding
    return results


def subjects(record: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the subject of the suites of a record alone, for the page of a quick run."""
    return {suite: {"about": about(suite), "texts": [QUICK]} for suite, _, _ in _recorded(record)}


def _recorded(record: dict[str, Any]) -> Iterator[tuple[str, Any, list[dict[str, Any]]]]:
    """Give name, module and cases of the suites of a record that are known here."""
    for suite in record["suites"]:
        with suppress(InputError):  # as one of a user's own, whose module is elsewhere
            yield suite["suite"], module_of(suite["suite"]), suite["cases"]


def run(
    suites: Sequence[str] = (),
    *,
    quick: bool = False,
    progress: Callable[[str, float], None] = lambda stage, fraction: None,
) -> dict[str, tuple[Outcome, ...]]:
    """Measure every case of the suites named; by default of all."""
    chosen = suites or SUITES
    for suite in chosen:
        module_of(suite)  # an unknown one is refused before any is measured
    outcomes: dict[str, tuple[Outcome, ...]] = {}
    for suite in chosen:
        todo = cases(suite, quick=quick)
        done = []
        for number, case in enumerate(todo):
            progress(suite, number / len(todo))
            done.append(_measured(case))
        progress(suite, 1.0)
        outcomes[suite] = tuple(done)
    return outcomes


def _measured(case: Case) -> Outcome:
    """Measure a case; one that breaks fails by itself and costs no other."""
    try:
        measured = case.measure()
        value, sentence = float(measured), measured.text if isinstance(measured, Noted) else ""
    except Exception as error:  # whatever it is, the outcome says so
        return Outcome(case, math.nan, f"{type(error).__name__}: {error}")
    return Outcome(
        case, value, "" if math.isfinite(value) else f"the measure gave {value}", sentence
    )


def as_json(outcomes: dict[str, tuple[Outcome, ...]]) -> dict[str, Any]:
    """Return the outcomes as plain records, in the form that `validate --json` prints."""
    return {
        "suites": [
            {"suite": suite, "cases": [_record(outcome) for outcome in done]}
            for suite, done in outcomes.items()
        ]
    }


def _record(outcome: Outcome) -> dict[str, Any]:
    case = outcome.case
    return {
        "name": case.name,
        "value": None if outcome.failure else outcome.value,
        "expected": case.expected.value,
        "tolerance": case.expected.tolerance,
        "unit": case.expected.unit,
        "source": case.source,
        "printed": case.printed,
        "erratum": case.erratum,
        "wanted": case.wanted,
        "shortfall": case.shortfall,
        "reason": case.reason,
        "failure": outcome.failure,
        "note": outcome.note,
        "verdict": outcome.verdict,
    }

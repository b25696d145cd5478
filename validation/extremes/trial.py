"""A trial at an edge: it ends as an answer that was checked, as a refusal in a sentence, or fails.

What fails: a value that is not finite, an invariant that is broken, an error that is no sentence, a
warning from Python, too long a time, and an end that is not the one that was expected.
"""

import signal
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import Literal

from fefinger.support.checks import ConvergenceError, InputError


Findings = dict[str, tuple[float, float]]
"""By invariant: how far it is violated, and the most that may be; both 0 or above, no unit."""

SECONDS = 60.0
"""CPU time of a trial, beyond which it fails."""

WORST = 1e6
"""What stands for a violation of a limit that is zero, or for none that can be measured."""

THEORY = "theory"
"""The group of trials that call theory, not scenes."""

Kind = Literal["answered", "refused", "failed"]

ANSWERED: Kind = "answered"
REFUSED: Kind = "refused"
FAILED: Kind = "failed"


class TookTooLongError(Exception):
    """A trial that used up its time."""


@dataclass(frozen=True)
class Trial:
    """One scene or problem at an edge.

    group: who answers; edge: which range it is at the end of; ask: answers, and returns what was
    found of every invariant; wants: "answered" or "refused" where only that is right.
    """

    group: str
    edge: str
    name: str
    ask: Callable[[], Findings]
    wants: Kind | None = None


Row = tuple[str, str, Callable[[], Findings], Kind | None]
"""A Trial without its group."""


def grouped(group: str, *parts: Callable[[], Iterator[Row]]) -> tuple[Trial, ...]:
    """Return the trials of a group, in the order of its parts."""
    return tuple(Trial(group, *row) for part in parts for row in part())


@dataclass(frozen=True)
class Ending:
    """How a trial ended; worst: the largest violation over its limit."""

    kind: Kind
    worst: float
    text: str


_ENDED: dict[Trial, Ending] = {}


def ending(trial: Trial) -> Ending:
    """Run a trial once; return its outcome."""
    if trial not in _ENDED:
        _ENDED[trial] = _run(trial)
    return _ENDED[trial]


def _run(trial: Trial) -> Ending:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            with limited(SECONDS):
                end = _judged(trial.ask())
        except (InputError, ConvergenceError) as refusal:
            end = Ending(REFUSED, 0.0, str(refusal))
        except ValueError as refusal:
            # The theory imports nothing, so its sentences are plain ValueErrors.
            spoken = trial.group == THEORY and "expected" in str(refusal)
            end = Ending(REFUSED, 0.0, str(refusal)) if spoken else _crash(refusal)
        except Exception as crash:
            end = _crash(crash)
    if caught:
        first = caught[0]
        return Ending(FAILED, WORST, f"warned of {first.category.__name__}: {first.message}")
    if trial.wants not in (None, end.kind) and end.kind != FAILED:
        return Ending(FAILED, WORST, f"not {trial.wants}, but {end.kind}: {end.text}")
    return end


def _judged(findings: Findings) -> Ending:
    if not findings:
        return Ending(FAILED, WORST, "answered, but nothing was checked of it")
    ratios = {name: _ratio(*finding) for name, finding in findings.items()}
    worst = max(ratios, key=ratios.__getitem__)
    kind: Kind = ANSWERED if ratios[worst] <= 1 else FAILED
    checked = ", ".join(f"{name} {_said(*finding)}" for name, finding in findings.items())
    text = f"off by {checked}; nearest to its limit: {worst}"
    if kind == FAILED:
        value, limit = findings[worst]
        text = f"answered, but {worst}: {value:.3g} > {limit:.3g}"
    return Ending(kind, ratios[worst], text)


def _said(violation: float, limit: float) -> str:
    """Return a violation with the most that it may be, unless that is nothing."""
    return f"{violation:.3g} of {limit:.3g}" if limit else f"{violation:.3g}"


def _ratio(violation: float, limit: float) -> float:
    if violation <= limit:
        return violation / limit if limit else 0.0
    return min(violation / limit, WORST) if limit else WORST


def _crash(error: Exception) -> Ending:
    return Ending(FAILED, WORST, f"crashed with {type(error).__name__}: {error}")


@contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise TookTooLongError after so much CPU time, where the system has a timer for it."""
    if not hasattr(signal, "setitimer") or threading.current_thread() != threading.main_thread():
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        message = f"took more than {seconds:g} s"
        raise TookTooLongError(message)

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)

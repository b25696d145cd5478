"""What rigs rarely do: tried after a fit, and kept where the records show it."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from fefinger.calibration.outcome import FitResult, is_seen
from fefinger.calibration.press_store import Work
from fefinger.calibration.records_target import presses, together
from fefinger.calibration.rig import Prior, Rig


RARE = {"compliance": 0.05, "lag": 2.0}
"""Standard deviations in mm/N and ms of what a rig may do although nothing was said of it: the
give of a stage with a load cell, and a filter of 80 Hz."""


def with_rare(result: FitResult, work: Work, fit: Callable[[FitResult], FitResult]) -> FitResult:
    """Free what rigs rarely do, and keep it where the records show it and are met better.

    Of two, first the one that meets them better: each may take up a part of the other. fit: makes a
    fit from the values and the target of another.
    """
    rare = [name for name in RARE if _is_default(result, name)]
    while rare:
        fits = {}
        for name in rare:
            with work.stage(f"{name} of the rig") as misfit:
                fits[name] = fit(freed(result, name, (0.0, RARE[name])))
                misfit(fits[name].solution.misfit)
        best = min(rare, key=lambda name: missed(fits[name]))
        found = fits[best].solution
        seen = is_seen(best, found.values[best], found.deviations[best])
        if not seen or missed(fits[best]) >= missed(result):
            break
        result = fits[best]
        rare.remove(best)
    return result


def _is_default(result: FitResult, name: str) -> bool:
    """Whether there are records, and nothing was said of a part of their rig."""
    records = presses(result.target)
    return bool(records) and getattr(records[0].rig, name) == getattr(Rig, name)


def freed(result: FitResult, name: str, prior: Prior) -> FitResult:
    """Return a fit to start from, of records whose rig has another prior of something.

    The covariance holds the least errors of the model: others would hide what it does.
    """
    loose: Any = {name: prior}
    law, values = result.law, result.solution.values
    records = [
        replace(each, rig=replace(each.rig, **loose)).trusting(law, values)
        for each in presses(result.target)
    ]
    return replace(result, target=together(records))


def missed(result: FitResult) -> float:
    """Return the squared errors of a fit over the variances of its records."""
    found = result.target.misfits(result.law, result.solution.values)
    return sum(found["mse" + each.press] for each in presses(result.target))

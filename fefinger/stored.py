"""Which of the stored times is shown for the time that was asked for."""

from collections.abc import Sequence

from fefinger import indenter_pose, quantities
from fefinger.results.records import Result
from fefinger.support.checks import InputError, number


def check(name: str, results: Sequence[Result], time: float | None) -> None:
    """Raise InputError for a `time` in s before the runs, or more than a step after all of them.

    `name`: what the user gave it as; None is the time of the largest force.
    """
    if time is None:
        return
    number(name, time, at_least=0, unit="s")
    last = max(float(result.time[-1]) for result in results)
    step = max(float(result.time[-1] - result.time[-2]) for result in results)
    if time > last + step:
        message = (
            f"{name}: expected a time within the run, from 0 to {last:.4g} s, "
            f"received {time:.6g} s; leave it out for that of the largest force"
        )
        raise InputError(message)


def told(results: Sequence[Result], names: Sequence[str], time: float) -> list[str]:
    """Return a sentence for each result that is shown at another time than asked."""
    sentences = []
    for result, name in zip(results, names, strict=True):
        fields = quantities.fields_of(result)
        shown = float(fields.times[indenter_pose.nearest_frame(fields, time)])
        if abs(shown - time) > 1e-6 * float(fields.times[-1]):
            which = "last" if time > fields.times[-1] else f"nearest to {time:.6g} s"
            of = f"the {which} of its {len(fields.times)} stored times"
            sentences.append(f"{name}: shown at {shown:.6g} s, {of}")
    return sentences

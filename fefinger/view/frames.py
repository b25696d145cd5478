"""Which stored time of a result is shown, checks of the request, and fields of whole fingers."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fefinger.geometry.mirror import Halves
from fefinger.geometry.section import is_half
from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
from fefinger.support.checks import InputError, number
from fefinger.view import quantities


def requested(
    results: ResultRecord | Sequence[ResultRecord], field: str, time: float | None = None
) -> list[ResultRecord]:
    """Return one result or several as a list, if their `field` can be shown at a `time` in s.

    Raises InputError for a result without fields, an unknown field, or a time as in `check`.
    """
    every = [results] if isinstance(results, ResultRecord) else list(results)
    for result in every:
        quantities.fields_of(result)
    quantities.named("field", field)
    check("time", every, time)
    return every


def check(name: str, results: Sequence[ResultRecord], time: float | None) -> None:
    """Raise InputError for a `time` in s before the runs, or more than a step after all of them.

    Messages call the time `name`. None, the time of the peak, is always right.
    """
    if time is None:
        return
    number(name, time, at_least=0, unit="s")
    last = max(float(result.time[-1]) for result in results)
    step = max(float(result.time[-1] - result.time[-2]) for result in results)
    if time > last + step:
        raise InputError(
            f"{name}: expected a time within the run, from 0 to {last:.4g} s, "
            f"received {time:.6g} s; leave it out for the time of {results[0].peak_name}"
        )


def deviations(results: Sequence[ResultRecord], names: Sequence[str], time: float) -> list[str]:
    """Return a sentence for each result whose nearest stored time differs from `time`."""
    sentences = []
    for result, name in zip(results, names, strict=True):
        fields = quantities.fields_of(result)
        shown = float(fields.times[nearest_frame(fields, time)])
        if abs(shown - time) > 1e-6 * float(fields.times[-1]):
            which = "last" if time > fields.times[-1] else f"nearest to {time:.6g} s"
            of = f"the {which} of its {len(fields.times)} stored times"
            sentences.append(f"{name}: shown at {shown:.6g} s, {of}")
    return sentences


def nearest_frame(fields: Fields, time: float) -> int:
    """Return the index of the stored time next to `time` s."""
    return int(np.argmin(np.abs(fields.times - time)))


def peak_time(result: ResultRecord) -> float:
    """Return the time in s of the largest force, or of the largest depth under a given force."""
    return float(result.time[result.peak])


def whole(fields: Fields) -> Fields:
    """Return the fields of the whole finger, mirrored in the medial plane if they are half."""
    points = fields.points
    if not is_half(points):
        return fields
    halves = Halves.of(points, tolerance=1e-9 * float(np.ptp(points)))
    return replace(
        fields,
        points=halves.vectors(points),
        cells=halves.cells(fields.cells),
        region=np.concatenate([fields.region, fields.region]),
        displacement=halves.vectors(fields.displacement),
        strain=halves.voigt(fields.strain),
        pressure=halves.values(fields.pressure, axis=1),
        energy=None if fields.energy is None else halves.values(fields.energy, axis=1),
    )


def whole_result(result: ResultRecord) -> ResultRecord:
    """Return the result with its fields on the whole finger."""
    fields = whole(quantities.fields_of(result))
    return replace(result, response=replace(result.response, fields=fields))

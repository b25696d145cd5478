"""Cases of suite `finger` on what Hertz leaves out: a fresh report, and the sign of each cause."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from fefinger.validation.case import Case, Expected
from fefinger.validation.finger.split import (
    factors,
    force,
    row,
    steepness,
    subjects,
    together,
    unexplained,
)
from fefinger.validation.problems.chain import ASIDE, PRESSES, SUBJECTS, reaching, scene


SAME, FRESH = Expected(0.0, 1e-4), "recomputed: reports/solid-force.json is of this code"
NONE = Expected(0.0, 0.0)

SIGNS = {
    "bone": (1, "a rigid base under the layer stiffens it"),
    "layered": (1, "the skin is stiffer than the mean of the compliances"),
    "shape": (-1, "the finger ends at its sides and tip"),
    "solid": (1, "compressed tissue stiffens more than the contact loses"),
}
"""Which way each cause goes under a plate at a tenth of the thickness, and why."""

Model = tuple[str, ...]

ORDERED: dict[str, tuple[Model, Model, str]] = {
    "finite strain does not raise m": (("linear",), ("solid",), "geometric stiffening"),
    "m of the flat stack is not above that of the finger": (
        ("linear",),
        ("layered",),
        "the finger ends at its sides and tip",
    ),
    "Demiray's tissue does not raise m above neo-Hookean tissue": (
        ("solid",),
        ("solid", "demiray"),
        "tissue that itself stiffens",
    ),
}
"""Models, with presses, the second of which has the larger m on every subject, and why."""


def stale(model: str, subject: str, press: str) -> float:
    """Return the largest relative change of a curve of the report when it is computed again."""
    _, again, _ = reaching(model, scene(subject, press))
    stored = force(subject, press, model)
    return float(np.nanmax(np.abs(again / stored - 1)))


def stale_coarse(model: str, subject: str) -> float:
    """Return the same on the coarse mesh, under the plate."""
    stored = row(subject, "flat-30")["coarse"]
    _, again, _ = reaching(model, scene(subject, "flat-30", "coarse"))
    return float(np.abs(again / np.array(stored[model]) - 1).max())


def against(cause: str, sign: int) -> int:
    """Return for how many subjects a cause under the plate does not go the way of `sign`."""
    ratios = [
        together(subject) if cause == "shape" else factors(subject, "flat-30")[cause]
        for subject in SUBJECTS
    ]
    return int(sum(not sign * np.log(value) > 0 for value in ratios))


def not_above(model: Model, other: Model) -> int:
    """Return for how many subjects m of a model is no larger than m of the other."""
    return sum(steepness(s, *model) <= steepness(s, *other) for s in SUBJECTS)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield freshness, the signs of the causes, mesh error and what one G leaves unexplained."""
    for model in ("hertz", "bone", "layered"):
        yield Case(
            f"{model}: report against recomputation, all subjects and presses",
            partial(lambda m: max(stale(m, s, p) for p in PRESSES for s in subjects(p)), model),
            SAME,
            FRESH,
        )
    title = "linear, coarse: the same under the plate on a.h."
    yield Case(title, lambda: stale_coarse("linear", SUBJECTS[0]), SAME, FRESH)
    if not quick:
        title = "solid, coarse: the same under the plate, all subjects"
        yield Case(
            title, lambda: max(stale_coarse("solid", subject) for subject in SUBJECTS), SAME, FRESH
        )
        for model in ("linear", *ASIDE):
            name = f"{model}: the same on the standard mesh, a.h. under the plate"
            yield Case(name, partial(stale, model, SUBJECTS[0], "flat-30"), SAME, FRESH)
    for cause, (sign, why) in SIGNS.items():
        name = f"subjects on whom the cause {cause!r} {'stiffens' if sign > 0 else 'softens'} not"
        yield Case(name, partial(against, cause, sign), NONE, why)
    for name, (low, high, why) in ORDERED.items():
        yield Case(f"subjects on whom {name}", partial(not_above, high, low), NONE, why)
    title = "force of linear with relaxation over the integral of G"
    measure = partial(unexplained, "a.h.", "flat-30", "linear")
    yield Case(title, measure, Expected(1.0, 5e-3), "one G in a linear body: separable")
    for press in PRESSES:
        error = row("a.h.", press)["mesh_error"]
        if error is not None:
            title = f"solid, {press}: force on the standard mesh against the extrapolated one"
            measure = partial(lambda e: e["standard"], error)
            yield Case(title, measure, Expected(0.0, 0.02), "order 2 in the cell length")

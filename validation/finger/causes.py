"""Cases of suite `finger` on what Hertz leaves out: a fresh report, and the sign of each cause."""

from collections.abc import Iterator

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


FRESH = "recomputed: reports/solid-force.json is of this code"

SIGNS = {
    "bone": (1, "a rigid base under the layer stiffens it"),
    "layered": (1, "the skin is stiffer than the mean of the compliances"),
    "shape": (-1, "the finger ends at its sides and tip"),
    "solid": (1, "compressed tissue stiffens more than the contact loses"),
}
"""Which way each cause goes under a plate at a tenth of the thickness, and why."""


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


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield freshness, the signs of the causes, mesh error and what one G leaves unexplained."""
    for model in ("hertz", "bone", "layered"):
        yield Case(
            f"{model}: report against recomputation, all subjects and presses",
            lambda m=model: max(stale(m, s, p) for p in PRESSES for s in subjects(p)),
            Expected(0.0, 1e-4, "1"),
            FRESH,
        )
    first = SUBJECTS[0]
    yield Case(
        "linear, coarse: the same under the plate on a.h.",
        lambda: stale_coarse("linear", first),
        Expected(0.0, 1e-4, "1"),
        FRESH,
    )
    if not quick:
        yield Case(
            "solid, coarse: the same under the plate, all subjects",
            lambda: max(stale_coarse("solid", subject) for subject in SUBJECTS),
            Expected(0.0, 1e-4, "1"),
            FRESH,
        )
        for model in ("linear", *ASIDE):
            yield Case(
                f"{model}: the same on the standard mesh, a.h. under the plate",
                lambda m=model: stale(m, SUBJECTS[0], "flat-30"),
                Expected(0.0, 1e-4, "1"),
                FRESH,
            )
    for cause, (sign, why) in SIGNS.items():
        way = "stiffens" if sign > 0 else "softens"
        yield Case(
            f"subjects on whom the cause {cause!r} {way} not",
            lambda c=cause, s=sign: against(c, s),
            Expected(0.0, 0.0, "1"),
            why,
        )
    yield Case(
        "subjects on whom finite strain does not raise m",
        lambda: sum(steepness(s, "solid") <= steepness(s, "linear") for s in SUBJECTS),
        Expected(0.0, 0.0, "1"),
        "geometric stiffening",
    )
    yield Case(
        "subjects on whom m of the flat stack is not above that of the finger",
        lambda: sum(steepness(s, "layered") <= steepness(s, "linear") for s in SUBJECTS),
        Expected(0.0, 0.0, "1"),
        "the finger ends at its sides and tip",
    )
    yield Case(
        "subjects on whom Demiray's tissue does not raise m above neo-Hookean tissue",
        lambda: sum(steepness(s, "solid", "demiray") <= steepness(s, "solid") for s in SUBJECTS),
        Expected(0.0, 0.0, "1"),
        "tissue that itself stiffens",
    )
    yield Case(
        "force of linear with relaxation over the integral of G",
        lambda: unexplained("a.h.", "flat-30", "linear"),
        Expected(1.0, 5e-3, "1"),
        "one G in a linear body: separable",
    )
    for press in PRESSES:
        error = row("a.h.", press)["mesh_error"]
        if error is not None:
            yield Case(
                f"solid, {press}: force on the standard mesh against the extrapolated one",
                lambda e=error: e["standard"],
                Expected(0.0, 0.02, "1"),
                "order 2 in the cell length",
            )

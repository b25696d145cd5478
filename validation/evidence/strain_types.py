"""Measure errors of the strain at the end organ of each type, on the coarse mesh.

Run as `python -m fefinger.validation.evidence.strain_types reports`, some ten minutes. Mechanics of
small strain are compared with finite strain on the same mesh, in presses of `press_mesh.py` to at
most DEEPEST. The error of the mesh itself is known where the package holds the press on the
standard mesh too. Presses that are in the report already are not solved again.
"""

import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence.press_errors import Press, left_on, norm
from fefinger.validation.evidence.press_mesh import MEASUREMENTS, OTHER_SUBJECTS, Measurement
from fefinger.validation.provenance import save, saved, short
from numpy.typing import NDArray

from fefinger.mechanics import get
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.indenters import Flat
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.vocabulary import TYPES


REPORT = "strain-types.json"

DEEPEST = 0.15
"""Depth over the thickness to which the package holds presses on both meshes."""

COARSE, STANDARD = "pressed coarse", "pressed standard"

SMALL = ("hertz", "layered", "condensed coarse")
"""Candidates that are compared with finite strain on the coarse mesh."""

SHIPPED = ("flat-30", "sphere-5")
"""Objects whose presses into the fingers of subjects the package holds on both meshes."""

PUBLISHED_OBJECTS = (
    *("flat-30", "sphere-5", "flat-0", "flat-60", "sphere-2", "cylinder", "bar", "grating"),
    *("flat-15", "flat-45", "pin", "sphere-10", "flat-37", "bar-4", "grating-10"),
)

OWN_OBJECTS = (
    *("bar", "grating", "flat-60", "sphere-2", "cylinder", "flat-45", "flat-15", "flat-0"),
    "tilt-15",
)

OTHER_TISSUES: dict[str, tuple[str, float | None]] = {
    "saal2017": ("saal2017", None),
    "dandekar2003": ("dandekar2003", None),
    "soft skin": (library.PUBLISHED, 30.0),
}
"""Tissues by name: a published set, and the modulus of the skin in kPa where it is another. 30 kPa
is less than that of the tissue below, and a third of that of the set."""

OTHER_OBJECTS = (
    *("flat-30", "sphere-5", "flat-0", "flat-60"),
    *("sphere-10", "cylinder", "bar", "grating"),
)
"""Objects that were pressed into them."""

MEASURED: dict[str, Measurement] = {
    name: replace(MEASUREMENTS[name], part=min(MEASUREMENTS[name].part, DEEPEST))
    for name in (
        *(f"{subject}/{name}" for name in SHIPPED for subject in ("a.h.", *OTHER_SUBJECTS)),
        *(f"{library.PUBLISHED}/{name}" for name in PUBLISHED_OBJECTS),
        *(f"a.h./{name}" for name in OWN_OBJECTS),
    )
} | {
    f"{owner}/{name}": Measurement("a.h.", like.indenter, min(like.part, DEEPEST), *tissue)
    for owner, tissue in OTHER_TISSUES.items()
    for name in OTHER_OBJECTS
    for like in [MEASUREMENTS[f"{library.PUBLISHED}/{name}"]]
}
MEASURED[f"{library.PUBLISHED}/tilt-15"] = Measurement(
    "a.h.", Flat(30, tilt=15.0), DEEPEST, library.PUBLISHED
)


def presses(name: str) -> dict[str, Press]:
    """Return the press by every candidate that is able to answer it."""
    subject, _, object_ = name.partition("/")
    both = object_ in SHIPPED and subject not in (library.PUBLISHED, *OTHER_TISSUES)
    found = {}
    for label in (COARSE, *((STANDARD,) if both else ()), *SMALL):
        candidate = Candidate.of(label)
        scene, mechanics = MEASURED[name].scene(candidate.resolution), get(candidate.mechanics)
        if any(each.about == "ability" for each in mechanics.refuse(Situation.of(scene))):
            continue
        try:
            found[label] = Press.of(mechanics.respond(scene))
        except (InputError, ConvergenceError) as error:
            print(name, label, error, flush=True)  # progress
    return found


def judge(name: str, found: Mapping[str, Press]) -> dict[str, Any]:
    """Return the errors of force and of the strain of each type, by candidate and depth.

    Those of `solid` are errors of the mesh: what is left of the difference of two of them.
    """
    measurement = MEASURED[name]
    true, thickness = found[COARSE], measurement.finger.thickness
    errors = {label: _apart(found[label], true) for label in SMALL if label in found}
    if STANDARD in found:
        between, left = _apart(true, found[STANDARD]), left_on("coarse", "standard")
        errors["solid coarse"] = {what: (1 + left) * each for what, each in between.items()}
        errors["solid standard"] = {what: left * each for what, each in between.items()}
    return {
        "tissue": measurement.tissue or "",
        "part": short(true.depth[true.at] / thickness),
        "force_N": short(true.force[true.at]),
        "errors": {
            label: {what: short(each, 3) for what, each in row.items()}
            for label, row in errors.items()
        },
    }


def _apart(press: Press, true: Press) -> dict[str, NDArray[np.float64]]:
    """Return the errors (n,) of each quantity at the depths at which a press is judged.

    Of the strain of each type, and of all together; of the force the largest so far.
    """
    at = true.at
    force = np.maximum.accumulate(np.abs(press.force - true.force))[at] / true.force[at]
    errors = {"force": force}
    for what in ("pressure", "area"):
        real = getattr(true, what)[at]
        errors[what] = np.abs(getattr(press, what)[at] - real) / real
    errors["strain"] = norm(press.strain[at] - true.strain[at]) / norm(true.strain[at])
    for site, kind in enumerate(TYPES):
        real = true.strain[at, site]
        errors[f"strain {kind}"] = norm(press.strain[at, site] - real) / norm(real)
    return errors


def main(folder: Path) -> None:
    """Measure what is missing and write the report after every press."""
    path = folder / REPORT
    rows = saved(path).get("rows", {})
    for name in MEASURED:
        if name not in rows:
            rows[name] = judge(name, presses(name))
            save(path, {"rows": rows})
            print(name, flush=True)  # progress


if __name__ == "__main__":
    main(Path(sys.argv[1]))

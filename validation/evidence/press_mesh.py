"""Measure errors under many objects: of the mesh at finite strain, and of all that is cheaper.

Run as `python -m fefinger.validation.evidence.press_mesh reports`; about half an hour on one core.
Presses that are in the report already, of the same description, are not solved again.

Each press is the elastic one that `pressed` and `solid` share: a ramp of relaxed tissue. The coarse
and the standard mesh are compared; the error of the standard one is what is left of their
difference if errors are of order 2 in the size of the cells, and that of the fine one follows from
its size. On published tissue, `tradeoff.json` has the smooth plates up to
30 degrees and the balls in the middle of the pad; under the other objects, and on the calibrated
fingers under all of them, every mechanics is compared with finite strain on the finest mesh here.
"""

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.evidence.linear import ORDER
from fefinger.validation.provenance import provenance
from fefinger.validation.tradeoff.errors import Press, errors, left
from numpy.typing import NDArray

from fefinger.mechanics import get
from fefinger.mechanics.evidence import lumped_law
from fefinger.mechanics.evidence.table import PRESS_MESH
from fefinger.mechanics.evidence.tradeoff import STATED
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene import library
from fefinger.scene.ask import Ask
from fefinger.scene.finger import STANDARD, Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Bar, Cylinder, Flat, Pin, Sphere
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.scene.textured import Grating
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.theory.relaxation import Prony


MEAN_SIZE = (14.25, 11.0)
"""Width and thickness in mm of the finger of mean size: means of the four subjects."""


@dataclass(frozen=True)
class Measurement:
    """A press: subject whose finger is pressed, object, and depth over the thickness.

    The tissue is that calibrated on the subject, or a published one; MEANS is a finger of mean
    size, with the tissue that is calibrated on the means.
    """

    subject: str
    indenter: Indenter
    part: float
    tissue: str | None = None

    @property
    def finger(self) -> Finger:
        """The finger that is pressed, with its own relaxation."""
        if self.subject == library.MEANS:
            return Finger(*MEAN_SIZE)
        return Finger.subject(self.subject, tissue=self.tissue)

    def scene(self, resolution: str | None) -> Scene:
        """Return the ramp of relaxed tissue on a mesh."""
        finger = replace(self.finger, resolution=resolution or STANDARD)
        depth = self.part * finger.thickness
        return Scene(
            finger=replace(finger, prony=Prony((1.0,), ())),
            indenter=self.indenter,
            motion=Ramp(60.0, depth, corner=0.0),
            ask=Ask(pressure=True, strain=True, fields=False),
        )


OBJECTS: dict[str, tuple[Indenter, float]] = {
    "flat-30": (Flat(30), 0.2),
    "flat-0": (Flat(0), 0.2),
    "flat-60": (Flat(60), 0.2),
    "sphere-5": (Sphere(5), 0.2),
    "grating": (Grating(period=4.0, ridge=2.0, depth=0.6), 0.15),
    "bar": (Bar(width=2.0, corner=1.0), 0.12),
    "cylinder": (Cylinder(5.0, roll=90.0), 0.15),
    "flat-15": (Flat(15), 0.2),
    "flat-45": (Flat(45), 0.17),
    "sphere-10": (Sphere(10), 0.2),
    "sphere-2": (Sphere(2), 0.08),
    "sphere-1": (Sphere(1), 0.25),
    "pin": (Pin(width=2.0), 0.08),
    "grating-10": (Grating(period=4.0, ridge=2.0, depth=0.6, angle=10.0), 0.15),
    "tilt-15": (Flat(30, tilt=15.0), 0.15),
    "sphere-5, 4 mm beside": (Sphere(5, at=(0.0, 4.0)), 0.12),
    "grating-6": (Grating(period=6.0, ridge=3.0, depth=0.8), 0.15),
    "bar-4": (Bar(width=4.0, corner=2.0), 0.12),
}
"""Objects pressed into the finger of a.h., and how deep; the ones that more depends on first."""

SHARED = ("flat-60", "flat-45", "sphere-10", "bar", "flat-0", "grating", "cylinder", "sphere-2")
"""Objects that the other calibrated fingers are pressed by, beside the plate and ball of each."""

OTHER_SUBJECTS = ("d.s.", "d.p.", "p.w.")

OTHERS = ("grating", "bar", "cylinder", "flat-60", "flat-45", "pin", "grating-6", "bar-4")
"""Objects that `tradeoff.json` does not have: all mechanics press them into published tissue."""

MEASUREMENTS = {
    **{f"a.h./{name}": Measurement("a.h.", *each) for name, each in OBJECTS.items()},
    **{
        f"{library.PUBLISHED}/{name}": Measurement("a.h.", *OBJECTS[name], library.PUBLISHED)
        for name in OTHERS
    },
    **{
        f"{subject}/{name}": Measurement(subject, *OBJECTS[name])
        for name in ("flat-30", "sphere-5")
        for subject in (*OTHER_SUBJECTS, library.MEANS)
    },
    **{
        f"{subject}/{name}": Measurement(subject, *OBJECTS[name])
        for name in SHARED
        for subject in OTHER_SUBJECTS
    },
}

CHEAPER = (
    *("hertz", "layered", "condensed coarse", "condensed standard"),
    *("linear coarse", "linear standard"),
)
"""Candidates that are compared with finite strain."""

MESHES = ("coarse", "standard")

FINE = (40926 / 99374) ** (ORDER / 3)
"""Error on the fine mesh over that on the standard one, by their unknowns."""


def row(measurement: Measurement) -> dict[str, Any]:
    """Return force and errors over the depth, by mesh; or the sentence of a refusal."""
    record = _described(measurement)
    presses: dict[str, Press] = {}
    unknowns: dict[str, float] = {}
    for mesh in MESHES:
        try:
            response = get("pressed").respond(measurement.scene(mesh))
        except (InputError, ConvergenceError) as error:
            return record | {"refused": f"{mesh}: {error}"}
        presses[mesh], unknowns[mesh] = Press.of(response), response.numbers["unknowns"]
    true = presses["standard"]
    size = left([unknowns[mesh] for mesh in MESHES])
    remaining = {name: size * each for name, each in errors(presses["coarse"], true).items()}
    fine = {name: FINE * each for name, each in remaining.items()}
    found = {"solid fine": fine, "solid standard": remaining}
    others = {"solid coarse": presses["coarse"]} | _cheaper(measurement)
    for label, each in others.items():
        apart = errors(each, true)
        found[label] = {name: apart[name] + remaining[name] for name in STATED}
    rows = {label: {name: _short(each[name]) for name in STATED} for label, each in found.items()}
    if measurement.tissue is None:
        apart = _lumped(measurement, true) + remaining["force"]
        rows["lumped"] = {"force": _short(apart)}
    return record | {
        "unknowns": unknowns,
        "depth_mm": _short(true.depth[true.at]),
        "force_N": _short(true.force[true.at]),
        "area_mm2": _short(true.area[true.at]),
        "errors": rows,
    }


def _lumped(measurement: Measurement, true: Press) -> NDArray[np.float64]:
    """Return the errors (n,) of the relaxed force by the law of a calibrated finger."""
    law = lumped_law.law(Situation.of(replace(measurement.scene(None), finger=measurement.finger)))
    force = law.prony.long_time * np.array([law.spring.force(depth) for depth in true.depth])
    return errors(replace(true, force=force), true)["force"]


def _cheaper(measurement: Measurement) -> dict[str, Press]:
    """Return the press by all candidates that are able to answer it."""
    found = {}
    for label in CHEAPER:
        candidate = Candidate.of(label)
        scene = measurement.scene(candidate.resolution)
        mechanics = get(candidate.mechanics)
        if any(each.about == "ability" for each in mechanics.refuse(Situation.of(scene))):
            continue
        try:
            found[label] = Press.of(mechanics.respond(scene))
        except (InputError, ConvergenceError) as error:
            print(label, error, flush=True)  # progress
    return found


def _described(measurement: Measurement) -> dict[str, Any]:
    scene = measurement.scene("standard").to_dict()
    return {
        "subject": measurement.subject,
        "indenter": scene["indenter"],
        "part": measurement.part,
        "tissue": measurement.tissue,
        "thickness_mm": measurement.finger.thickness,
        "subcutaneous_kPa": measurement.finger.subcutaneous.modulus,
    }


def _short(values: Any) -> list[float]:
    return [float(f"{value:.4g}") for value in values]


def main(folder: Path) -> None:
    """Measure what is missing, and write the report after every press."""
    path = folder / PRESS_MESH
    rows = json.loads(path.read_text(encoding="utf-8"))["rows"] if path.exists() else {}
    for name, measurement in MEASUREMENTS.items():
        described = json.loads(json.dumps(_described(measurement)))
        if name in rows and described.items() <= rows[name].items():
            continue
        rows[name] = row(measurement)
        command = "python -m fefinger.validation.evidence.press_mesh reports"
        kept = {key: rows[key] for key in MEASUREMENTS if key in rows}
        record = provenance(command) | {"rows": kept}
        path.write_text(json.dumps(record, separators=(",", ":")) + "\n")
        print(name, np.round(rows[name].get("force_N", [0])[-1], 3), flush=True)  # progress


if __name__ == "__main__":
    main(Path(sys.argv[1]))

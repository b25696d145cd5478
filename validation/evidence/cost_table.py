"""Coefficients of cost: seconds of each stage as timed, and a regression of finite strain.

The logarithm of the CPU seconds of a step of `solid` is fitted, by least squares, by one level per
mesh, the relative depth, sharpness of the object, and whether the tissue stiffens; its growth with
the unknowns from the coarse to the standard mesh gives that to the fine mesh, and to a whole
finger. All is at the speed of the machine of the reports.
"""

from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import saved

from fefinger.mechanics.evidence.vibration import REPORT as MODAL
from fefinger.scene.indenters import INDENTERS
from fefinger.support.machine import REPORTED


SMALL_STRAIN, SOLID, TABULATION = "small-strain-cost.json", "solid-cost.json", "pressed-error.json"

LAW = "neo-hookean"
"""Law of tissue that does not stiffen."""

TIMED_PART, TIMED_SIZE = 0.16, 140.0
"""Depth over the thickness of the press of `pressed` that was timed, and width times thickness in
mm² of the finger."""

BY_HAND = {
    "lumped": {"setup": 0.0, "step": 1.2e-5},
    "hertz": {"setup": 0.0213, "step": 2.3e-5},
    "mesh coarse": {"morph": 0.7, "mesh": 8.0},
    "mesh standard": {"morph": 1.2, "mesh": 20.0},
    "mesh fine": {"morph": 1.5, "mesh": 50.0},
    "scan": {"setup": 3.5, "megabyte": 1.0},
}
"""CPU seconds on the machine of the reports that no report holds: formulas, in the scenes of
development; morphing a shipped mesh to half a finger; meshing it anew, once where the first attempt
passes, up to four times that (the fine one in proportion to its unknowns); the shape of a surface
file, of few triangles and of many."""

TIMED = {"sliding": 20.0, "gripping": 10.0, "shallow": 0.25, "shared": 0.64}
"""Ratios that no report holds.

sliding: time of a step along a path over one of a press, 15 to 25 over dots, letters and gratings.
gripping: time of a step with friction over one without, in the cases of the bench `sliding`.
shallow: time of a press to first touch over one to the depth that was timed; to 0.02, 0.04, 0.08
and 0.12 of the thickness 0.3, 0.45, 0.65 and 0.85 under two balls, a bar and a cylinder on the
coarse mesh, 0.36 and 0.7 to 0.02 and 0.08 under a ball on the standard one. Deeper presses cost as
the square of the depth: 79 and 33 s at 0.28 under the plate at 30 degrees and the ball of 5 mm.
shared: share of the CPU seconds of finite strain that threads divide among them; `flat-press` on
the standard mesh took 20.8 CPU s in two threads, of which the first took 14.2."""


def coefficients(folder: Path) -> dict[str, Any]:
    """Return the coefficients of cost."""
    small, solid, tabulated, modal = (
        saved(folder / name) for name in (SMALL_STRAIN, SOLID, TABULATION, MODAL)
    )
    table = {label: _stages(row, small) for label, row in small["rows"].items()}
    unknowns = {mesh: small["rows"][f"linear {mesh}"]["unknowns"] for mesh in MESHES}
    fit, grows = _regression(solid["rows"])
    levels = {
        mesh: {
            "setup": _median(solid["rows"], mesh, "setup_seconds"),
            "reference": _median(solid["rows"], mesh, "reference_seconds"),
            "step": fit[mesh],
        }
        for mesh in MESHES[:2]
    }
    table |= {f"solid {mesh}": _scaled(row, solid) for mesh, row in levels.items()}
    table |= {
        f"pressed {mesh}": _stages(row, tabulated) for mesh, row in tabulated["costs"].items()
    }
    table |= {f"modal {mesh}": _scaled(row, modal) for mesh, row in modal["seconds"].items()}
    size = np.diff(np.log([unknowns[mesh] for mesh in MESHES]))
    power = np.log(fit["standard"] / fit["coarse"]) / size[0]
    for name in ("solid", "pressed", "modal"):
        coarse, standard = (table[f"{name} {mesh}"] for mesh in MESHES[:2])
        table[f"{name} fine"] = {
            stage: value * (value / coarse[stage]) ** (size[1] / size[0])
            for stage, value in standard.items()
        }
    table |= BY_HAND
    rounded = {
        label: {stage: float(f"{value:.4g}") for stage, value in row.items()}
        for label, row in table.items()
    }
    record = {"seconds": rounded, "timed": TIMED_PART, "size": TIMED_SIZE}
    return record | {"power": round(float(power), 3)} | grows | TIMED


MESHES = ("coarse", "standard", "fine")


def _regression(rows: list[dict[str, Any]]) -> tuple[dict[str, float], dict[str, float]]:
    """Return the seconds of a step at first touch by mesh, and what its logarithm grows by."""
    part = np.array([row["depth_mm"] / row["thickness_mm"] for row in rows])
    basis = [
        *(np.array([row["mesh"] == mesh for row in rows], dtype=float) for mesh in MESHES[:2]),
        part,
        np.array([INDENTERS[row["kind"]].sharp for row in rows], dtype=float),
        np.array([row["law"] != LAW for row in rows], dtype=float),
    ]
    steps = np.log([row["step_seconds"] for row in rows])
    solution = np.linalg.lstsq(np.array(basis).T, steps, rcond=None)[0]
    levels = dict(zip(MESHES, np.exp(solution[:2]).tolist(), strict=False))
    names = "growth", "sharp", "stiffening"
    grows = {name: round(float(x), 4) for name, x in zip(names, solution[2:], strict=True)}
    return levels, grows | {"deepest": float(part.max())}


def _median(rows: list[dict[str, Any]], mesh: str, stage: str) -> float:
    return float(np.median([row[stage] for row in rows if row["mesh"] == mesh]))


def _stages(row: dict[str, Any], report: dict[str, Any]) -> dict[str, float]:
    """Return the seconds of the stages of a row, on the machine of the reports."""
    stages = {key.removesuffix("_seconds"): row[key] for key in row if key.endswith("_seconds")}
    return _scaled(stages, report)


def _scaled(row: dict[str, float], report: dict[str, Any]) -> dict[str, float]:
    faster = REPORTED / report["machine_seconds"]
    return {stage: value * faster for stage, value in row.items() if stage != "complete_hz"}

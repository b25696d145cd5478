"""Coefficients of cost: seconds of each stage as timed, and a regression of finite strain.

The logarithm of the CPU seconds of a step of `solid` is fitted, by least squares, by one level per
mesh, the relative depth, sharpness of the object, and whether the tissue stiffens; its growth with
the unknowns from the coarse to the standard mesh gives that to the fine mesh, and to a whole
finger. What end organs, spikes and fields add is fitted to whole answers by least squares of the
relative errors, with coefficients of 0 or more. All is at the speed of the machine of the reports.
"""

from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import saved
from numpy.typing import NDArray
from scipy.optimize import nnls

from fefinger.mechanics.evidence.vibration import REPORT as MODAL
from fefinger.scene.indenters import INDENTERS
from fefinger.support.machine import REPORTED


SMALL_STRAIN, SOLID, TABULATION = "small-strain-cost.json", "solid-cost.json", "pressed-error.json"
AFFERENTS, GRID = "afferent-cost.json", "grid-cost.json"

LAW = "neo-hookean"
"""Law of tissue that does not stiffen."""

TIMED_PART, TIMED_SIZE = 0.16, 140.0
"""Depth over the thickness of the press of `pressed` that was timed, and width times thickness in
mm² of the finger."""

BY_HAND = {
    "lumped": {"setup": 0.0, "step": 1.2e-5},
    "mesh coarse": {"morph": 0.7, "mesh": 8.0},
    "mesh standard": {"morph": 1.2, "mesh": 20.0},
    "mesh fine": {"morph": 1.5, "mesh": 50.0},
    "scan": {"setup": 3.5, "megabyte": 1.0},
    "spikes thesis": {"setup": 0.0201, "block_second": 0.0156, "sample": 2.33e-6},
}
"""CPU seconds on the machine of the reports that no report holds: formulas, in the scenes of
development; morphing a shipped mesh to half a finger; meshing it anew, once where the first attempt
passes, up to four times that (the fine one in proportion to its unknowns); the shape of a surface
file, of few triangles and of many; spikes of the thesis, timed in holds of ten seconds too: those
of a hold of two minutes took what is expected."""

TIMED = {
    "sliding": 20.0,
    "gripping": 10.0,
    "forced": 12.0,
    "sought": {"hertz": 3.7, "layered": 3.9, "pressed": 4.2},
    "shallow": 0.25,
    "shared": 0.64,
}
"""Ratios that no report holds.

sliding: time of a step along a path over one of a press, 15 to 25 over dots, letters and gratings.
gripping: time of a step with friction over one without, in the cases of the bench `sliding`.
forced: the same of a press under a prescribed force over one to a depth, as contact creeps at all
times: 12 under a plate with a coefficient of 1.5, and under letters, which are solved on a whole
finger and took 4 times as long (coarse mesh, 0.5 N held for 30 s).
sought: time of a step under a prescribed force, whose depth is sought, over one at a depth: under a
ball, in 20,000 steps of a sine; 1 of others.
shallow: time of a press to first touch over one to the depth that was timed; to 0.02, 0.04, 0.08
and 0.12 of the thickness 0.3, 0.45, 0.65 and 0.85 under two balls, a bar and a cylinder on the
coarse mesh, 0.36 and 0.7 to 0.02 and 0.08 under a ball on the standard one. Deeper presses cost as
the square of the depth: 79 and 33 s at 0.28 under the plate at 30 degrees and the ball of 5 mm.
shared: share of the CPU seconds of finite strain that threads divide among them; `flat-press` on
the standard mesh took 20.8 CPU s in two threads, of which the first took 14.2."""


SLIP = {"coarse": 0.9, "standard": 33.0, "fine": 220.0}
"""CPU seconds of contact in a press of half a finger to 0.15 of its thickness in which skin slips.

Under a plate with a coefficient of 0.2 on a.h., 98 steps; they grow as the square of the depth: to
0.05 on the standard mesh 2.5, to 0.3 on the coarse one 2.3. The vertices that begin to slip count,
not the steps: a press to 0.3 in 3086 steps took 41 s on the standard mesh. On the fine mesh
extrapolated as the 2.9th power of the number of vertices in contact."""


def coefficients(folder: Path) -> dict[str, Any]:
    """Return the coefficients of cost."""
    small, solid, tabulated, modal, timed = (
        saved(folder / name) for name in (SMALL_STRAIN, SOLID, TABULATION, MODAL, AFFERENTS)
    )
    table = {
        label: {
            stage: x for stage, x in _stages(row, small).items() if stage not in AREA_AND_ORGANS
        }
        for label, row in small["rows"].items()
    }
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
    answers, spikes = _answers(timed), _spikes(timed)
    table |= {label: row for label, row in answers.items() if label in FORMULAS}
    for mesh, row in tabulated["costs"].items():
        built = _stages(row, tabulated)["build"]
        table[f"pressed {mesh}"] = {"build": built, **answers[f"pressed {mesh}"]}
    for name, (like, stages) in GROWTH.items():
        for mesh in MESHES[:2]:
            table[f"{name} {mesh}"] |= {
                stage: answers[f"{name} coarse"][stage] * _ratio(answers, like, mesh, stage)
                for stage in stages
            }
    table |= {f"modal {mesh}": _scaled(row, modal) for mesh, row in modal["seconds"].items()}
    size = np.diff(np.log([unknowns[mesh] for mesh in MESHES]))
    power = np.log(fit["standard"] / fit["coarse"]) / size[0]
    for name in ("condensed", "linear", "solid", "pressed", "modal"):
        coarse, standard = (table[f"{name} {mesh}"] for mesh in MESHES[:2])
        fine = {
            stage: value * (value / coarse[stage] if coarse[stage] else 1.0) ** (size[1] / size[0])
            for stage, value in standard.items()
        }
        table[f"{name} fine"] = fine | table.get(f"{name} fine", {})
    table |= spikes | BY_HAND | {ON_GRID: _on_grid(saved(folder / GRID))}
    rounded = {
        label: {stage: float(f"{value:.4g}") for stage, value in row.items()}
        for label, row in table.items()
    }
    record = {"seconds": rounded, "timed": TIMED_PART, "size": TIMED_SIZE}
    return record | {"power": round(float(power), 3), "slip": SLIP} | grows | TIMED


MESHES = ("coarse", "standard", "fine")

ON_GRID = "layered on a grid"
"""Name of the stages of `layered` on a grid."""

FORMULAS = ("hertz", "layered")
"""Mechanics without a mesh whose cost is all of one fit."""

SMALL = ("condensed", "linear")
"""Mechanics that read the area of contact anew where it changes."""

ORGANS = ("organ", "organ_step")
"""Stages of an end organ of a population, and of one at a time step."""

AREA_AND_ORGANS = ("area", *ORGANS)
"""The same, and reading the area of contact once."""

GROWTH = {
    "condensed": ("condensed", AREA_AND_ORGANS),
    "linear": ("condensed", AREA_AND_ORGANS),
    "solid": ("pressed", ORGANS),
}
"""Stages of a mechanics that are taken of whole answers on the coarse mesh, and the mechanics with
whose times they grow to the standard one."""


def _answers(report: dict[str, Any]) -> dict[str, dict[str, float]]:
    """Return the seconds of the stages of whole answers, by candidate."""
    table: dict[str, dict[str, float]] = {}
    for label in dict.fromkeys(row["candidate"] for row in report["rows"]):
        rows = [row for row in report["rows"] if row["candidate"] == label]
        steps, fields = (_column(rows, key) for key in ("steps", "fields"))
        organs = _column(rows, "organs") * _column(rows, "population")
        loads = _column(rows, "load_steps")
        stages = {
            "setup": np.ones(len(rows)),
            "step": loads if loads.any() else steps,
            "organ": organs,
            "organ_step": organs * steps,
        }
        stages |= {"fields": fields} if fields.any() else {}
        stages |= {"area": _column(rows, "areas")} if label.split()[0] in SMALL else {}
        fit = _scaled(_fitted(stages, _column(rows, "seconds")), report)
        coarse = table.get(label.replace("standard", "coarse"), {})
        # What a coarser mesh takes longer for is noise.
        table[label] = {stage: max(value, coarse.get(stage, 0.0)) for stage, value in fit.items()}
    return table


def _ratio(answers: dict[str, dict[str, float]], mechanics: str, mesh: str, stage: str) -> float:
    """Return the seconds of a stage on a mesh over those on the coarse one."""
    coarse, there = (answers[f"{mechanics} {each}"][stage] for each in ("coarse", mesh))
    return there / coarse if coarse else 1.0


def _on_grid(report: dict[str, Any]) -> dict[str, float]:
    """Return the seconds of the stages of answers on a grid.

    point: of a grid point at a step; gripped: what friction adds to it; sample: of a component of
    strain at a time.
    """
    rows = list(report["rows"].values())
    points = _column(rows, "points") * _column(rows, "steps")
    stages = {
        "setup": np.ones(len(rows)),
        "point": points,
        "gripped": points * _column(rows, "friction"),
        "sample": _column(rows, "organs") * _column(rows, "times"),
    }
    return _scaled(_fitted(stages, _column(rows, "seconds")), report)


def _spikes(report: dict[str, Any]) -> dict[str, dict[str, float]]:
    """Return the seconds of the spikes of each family, by stage.

    block_second: of a block of units through a second; sample: of an end organ at a time step.
    """
    table = {}
    rows = [row for row in report["rows"] if row["spike_seconds"]]
    for family in dict.fromkeys(row["family"] for row in rows):
        own = [row for row in rows if row["family"] == family]
        stages = {
            "setup": np.ones(len(own)),
            "block_second": _column(own, "blocks") * _column(own, "duration_s"),
            "sample": _column(own, "organs") * _column(own, "steps"),
        }
        fit = _fitted(stages, _column(own, "spike_seconds"))
        table[f"spikes {family}"] = _scaled(fit, report)
    return table


def _column(rows: list[dict[str, Any]], key: str) -> NDArray[np.float64]:
    return np.array([row[key] for row in rows], dtype=float)


def _fitted(
    stages: dict[str, NDArray[np.float64]], seconds: NDArray[np.float64]
) -> dict[str, float]:
    """Return the coefficients of stages (n,), 0 or more, with the least relative errors."""
    basis = np.array(list(stages.values())).T / seconds[:, None]
    return dict(zip(stages, nnls(basis, np.ones(len(seconds)))[0].tolist(), strict=True))


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

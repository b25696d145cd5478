"""Uncertainty of the results on the contact angle, and a proposed experiment."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from fefinger.validation.contact_angle.rows import (
    ANGLE,
    MAIN,
    MEASURES,
    OTHER,
    SOLID,
    STANDARD,
    TISSUES,
    Rows,
    curve,
    percent,
)

from fefinger.pages import page
from fefinger.studies import figures
from fefinger.studies.page import part
from fefinger.theory.array.sensor import ArraySensor


def sure(rows: Rows) -> Iterator[dict[str, Any]]:
    """Give the tables of what the numbers at 1 mm depend on, per angle."""
    changed = {
        "standard mesh": STANDARD,
        "finite strain": SOLID,
        **{f"tissue {case}": case for case in TISSUES},
    }
    names = {MAIN["1 mm"]: "a.h.", **{case: name for name, case in changed.items()}}
    chosen = [
        {"case": names[row["case"]], ANGLE: row[ANGLE]} | {k: row.get(k) for k in MEASURES}
        for row in rows
        if row["case"] in names and row["at"] == "1 mm"
    ]
    yield part(
        "Sensitivity to mesh, tissue and strain, one change at a time",
        "At 1 mm, on the finger of a.h.; the first line is the coarse mesh at small strain. "
        f"{_summed(rows)}",
        picture=page.svg(figures.panels(chosen, ANGLE, ["case"], ["depth_mm"])),
    )
    for name in ("asymmetry", "force_N", "contact_area_mm2", "ellipticity"):
        base = curve(rows, MAIN["1 mm"], "1 mm", name)
        other = curve(rows, OTHER["1 mm"], "1 mm", name)
        relative = name in ("force_N", "contact_area_mm2")
        rows_of_table = []
        for angle, value in base.items():
            scale = 100 / value if relative else 1.0
            values = [curve(rows, case, "1 mm", name).get(angle) for case in changed.values()]
            changes = [_written(None if v is None else scale * (v - value), "+.3g") for v in values]
            rows_of_table.append(
                [f"{angle:g}", _written(value), *changes, _written(other.get(angle))]
            )
        unit = " in %" if relative else ""
        yield part(
            f"Sensitivity: {MEASURES[name]} at 1 mm",
            f"Differences{unit} from the coarse mesh of a.h. with the tissue of Maeno et al. "
            "(1998) at small strain, one change at a time; the finger of p.w. is another one.",
            table={"heading": ["angle", "a.h.", *changed, "p.w."], "rows": rows_of_table},
        )


def _summed(rows: Rows) -> str:
    """Describe the effect of mesh and finite strain on the numbers at 1 mm, in two sentences."""

    def changes(case: str, name: str, *, relative: bool) -> dict[float, float]:
        base, other = (curve(rows, each, "1 mm", name) for each in (MAIN["1 mm"], case))
        return {a: abs(other[a] - base[a]) / (base[a] if relative else 1) for a in other}

    def largest(case: str, name: str, *, relative: bool) -> float:
        return max(changes(case, name, relative=relative).values())

    wide = changes(STANDARD, "contact_area_mm2", relative=True)
    where = sorted(sorted(wide, key=wide.__getitem__)[-2:])

    asymmetry, force, area = (
        [largest(case, name, relative=name != "asymmetry") for case in (STANDARD, SOLID)]
        for name in ("asymmetry", "force_N", "contact_area_mm2")
    )
    return (
        f"The standard mesh changes the asymmetry by at most {asymmetry[0]:.3f}, the force by "
        f"{100 * force[0]:.1f} % and the area by {100 * area[0]:.0f} %, most at {where[0]:g} and "
        f"{where[1]:g} degrees. Finite strain changes the asymmetry by at most "
        f"{asymmetry[1]:.3f}, the force by {100 * force[1]:.0f} % and the area by "
        f"{100 * area[1]:.0f} %: the shape of the curves is kept, the force at a depth is too "
        "low at small strain."
    )


def _written(value: float | None, form: str = ".3g") -> str:
    return "" if value is None else format(value, form)


def experiment(rows: Rows) -> Iterator[str]:
    """Yield the measurements that would test the model, and the accuracy that they need."""
    asymmetry = curve(rows, MAIN["1 mm"], "1 mm", "asymmetry")
    angles = np.array(sorted(asymmetry))
    slopes = np.diff([asymmetry[angle] for angle in angles]) / np.diff(angles)
    steepest = int(np.argmax(np.abs(slopes)))
    yield (
        f"The asymmetry at angles that are held to about 1 degree: between {angles[steepest]:g} "
        f"and {angles[steepest + 1]:g} degrees it changes by {abs(slopes[steepest]):.3f} per "
        f"degree, so 5 degrees of scatter are {5 * abs(slopes[steepest]):.2f}. 20, 30, 35, 40 "
        "and 50 degrees tell most."
    )
    area = curve(rows, MAIN["1 mm"], "1 mm", "contact_area_mm2")[30.0]
    radius = np.sqrt(area / np.pi)
    yield (
        "First touch to 0.1 mm, for instance from the centroid followed down to the smallest "
        f"force: on a contact of {radius:.1f} mm radius (30 degrees, 1 mm) an error of s mm "
        f"changes the asymmetry by 1.5 s / a, {0.15 / radius:.3f} per 0.1 mm. Without it, tell "
        "the asymmetry of the reach of an isobar about the centroid."
    )
    sensor = ArraySensor()
    total = 1000.0 / sensor.pitch**2
    spread = sensor.noise * np.sqrt((sensor.positions[:, 0] ** 2).sum()) / total
    share = sensor.noise * sensor.elements / total
    yield (
        f"Pressure with an array will do: its noise of {sensor.noise:g} kPa is {spread:.2f} mm "
        f"of the centroid and {share:.3f} of the asymmetry in one frame at 1 N, and its blur "
        f"changes the centroid by {_blur(rows, 'shift_distal_mm', 0, 60):.2f} mm at most and the "
        f"asymmetry by {_blur(rows, 'asymmetry', 0, 45):.3f} up to 45 degrees; by "
        f"{_blur(rows, 'asymmetry', 50, 60):.3f} beyond, where the contact is small. It does not "
        "keep the highest pressure, the contact area and the ellipticity, which ask for optics or "
        "finer elements."
    )
    tissues = [curve(rows, case, "1 mm", "asymmetry")[40.0] for case in TISSUES]
    yield (
        f"The asymmetry at 40 degrees, as a test of the tissue: {percent(max(tissues))} with a "
        "stiff skin over soft pulp (Dandekar et al. 2003), "
        f"{percent(curve(rows, MAIN['1 mm'], '1 mm', 'asymmetry')[40.0])} with the layers of "
        f"Maeno et al. (1998), {percent(min(tissues))} with one tissue throughout (coarse "
        f"mesh). At 20 degrees the three agree within {100 * _spread(rows, 20.0):.0f} % of the "
        "force."
    )
    shape = max(_spread(rows, angle, "ellipticity") for angle in asymmetry)
    yield (
        f"The ellipticity, as a test of the shape: the three tissues differ in it by {shape:.2f} "
        "at most, at any angle, while it goes through 0 at 40 degrees."
    )
    yield (
        "The shape of the same finger, scanned: where the pad turns to the tip decides at which "
        "angle the asymmetry turns. In the model that is between slopes of 34 and 48 degrees by "
        "assumption."
    )
    yield (
        "Both a fixed depth and a fixed force, because they rank the angles differently, with "
        "the loading at one speed: the tissue relaxes."
    )


def _blur(rows: Rows, name: str, low: float, high: float) -> float:
    """Return the largest difference that the array makes to a measure at 1 mm, at those angles."""
    exact, read = (curve(rows, MAIN["1 mm"], "1 mm", each) for each in (name, f"sensor_{name}"))
    return max(abs(read[angle] - exact[angle]) for angle in read if low <= angle <= high)


def _spread(rows: Rows, angle: float, name: str = "asymmetry") -> float:
    """Return the range of a measure at 1 mm over the tissues, on the coarse mesh."""
    cases = (MAIN["1 mm"], *TISSUES)
    return float(np.ptp([curve(rows, case, "1 mm", name)[angle] for case in cases]))

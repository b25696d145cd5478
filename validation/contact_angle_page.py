"""The page on the contact angle: every number in its sentences is read from the rows."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from fefinger import page, study_figures
from fefinger.study_measures import READINGS
from fefinger.study_report import ARRAY, MEANING, part, table
from fefinger.theory.sensor import ArraySensor


Rows = Sequence[Mapping[str, Any]]

ANGLE = "indenter.angle_deg"
MAIN = {"1 mm": "a.h. to 1 mm", "1 N": "a.h. to 1 N"}
OTHER = {"1 mm": "p.w. to 1 mm", "1 N": "p.w. to 1 N"}
TISSUES = ("dandekar2003", "saal2017")
STANDARD, SOLID = "standard mesh", "finite strain"
HELD = {"a.h. held at 1 mm": "1 mm, 5 s", "a.h. held at 1 N": "1 N, 2 s"}

THESIS = (20.0, 40.0)
"""Degrees between which the fingers of the thesis were held (sections 2.2 and 3.2)."""

MEASURES = {
    "force_N": "force / N",
    "depth_mm": "depth / mm",
    "contact_area_mm2": "area / mm²",
    "shift_distal_mm": "shift / mm",
    "asymmetry": "asymmetry",
    "ellipticity": "ellipticity",
    "peak_pressure_kPa": "peak / kPa",
}


def curve(rows: Rows, case: str, at: str, column: str) -> dict[float, float]:
    """Return a measure of a case by angle."""
    return {
        row[ANGLE]: row[column]
        for row in rows
        if row["case"] == case and row["at"] == at and row.get(column) is not None
    }


def html(rows: Rows, provenance: Mapping[str, Any]) -> str:
    """Return the page."""
    return page.render(
        "study.html",
        data=("contact-angle.csv",),
        title="Contact angle, 0 to 60 degrees",
        answer=answer(rows),
        lines=(MEANING, ARRAY),
        parts=list(_parts(rows)),
        provenance=list(page.flat(provenance)),
    )


def answer(rows: Rows) -> str:
    """Return the finding in a few sentences."""
    found = curve(rows, MAIN["1 mm"], "1 mm", "asymmetry")
    force, area = (
        curve(rows, MAIN["1 mm"], "1 mm", name) for name in ("force_N", "contact_area_mm2")
    )
    inside = {angle: value for angle, value in found.items() if THESIS[0] <= angle <= THESIS[1]}
    high, low = max(inside, key=inside.__getitem__), min(inside, key=inside.__getitem__)
    stiff, soft = max(force, key=force.__getitem__), min(force, key=force.__getitem__)
    others = [curve(rows, case, "1 mm", "asymmetry")[low] for case in TISSUES]
    return (
        f"Pressed 1 mm, the model of subject a.h. bears {_percent(inside[high])} of its force "
        f"more distally than proximally of first touch at {high:g} degrees and "
        f"{_percent(inside[low])} at {low:g}: within the {THESIS[0]:g} to {THESIS[1]:g} degrees "
        "of the thesis's fingers it falls through zero. How far it falls is decided "
        f"by the tissue: with two other published tissues it is {_percent(max(others))} and "
        f"{_percent(min(others))} at {low:g} degrees. The force at 1 mm falls from "
        f"{force[stiff]:.2f} N at {stiff:g} degrees to {force[soft]:.2f} N at {soft:g}, the "
        f"contact area from {max(area.values()):.0f} to {min(area.values()):.0f} mm²."
    )


def _percent(value: float) -> str:
    return f"{100 * value:+.0f} %"


def _parts(rows: Rows) -> Iterator[dict[str, Any]]:
    """Give the sections."""
    yield part("What the model predicts", *_predicted(rows))
    for at, skip in (("1 mm", "depth_mm"), ("1 N", "force_N")):
        chosen = [
            {**row, "case": row["case"].partition(" to ")[0]}
            for row in rows
            if row["at"] == at and row["status"] == "done" and row["case"] in (MAIN[at], OTHER[at])
        ]
        how = {"1 mm": "a ramp at 60 mm/s", "1 N": "a ramp of the force at 40 N/s"}[at]
        said = f"On the loading, at {at}: {how}. Coarse mesh, tissue of Maeno et al. (1998)."
        picture = page.svg(study_figures.panels(chosen, ANGLE, ["case"], [skip]))
        yield part(
            f"At a fixed {'depth' if at == '1 mm' else 'force'}, {at}", said, picture=picture
        )
    felt = [
        row
        for row in rows
        if row["case"] == MAIN["1 N"] and row["at"] == "1 N" and row.get(READINGS)
    ]
    yield part(
        "What the array of the thesis would read at 1 N",
        "Isobars 4 kPa apart, by angle in degrees; the tip is up, the cross is first touch. "
        "Subject a.h., without noise; where an angle is missing, the coarse mesh is too coarse "
        "for the array.",
        picture=page.svg(study_figures.isobars(felt, ANGLE, READINGS)),
    )
    yield part("Against Figure 3-3 of the thesis", *_thesis(rows))
    yield from _sure(rows)
    yield from _spikes(rows)
    yield part("What an experiment should measure", bullets=list(_experiment(rows)))
    yield part("What the model leaves out here", bullets=list(_limits(rows)))
    columns = [ANGLE, *MEASURES, "reach_distal_mm", "reach_proximal_mm", "stiffness_N_per_mm"]
    columns += ["sensor_asymmetry", "hertz_force_N", "hertz_contact_area_mm2", "hertz_ellipticity"]
    for at in MAIN:
        own = [row for row in rows if row["case"] == MAIN[at] and row["at"] == at]
        yield part(
            f"Rows of a.h. at {at}", "All are in contact-angle.csv.", table=table(own, columns)
        )


def _predicted(rows: Rows) -> Iterator[str]:
    """Give what the curves say, in sentences."""
    asymmetry, shift, ellipticity = (
        curve(rows, MAIN["1 mm"], "1 mm", name)
        for name in ("asymmetry", "shift_distal_mm", "ellipticity")
    )
    low = min(asymmetry, key=asymmetry.__getitem__)
    across = curve(rows, MAIN["1 mm"], "1 mm", "hertz_radius_side_mm")
    yield (
        "Three regimes. Up to some 30 degrees the plate lies on the flat of the pad: the "
        f"contact is longest along the finger (ellipticity {ellipticity[0.0]:.2f} at 0, "
        f"{ellipticity[30.0]:.2f} at 30 degrees) and its center moves with the angle from "
        f"{shift[0.0]:+.2f} mm to {shift[20.0]:+.2f} mm at 20 degrees, towards the tip, where "
        f"the pad is flatter across (radius {across[0.0]:.1f} mm under first touch at 0, "
        f"{across[30.0]:.1f} at 30 degrees) and the bone is nearer. Between 30 and 45 degrees "
        "first touch reaches the place where the pad turns to the tip: the flat side is "
        f"proximal of it, and so is the force, {100 * asymmetry[low]:+.0f} % at {low:g} degrees; "
        f"the contact is about round (ellipticity {ellipticity[40.0]:.2f} at 40). Beyond, the "
        "plate presses the tip: the contact is small and longest across the finger (ellipticity "
        f"{ellipticity[60.0]:.2f} at 60)."
    )
    force, hertz_force, area, hertz_area = (
        curve(rows, MAIN["1 mm"], "1 mm", name)
        for name in ("force_N", "hertz_force_N", "contact_area_mm2", "hertz_contact_area_mm2")
    )
    stiffer = [force[angle] / hertz_force[angle] for angle in force if angle in hertz_force]
    larger = [area[angle] / hertz_area[angle] for angle in area if angle in hertz_area]
    yield (
        "Elliptic Hertz with the curvatures at first touch has the trend of the area (the "
        f"model's is {min(larger):.2f} to {max(larger):.2f} times it at the same depth) and not "
        f"the force ({min(stiffer):.1f} to {max(stiffer):.1f} times it, because of the bone), "
        "and by its symmetry no shift and no asymmetry at any angle."
    )
    depth = curve(rows, MAIN["1 N"], "1 N", "depth_mm")
    peak = curve(rows, MAIN["1 N"], "1 N", "peak_pressure_kPa")
    near, far = min(depth, key=depth.__getitem__), max(depth, key=depth.__getitem__)
    flat, sharp = min(peak, key=peak.__getitem__), max(peak, key=peak.__getitem__)
    yield (
        f"At a fixed force of 1 N the depth is {depth[near]:.2f} mm at {near:g} degrees and "
        f"{depth[far]:.2f} mm at {far:g}; the peak pressure rises from {peak[flat]:.0f} kPa at "
        f"{flat:g} to {peak[sharp]:.0f} kPa at {sharp:g} degrees."
    )


def _thesis(rows: Rows) -> Iterator[str]:
    """Give the comparison with the thesis's own observation."""
    yield (
        "Section 3.3 of the thesis found the pressure symmetric about the medial line and "
        "clearly asymmetric along the finger, and section 3.4.3 expects its circular model to "
        "be too wide on the distal side, where the pressure falls faster, and too narrow on the "
        "proximal one. Section 3.4.4 adds that the asymmetry varied with the contact angle, "
        "which was not controlled (20 to 40 degrees). The figure has no digits that could be "
        "compared."
    )
    reach = {
        side: curve(rows, MAIN["1 N"], "1 N", f"sensor_reach_{side}_mm")
        for side in ("distal", "proximal")
    }
    shift = curve(rows, MAIN["1 N"], "1 N", "sensor_shift_distal_mm")
    told = {
        angle: (reach["distal"][angle] - shift[angle], reach["proximal"][angle] + shift[angle])
        for angle in reach["distal"]
        if THESIS[0] <= angle <= THESIS[1]
    }
    listed = ", ".join(
        f"{angle:g} degrees {d:.1f} and {p:.1f} mm" for angle, (d, p) in told.items()
    )
    shorter = sum(distal < proximal for distal, proximal in told.values())
    yield (
        "Read by the array at 1 N, the 4 kPa isobar of the model reaches from its centroid "
        f"distally and proximally by, at {listed}: shorter on the distal side at {shorter} of "
        f"these {len(told)} angles, which is the direction that the thesis describes. The force "
        "about first touch is another measure: it is the same on both sides at "
        f"{_crossing(rows):.0f} degrees, with more of it distal below and proximal above. So the "
        "asymmetry of Figure 3-3 says as much about the angle of that trial as about the finger."
    )


def _crossing(rows: Rows) -> float:
    """Return the angle within those of the thesis at which the asymmetry at 1 N is none."""
    found = curve(rows, MAIN["1 N"], "1 N", "asymmetry")
    angles = [angle for angle in sorted(found) if THESIS[0] <= angle <= THESIS[1]]
    values = [found[angle] for angle in angles]
    return float(np.interp(0.0, values[::-1], angles[::-1]))


def _sure(rows: Rows) -> Iterator[dict[str, Any]]:
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
        "How sure: mesh, tissue and strain, one change at a time",
        "At 1 mm, on the finger of a.h.; the first line is the coarse mesh at small strain. "
        f"{_summed(rows)}",
        picture=page.svg(study_figures.panels(chosen, ANGLE, ["case"], ["depth_mm"])),
    )
    for name in ("asymmetry", "force_N", "contact_area_mm2", "ellipticity"):
        base = curve(rows, MAIN["1 mm"], "1 mm", name)
        other = curve(rows, OTHER["1 mm"], "1 mm", name)
        relative = name in ("force_N", "contact_area_mm2")
        told = []
        for angle, value in base.items():
            scale = 100 / value if relative else 1.0
            found = [curve(rows, case, "1 mm", name).get(angle) for case in changed.values()]
            changes = [_told(None if v is None else scale * (v - value), "+.3g") for v in found]
            told.append([f"{angle:g}", _told(value), *changes, _told(other.get(angle))])
        unit = " in %" if relative else ""
        yield part(
            f"How sure: {MEASURES[name]} at 1 mm",
            f"Differences{unit} from the coarse mesh of a.h. with the tissue of Maeno et al. "
            "(1998) at small strain, one change at a time; the finger of p.w. is another one.",
            table={"heading": ["angle", "a.h.", *changed, "p.w."], "rows": told},
        )


def _summed(rows: Rows) -> str:
    """Return how far mesh and finite strain change the numbers at 1 mm, in two sentences."""

    def largest(case: str, name: str, *, relative: bool) -> float:
        base, other = (curve(rows, each, "1 mm", name) for each in (MAIN["1 mm"], case))
        return max(abs(other[a] - base[a]) / (base[a] if relative else 1) for a in other)

    asymmetry, force, area = (
        [largest(case, name, relative=name != "asymmetry") for case in (STANDARD, SOLID)]
        for name in ("asymmetry", "force_N", "contact_area_mm2")
    )
    return (
        f"The standard mesh changes the asymmetry by at most {asymmetry[0]:.3f}, the force by "
        f"{100 * force[0]:.1f} % and the area by {100 * area[0]:.0f} %, most at 0 and 60 "
        "degrees, where few vertices bound it. Finite strain changes the asymmetry by at most "
        f"{asymmetry[1]:.3f}, the force by {100 * force[1]:.0f} % and the area by "
        f"{100 * area[1]:.0f} %: the shape of the curves is kept, the force at a depth is too "
        "low at small strain."
    )


def _told(value: float | None, form: str = ".3g") -> str:
    return "" if value is None else format(value, form)


def _spikes(rows: Rows) -> Iterator[dict[str, Any]]:
    """Give the spikes at a fixed depth and a fixed force."""
    chosen = [
        {**row, "case": name}
        for row in rows
        for case, name in HELD.items()
        if row["case"] == case and row["at"] == "end" and "spikes" in row
    ]
    if chosen:
        yield part(
            "Spikes",
            "One unit of each type under first touch, in the whole of a press to 1 mm at 60 "
            "mm/s held for 5 s (blue), and to 1 N at 2 N/s held for 2 s (orange). The gains are "
            "those of one press at 30 degrees. The unit follows first touch: a fixed receptor "
            "of the skin would leave the contact as the angle changes.",
            picture=page.svg(study_figures.spikes(chosen, ANGLE, ["case"])),
        )


def _experiment(rows: Rows) -> Iterator[str]:
    """Give what would tell the model right or wrong, and how exactly it has to be measured."""
    found = curve(rows, MAIN["1 mm"], "1 mm", "asymmetry")
    angles = np.array(sorted(found))
    slopes = np.diff([found[angle] for angle in angles]) / np.diff(angles)
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
        "keep the peak pressure, the contact area and the ellipticity, which ask for optics or "
        "finer elements."
    )
    tissues = [curve(rows, case, "1 mm", "asymmetry")[40.0] for case in TISSUES]
    yield (
        f"The asymmetry at 40 degrees, as a test of the tissue: {_percent(max(tissues))} with a "
        "stiff skin over soft pulp (Dandekar et al. 2003), "
        f"{_percent(curve(rows, MAIN['1 mm'], '1 mm', 'asymmetry')[40.0])} with the layers of "
        f"Maeno et al. (1998), {_percent(min(tissues))} with one tissue throughout (coarse "
        f"mesh). At 20 degrees the three agree within {100 * _spread(rows, 20.0):.0f} % of the "
        "force."
    )
    shape = max(_spread(rows, angle, "ellipticity") for angle in found)
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
    own, read = (curve(rows, MAIN["1 mm"], "1 mm", each) for each in (name, f"sensor_{name}"))
    return max(abs(read[angle] - own[angle]) for angle in read if low <= angle <= high)


def _spread(rows: Rows, angle: float, name: str = "asymmetry") -> float:
    """Return the range of a measure at 1 mm over the tissues, on the coarse mesh."""
    cases = (MAIN["1 mm"], *TISSUES)
    return float(np.ptp([curve(rows, case, "1 mm", name)[angle] for case in cases]))


def _limits(rows: Rows) -> Iterator[str]:
    """Give what the numbers rest on, and which scenes have none."""
    yield (
        "The shape is parametric: constant curvature along the pad, a turn to the tip between "
        "slopes of 34 and 48 degrees, a bone of published proportions. The three regimes follow "
        "from it; their limits in degrees would be others on another finger."
    )
    yield (
        "The tissue is not fitted to a subject, so forces and pressures are those of a finger "
        "of published moduli; beyond 25 degrees the asymmetry depends on the ratio of skin to "
        "pulp as much as on the angle (see above)."
    )
    yield "Small strain, frictionless, rigid bone; the nail is held as in the experiment."
    for row in rows:
        if row["at"] == "":
            yield f"{row['case']}, {row[ANGLE]:g} degrees: {row['status']}"

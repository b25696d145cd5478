"""The page on the contact angle: every number in its sentences is read from the rows."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from fefinger.validation.contact_angle.rows import (
    ANGLE,
    FORCES,
    HELD,
    HELD_FORCE,
    MAIN,
    MEASURES,
    OTHER,
    THESIS,
    TISSUES,
    Rows,
    curve,
    percent,
)
from fefinger.validation.contact_angle.sure import experiment, sure

from fefinger.pages import page
from fefinger.studies import figures
from fefinger.studies.columns import READINGS
from fefinger.studies.page import ARRAY, HOW, MEANING, errors, part, table
from fefinger.view.figures import COLORS


def html(rows: Rows, provenance: Mapping[str, Any]) -> str:
    """Return the page."""
    return page.render(
        "study.html",
        data=("contact-angle.csv",),
        title="Contact angle, 0 to 60 degrees",
        answer=answer(rows),
        lines=(errors(rows), figures.LEGEND),
        parts=[*_parts(rows), part(HOW, MEANING, ARRAY)],
        provenance=list(page.flat(provenance)),
    )


def answer(rows: Rows) -> str:
    """Return the finding in a few sentences."""
    asymmetry = curve(rows, MAIN["1 mm"], "1 mm", "asymmetry")
    force, area = (
        curve(rows, MAIN["1 mm"], "1 mm", name) for name in ("force_N", "contact_area_mm2")
    )
    inside = {angle: value for angle, value in asymmetry.items() if THESIS[0] <= angle <= THESIS[1]}
    high, low = max(inside, key=inside.__getitem__), min(inside, key=inside.__getitem__)
    stiff, soft = max(force, key=force.__getitem__), min(force, key=force.__getitem__)
    others = [curve(rows, case, "1 mm", "asymmetry")[low] for case in TISSUES]
    return (
        f"Pressed 1 mm, the model of subject a.h. bears {percent(inside[high])} of its force "
        f"more distally than proximally of first touch at {high:g} degrees and "
        f"{percent(inside[low])} at {low:g}: within the {THESIS[0]:g} to {THESIS[1]:g} degrees "
        "of the thesis's fingers it falls through zero. How far it falls is decided "
        f"by the tissue: with two other published tissues it is {percent(max(others))} and "
        f"{percent(min(others))} at {low:g} degrees. The force at 1 mm falls from "
        f"{force[stiff]:.2f} N at {stiff:g} degrees to {force[soft]:.2f} N at {soft:g}, the "
        f"contact area from {max(area.values()):.0f} to {min(area.values()):.0f} mm²."
    )


def _parts(rows: Rows) -> Iterator[dict[str, Any]]:
    yield part("Predictions of the model", *_predicted(rows))
    for at, skip in (("1 mm", "depth_mm"), ("1 N", "force_N")):
        chosen = [
            {**row, "case": row["case"].partition(" to ")[0]}
            for row in rows
            if row["at"] == at and row["status"] == "done" and row["case"] in (MAIN[at], OTHER[at])
        ]
        how = {"1 mm": "a ramp at 60 mm/s", "1 N": "a ramp of the force at 40 N/s"}[at]
        text = (
            f"Fingers of subjects a.h. and p.w. on the loading, at {at}: {how}. Coarse mesh, "
            "tissue of Maeno et al. (1998)."
        )
        picture = page.svg(figures.panels(chosen, ANGLE, ["case"], [skip]))
        title = f"At a fixed {'depth' if at == '1 mm' else 'force'}, {at}"
        yield part(title, text, picture=picture)
    yield from _by_force(rows)
    with_array = [
        row
        for row in rows
        if row["case"] == MAIN["1 N"] and row["at"] == "1 N" and row.get(READINGS)
    ]
    yield part(
        "Simulated readings of the array of the thesis at 1 N",
        "Isobars 4 kPa apart, by angle in degrees; the tip is up, the cross is first touch. "
        "Subject a.h., without noise.",
        picture=page.svg(figures.isobars(with_array, ANGLE)),
    )
    yield part("Against Figure 3-3 of the thesis", *_thesis(rows))
    yield from sure(rows)
    yield from _spikes(rows)
    yield part("Recommended measurements", bullets=list(experiment(rows)))
    yield part("Limitations of the model", bullets=list(_limits(rows)))
    columns = [ANGLE, *MEASURES, "reach_distal_mm", "reach_proximal_mm", "stiffness_N_per_mm"]
    columns += ["sensor_asymmetry", "hertz_force_N", "hertz_contact_area_mm2", "hertz_ellipticity"]
    for at in MAIN:
        rows_at = [row for row in rows if row["case"] == MAIN[at] and row["at"] == at]
        yield part(
            f"Rows of a.h. at {at}", "All are in contact-angle.csv.", table=table(rows_at, columns)
        )


def _predicted(rows: Rows) -> Iterator[str]:
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
        f"{shift[0.0]:+.2f} mm to {shift[20.0]:+.2f} mm at 20 degrees, toward the tip, where "
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
    peak = curve(rows, MAIN["1 N"], "1 N", "highest_pressure_1mm2_kPa")
    near, far = min(depth, key=depth.__getitem__), max(depth, key=depth.__getitem__)
    flat, sharp = min(peak, key=peak.__getitem__), max(peak, key=peak.__getitem__)
    yield (
        f"At a fixed force of 1 N the depth is {depth[near]:.2f} mm at {near:g} degrees and "
        f"{depth[far]:.2f} mm at {far:g}; the highest pressure over 1 mm² rises from "
        f"{peak[flat]:.0f} kPa at {flat:g} to {peak[sharp]:.0f} kPa at {sharp:g} degrees."
    )


def _by_force(rows: Rows) -> Iterator[dict[str, Any]]:
    """Give the measures against the angle at several forces on the loading."""
    measures = {**MEASURES, "stiffness_N_per_mm": "", **{f"spikes_{kind}": "" for kind in COLORS}}

    def loading(case: str) -> list[dict[str, Any]]:
        return [
            {"case": row["at"], ANGLE: row[ANGLE]} | {k: row[k] for k in measures if row.get(k)}
            for at in FORCES
            for row in rows
            if row["case"] == case and row["at"] == at and row["status"] == "done"
        ]

    turned = {at: _crossing(rows, at) for at in FORCES}
    area = {at: curve(rows, MAIN["1 N"], at, "contact_area_mm2")[30.0] for at in FORCES}
    larger, stronger = area[FORCES[-1]] / area[FORCES[0]], _newtons(-1) / _newtons(0)
    power = np.log(larger) / np.log(stronger)
    yield part(
        "Against the force",
        f"Subject a.h. on the way to 1 N at 40 N/s. From {FORCES[0]} to {FORCES[-1]} the contact "
        f"at 30 degrees grows from {area[FORCES[0]]:.0f} to {area[FORCES[-1]]:.0f} mm², as the "
        f"force to the power of {power:.2f}; the angle at which as much of the force is distal as "
        f"proximal of first touch is {turned[FORCES[0]]:.0f} degrees at {FORCES[0]} and "
        f"{turned[FORCES[-1]]:.0f} at {FORCES[-1]}.",
        picture=page.svg(figures.panels(loading(MAIN["1 N"]), ANGLE, ["case"], ["force_N"])),
    )
    fired = [row for row in loading(HELD_FORCE) if any(key.startswith("spikes_") for key in row)]
    if fired:
        yield part(
            "Spikes against the force",
            "One unit of each type under first touch, up to these forces on the way to 1 N at 2 "
            "N/s: blue, orange and green from the smallest force to the largest.",
            picture=page.svg(figures.spikes(fired, ANGLE, ["case"])),
        )


def _newtons(number: int) -> float:
    return float(FORCES[number].removesuffix(" N"))


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
    reaches = {
        angle: (reach["distal"][angle] - shift[angle], reach["proximal"][angle] + shift[angle])
        for angle in reach["distal"]
        if THESIS[0] <= angle <= THESIS[1]
    }
    listed = ", ".join(
        f"{angle:g} degrees {d:.1f} and {p:.1f} mm" for angle, (d, p) in reaches.items()
    )
    shorter = sum(distal < proximal for distal, proximal in reaches.values())
    yield (
        "Read by the array at 1 N, the 4 kPa isobar of the model reaches from its centroid "
        f"distally and proximally by, at {listed}: shorter on the distal side at {shorter} of "
        f"these {len(reaches)} angles, which is the direction that the thesis describes. The force "
        "about first touch is another measure: it is the same on both sides at "
        f"{_crossing(rows):.0f} degrees, with more of it distal below and proximal above. So the "
        "asymmetry of Figure 3-3 says as much about the angle of that trial as about the finger."
    )


def _crossing(rows: Rows, at: str = "1 N") -> float:
    """Return the angle within those of the thesis at which the asymmetry at a force is none."""
    asymmetry = curve(rows, MAIN["1 N"], at, "asymmetry")
    angles = [angle for angle in sorted(asymmetry) if THESIS[0] <= angle <= THESIS[1]]
    values = [asymmetry[angle] for angle in angles]
    return float(np.interp(0.0, values[::-1], angles[::-1]))


def _spikes(rows: Rows) -> Iterator[dict[str, Any]]:
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
            picture=page.svg(figures.spikes(chosen, ANGLE, ["case"])),
        )


def _limits(rows: Rows) -> Iterator[str]:
    """Yield the basis of the numbers, and the scenes without numbers."""
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
    if any(row["at"] == "" for row in rows):
        yield (
            "A plate along the bone comes to lie on the pad as far back as the crease of the last "
            "joint, where the modeled finger ends (its proximal cut): a scene whose contact gets "
            "there has no answer, as stated below."
        )
    for row in rows:
        if row["at"] == "":
            yield f"{row['case']}, {row[ANGLE]:g} degrees: {row['status']}"

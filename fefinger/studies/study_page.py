"""Page of a study as one HTML file with its pictures."""

from collections.abc import Iterator, Sequence

from fefinger.pages import page
from fefinger.studies import study_figures as figures
from fefinger.studies.columns import ERRORS, MEASURES, Row
from fefinger.studies.force_depth import POINTS, WINDOW
from fefinger.studies.grid import remarks
from fefinger.studies.tables import StudyRows
from fefinger.support.text import brief, percent


MEANING = (
    "Positions are from the first touch on the smooth skin, toward the tip (distal) in the plane "
    "of the object. Asymmetry is the difference of the forces distal and proximal of first touch "
    "over their sum; ellipticity is 1 - b/a from the second moments of the pressure. Rows at a "
    "force or a depth are at its first crossing on the loading, by linear interpolation in time. "
    "The highest pressure is the largest mean over 1 mm² (by a Gaussian), not that of a point of "
    "the mesh; the strain is the root mean square, over the end organs, of the tensor's Frobenius "
    "norm. "
    f"Stiffness is the slope of the force over the depth, fitted to the loading within a factor of "
    f"{WINDOW:g} of the depth, to at least {POINTS} time steps; the column stiffness_note gives "
    "the reason where there is none. Of a vibration, dynamic stiffness and phase are those of the "
    "force over the depth in its last cycles."
)

HOW = "How the measures are defined"

SAME = "Every measure is the same in all of these rows, but for rounding of half a percent."

HERTZ = (
    "Hertz's ellipse follows from the curvatures of the skin, fitted within 2 mm of first touch, "
    "at the same depths, on a relaxing half-space."
)

MAIN = (
    *("at", "force_N", "force_rel_error", "depth_mm", "depth_rel_error", "contact_area_mm2"),
    *("contact_area_rel_error", "highest_pressure_1mm2_kPa", "highest_pressure_rel_error"),
    *("strain_rms_percent", "strain_rel_error", "stiffness_N_per_mm"),
    *("dynamic_stiffness_N_per_mm", "phase_deg", "spikes", "mechanics", "mesh", "seconds"),
)
SHAPE = (
    *("at", "shift_distal_mm", "asymmetry", "ellipticity", "reach_distal_mm", "reach_proximal_mm"),
    *("hertz_force_N", "hertz_contact_area_mm2", "hertz_highest_pressure_1mm2_kPa"),
)
"""Columns of the tables on the page; the files have all."""

Part = dict[str, object]
"""A section of the page: title, texts, and perhaps a picture, bullets or a table."""


def html(study: StudyRows) -> str:
    """Render the page of a study."""
    has_hertz = any(row.get("hertz_force_N") is not None for row in study.rows)
    done = study.scenes - len(study.failures)
    swept = []
    for name, values in study.about["grid"].items():
        texts = [text(value) for value in values]
        span = f"{texts[0]} to {texts[-1]} in {len(texts)} steps"
        swept.append(f"{name} {', '.join(texts) if len(texts) <= 4 else span}")
    grid = " and ".join(swept).removesuffix(".")
    return page.render(
        "study.html",
        data=("table.csv", "study.json"),
        title=f"{study.name} over {', '.join(study.about['grid'])}",
        answer=f"{done} of {study.scenes} scenes were answered: {grid}.",
        notes=[*filter(None, [study.about.get("chosen")]), *remarks(study.rows, study.over)],
        lines=(errors(study.rows), *([figures.LEGEND] if has_hertz else [])),
        parts=[*_parts(study), part(HOW, MEANING, *([HERTZ] if has_hertz else []))],
        provenance=list(page.flat(study.about)),
    )


def part(title: str, *texts: str, **more: object) -> Part:
    """Make a section of the page; `more`: a picture, bullets or a table."""
    return {"title": title, "texts": texts, **more}


def table(rows: Sequence[Row], columns: Sequence[str]) -> dict[str, object]:
    """Make a table of the columns that have a value in some row."""
    heading = [name for name in columns if any(row.get(name) is not None for row in rows)]
    return {"heading": heading, "rows": [[text(row.get(name)) for name in heading] for row in rows]}


def text(value: object) -> str:
    """Format a value with at most four digits."""
    if value is None:
        return ""
    if isinstance(value, float) and abs(value) < figures.NOTHING:
        return "0"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def errors(rows: Sequence[Row]) -> str:
    """Explain the error bars of the figures, with the least and the largest expected errors."""
    done = [row for row in rows if row["status"] == "done"]
    ranges, unknown = [], []
    for name, column in ERRORS.items():
        measured = [row for row in done if row.get(name) is not None and not _given(name, row)]
        values = [row[column] for row in measured if row.get(column) is not None]
        ends = dict.fromkeys(percent(end) for end in (min(values), max(values))) if values else ()
        ranges += [f"{MEASURES[name]} {' to '.join(ends)}"] if values else []
        missing = len(measured) - len(values)
        unknown += [f"{MEASURES[name]} in {missing} of {len(done)} rows"] if missing else []
    bars = (
        f"A bar spans the range of the true value by its expected error: {', '.join(ranges)}. Bars "
        "end at twice the value. The errors are of mesh, time steps and model (simplifications of "
        "the mechanics), not of the tissue or the shape of the finger. While the force rises they "
        "are those of a press to the depth of the row. After its peak they are those of the whole "
        "press; the error of the force is then relative to the peak, and so larger relative to the "
        "remaining force."
    )
    missing_errors = f"Error not known: {', '.join(unknown)}." if unknown else ""
    first = bars if ranges else "Error not known for any row."
    bare = [
        label
        for name, label in MEASURES.items()
        if name not in ERRORS and any(row.get(name) is not None for row in done)
    ]
    never = f"No error is stated of {'; '.join(bare)}." if bare else ""
    return " ".join(filter(None, (first, missing_errors, never)))


def _given(name: str, row: Row) -> bool:
    """Return whether the motion prescribes a measure, which then has no error."""
    if name == "depth_mm":
        return row.get(ERRORS[name]) is None
    return name == "force_N" and row.get(ERRORS["depth_mm"]) is not None


def _parts(study: StudyRows) -> Iterator[Part]:
    """Yield the sections: failures, figures at each time, spikes and tables."""
    if study.failures:
        failed = [
            f"{', '.join(f'{field} = {value}' for field, value in values.items())}: {brief(error)}"
            for values, error in study.failures
        ]
        yield part("Failed scenes", "These scenes have no numbers.", bullets=failed)
    done = [row for row in study.rows if row["status"] == "done"]
    numeric = [
        name for name in study.over if all(isinstance(row[name], int | float) for row in done)
    ]
    x = (numeric or list(study.over))[0]
    done = [row if numeric else row | {x: str(row[x])} for row in done]
    series = [name for name in study.over if name != x]
    labels = list(figures.grouped(done, series))
    for at in dict.fromkeys(row["at"] for row in done):
        rows = [row for row in done if row["at"] == at]
        skip = {"N": ("force_N",), "mm": ("depth_mm",)}.get(at.rpartition(" ")[2], ())
        where = {"peak": "at the largest force", "end": "at the end"}.get(at, f"at {at}")
        if not figures.varying(rows, skip):
            yield part(f"The contact {where}", SAME)
            continue
        picture = page.svg(figures.panels(rows, x, series, skip, labels))
        yield part(f"The contact {where}", picture=picture)
    ends = [row for row in done if row["at"] == "end"]
    if any("spikes" in row for row in ends):
        picture = page.svg(figures.spikes(ends, x, series, labels))
        yield part("Spikes of the whole scene", picture=picture)
    more = "All columns are in table.csv."
    yield part("Rows: contact, and expected errors", more, table=table(done, (*study.over, *MAIN)))
    yield part("Rows: shape, Hertz", more, table=table(done, (*study.over, *SHAPE)))

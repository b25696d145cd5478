"""A Study as one self-contained HTML page."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from fefinger.pages import page
from fefinger.studies import figures
from fefinger.studies.columns import ERRORS, MEASURES
from fefinger.studies.grid import remarks
from fefinger.studies.slope import POINTS, WINDOW
from fefinger.support.text import brief, percent


if TYPE_CHECKING:
    from fefinger.studies.rows import StudyRows

MEANING = (
    "Places are from the first touch on the smooth skin, towards the tip (distal) in the plane of "
    "the object. Asymmetry is the force distal of first touch less that proximal of it, over both; "
    "ellipticity is 1 - b/a from the second moments of the pressure. Rows at a force or a depth "
    "are met on the loading, between two time steps along straight lines in time. The highest "
    "pressure is the largest mean over 1 mm² (by a Gaussian), not that of a point of the mesh; the "
    "strain the root mean square, over the end organs, of the tensor's Frobenius norm. "
    f"Stiffness is the slope of the force over the depth, fitted to the loading within a factor of "
    f"{WINDOW:g} of the depth, to {POINTS} time steps at least; the column stiffness_note says why "
    "there is none."
)

ARRAY = (
    "The array of the thesis (8 x 8 elements 2 mm apart, a Gaussian of 0.96 mm, here without "
    "noise) lies on the plate with its middle under the center of the largest pressure; the area "
    "that it sees is that of the elements above 2 kPa. Hertz's ellipse follows from the curvatures "
    "of the skin, fitted within 2 mm of first touch, at the same depths, on a relaxing half-space."
)

MAIN = (
    *("at", "force_N", "force_rel_error", "depth_mm", "depth_rel_error", "contact_area_mm2"),
    *("contact_area_rel_error", "highest_pressure_1mm2_kPa", "highest_pressure_rel_error"),
    *("strain_rms_percent", "strain_rel_error", "stiffness_N_per_mm", "spikes", "mechanics"),
    *("mesh", "seconds"),
)
SHAPE = (
    *("at", "shift_distal_mm", "asymmetry", "ellipticity", "reach_distal_mm", "reach_proximal_mm"),
    *("sensor_peak_kPa", "sensor_asymmetry", "hertz_force_N", "hertz_contact_area_mm2"),
    *("hertz_highest_pressure_1mm2_kPa",),
)
"""Columns of the tables on the page; the files have all."""

MOST = 15
"""Maps of the array on the page."""


def html(study: "StudyRows") -> str:
    """Return the page on a study."""
    done = study.scenes - len(study.failures)
    swept = " and ".join(_values(name, study.about["grid"][name]) for name in study.about["grid"])
    return page.render(
        "study.html",
        data=("table.csv", "study.json"),
        title=f"{study.name} over {', '.join(study.about['grid'])}",
        answer=f"{done} of {study.scenes} scenes were answered: {swept.removesuffix('.')}.",
        notes=[*filter(None, [study.about.get("chosen")]), *remarks(study.rows, study.over)],
        lines=(errors(study.rows), MEANING, *([ARRAY] if _arrayed(study.rows) else [])),
        parts=list(_parts(study)),
        provenance=list(page.flat(study.about)),
    )


def _arrayed(rows: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether some row tells what an array on a plate reads."""
    return any(row.get("sensor_peak_kPa") is not None for row in rows)


def part(title: str, *texts: str, **more: Any) -> dict[str, Any]:
    """Return a section of the page; `more` are a picture, bullets or a table."""
    return {"title": title, "texts": texts, **more}


def table(rows: Sequence[Mapping[str, Any]], columns: Sequence[str]) -> dict[str, Any]:
    """Return a table of those columns that have a value in some row."""
    known = [name for name in columns if any(row.get(name) is not None for row in rows)]
    return {"heading": known, "rows": [[text(row.get(name)) for name in known] for row in rows]}


def text(value: Any) -> str:
    """Return a value with four digits at most."""
    if value is None:
        return ""
    if isinstance(value, float) and abs(value) < figures.NOTHING:
        return "0"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def errors(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return what the bars of the figures are, with the range of each stated error."""
    told = [row for row in rows if row["status"] == "done"]
    said, unknown = [], []
    for name, column in ERRORS.items():
        asked = [row for row in told if row.get(name) is not None and not _given(name, row)]
        found = [row[column] for row in asked if row.get(column) is not None]
        ends = dict.fromkeys(percent(end) for end in (min(found), max(found))) if found else ()
        said += [f"{MEASURES[name]} {' to '.join(ends)}"] if found else []
        less = len(asked) - len(found)
        unknown += [f"{MEASURES[name]} in {less} of {len(told)} rows"] if less else []
    known = (
        f"A bar spans the true values that the stated errors leave open: {', '.join(said)}; one "
        "that would go beyond twice the value told ends there. The errors are of mesh, time steps "
        "and model (what the mechanics leaves out), not of the tissue or the shape of the finger. "
        "While the force rises they are those of a press to the depth of the row. After its peak "
        "they are those of the whole press; that of the force is then a share of the peak, and so "
        "a larger one of the force that is left."
    )
    some = f"No error is known of: {', '.join(unknown)}." if unknown else ""
    return " ".join(filter(None, (known if said else "No error is stated of any row.", some)))


def _given(name: str, row: Mapping[str, Any]) -> bool:
    """Return whether a measure is what the motion prescribes, and so has no error."""
    if name == "depth_mm":
        return row.get(ERRORS[name]) is None
    return name == "force_N" and row.get(ERRORS["depth_mm"]) is not None


def _values(name: str, values: Sequence[Any]) -> str:
    said = [text(value) for value in values]
    listed = ", ".join(said) if len(said) <= 4 else f"{said[0]} to {said[-1]} in {len(said)} steps"
    return f"{name} {listed}"


def _parts(study: "StudyRows") -> Iterator[dict[str, Any]]:
    """Give the sections: what failed, figures at each time, maps, spikes, and the table."""
    if study.failures:
        failed = [
            f"{', '.join(f'{field} = {value}' for field, value in values.items())}: {brief(error)}"
            for values, error in study.failures
        ]
        yield part("What failed", "These scenes have no numbers.", bullets=failed)
    told = [row for row in study.rows if row["status"] == "done"]
    numeric = [name for name in study.over if not isinstance(told[0][name], str)] if told else []
    x = (numeric or list(study.over))[0]
    series = [name for name in study.over if name != x]
    for at in dict.fromkeys(row["at"] for row in told):
        rows = [row for row in told if row["at"] == at]
        skip = {"N": ("force_N",), "mm": ("depth_mm",)}.get(at.rpartition(" ")[2], ())
        where = {"peak": "at the largest force", "end": "at the end"}.get(at, f"at {at}")
        picture = page.svg(figures.panels(rows, x, series, skip))
        yield part(f"The contact {where}", picture=picture)
    ends = [row for row in told if row["at"] == "end"]
    if any("spikes" in row for row in ends):
        yield part("Spikes of the whole scene", picture=page.svg(figures.spikes(ends, x, series)))
    yield from maps(told, x)
    said = "All columns are in table.csv."
    yield part("Rows: contact, and stated errors", said, table=table(told, (*study.over, *MAIN)))
    yield part("Rows: shape, array, Hertz", said, table=table(told, (*study.over, *SHAPE)))


def maps(rows: Sequence[Mapping[str, Any]], x: str) -> Iterator[dict[str, Any]]:
    """Give the section with what the array reads, of the first series at a force if there is."""
    from fefinger.studies.measures import READINGS

    felt = [row for row in rows if row.get(READINGS)]
    times = sorted({row["at"] for row in felt}, key=lambda at: (not at.endswith("N"), at))
    if not times:
        return
    shown = {row[x]: row for row in reversed(felt) if row["at"] == times[0]}
    picked = [shown[value] for value in sorted(shown)][:MOST]
    if isinstance(picked[0][x], str):
        return
    yield part(
        f"What the array reads at {times[0]}",
        f"Isobars 4 kPa apart as in Figure 3-3 of the thesis, at values of {x}, in the same colors "
        "in all panels; the tip is up, and the cross is first touch.",
        picture=page.svg(figures.isobars(picked, x, READINGS)),
    )

"""Page of a study as one HTML file, with the figures of its measures and spikes."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, TypedDict

import numpy as np

from fefinger.pages import page
from fefinger.scene.schema import split
from fefinger.studies.grid import DIGITS, ERRORS, MEASURES, Row, bounds, remarks, words
from fefinger.studies.tables import POINTS, WINDOW, StudyRows
from fefinger.support.text import brief, entries, percent
from fefinger.view import figures


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


Rows = Sequence[Row]
Groups = dict[str, list[Row]]

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#E69F00", "#56B4E9", "#1f2933", "#8b98a5")
"""Colors of series: Okabe and Ito (2008), as for the afferents."""

MARKERS = "os^D"
"""Markers of the first to the fourth series of a color."""


HERTZ_COLUMN, OF_HERTZ = "hertz_", "elliptic Hertz at that depth"
"""Prefix of the columns of a half-space, drawn as dotted lines in the same panels; its label."""

LEGEND = (
    "Solid lines are the finger that was simulated, with a point per scene; bars are its stated "
    "error. Dotted lines are Hertz's formula for the same curvatures at the same depth, without "
    "bone."
)
"""Caption of panels that have lines of both kinds."""

EQUAL = 0.005
"""Relative variation of a measure up to which it counts as constant."""

NOTHING = 1e-9
"""Value of a measure, in its unit, that counts as zero: it is rounding."""


def label(row: Row, series: Sequence[str]) -> str:
    """Return the label of a row's series: the values of the fields in `series` with their units."""
    fields = {name: split(name)[0].rpartition(".")[2] for name in series}
    texts = (
        row[name] if isinstance(row[name], str) else f"{field} {_value(row, name)}"
        for name, field in fields.items()
    )
    return ", ".join(texts)


def _value(row: Row, name: str) -> str:
    value = row[name]
    text = f"{value:.{DIGITS}g}" if isinstance(value, float) else str(value)
    return f"{text} {split(name)[1]}".strip()


class Look(TypedDict):
    """Color and marker of a series."""

    color: str
    marker: str


def _look(number: int) -> Look:
    """Return the color and marker of a series; series of the same color differ in marker."""
    turn, color = divmod(number, len(PALETTE))
    return {"color": PALETTE[color], "marker": MARKERS[turn % len(MARKERS)]}


def panels(
    rows: Rows,
    x: str,
    series: Sequence[str],
    skip: Sequence[str] = (),
    labels: Sequence[str] = (),
) -> "Figure":
    """Draw every measure of `rows` against the column `x`, a color for each of the `series`.

    Bars are expected errors. Measures in `skip` and constant ones, such as the depth at the end of
    equal presses, are left out. `labels` of all series of a page keep each in its color, though
    these rows may lack some.
    """
    from matplotlib.lines import Line2D

    groups, names = grouped(rows, series, labels), varying(rows, skip)
    count = max(-(-len(names) // 3), 1)
    with figures.style():
        drawn = figures.figure(figures.WIDE, 0.7 + 2.15 * count)
        axes = drawn.subplots(count, 3, squeeze=False, sharex=True)
        for axis, name in zip(axes.flat, names, strict=False):
            _panel(axis, groups, x, name)
        for axis in axes.flat[len(names) :]:
            axis.set_axis_off()
        for column in axes.T:
            for axis in [axis for axis in column if axis.axison][-1:]:
                axis.set_xlabel(words(x))
                axis.tick_params(labelbottom=True)
        hertz = Line2D([], [], color=figures.INK, linestyle=":", label=OF_HERTZ)
        there = any(
            _number(row, name) for row in rows for name in row if name.startswith(HERTZ_COLUMN)
        )
        _legend(drawn, groups, [hertz] if there else [])
        return drawn


def varying(rows: Rows, skip: Sequence[str] = ()) -> list[str]:
    """Return the measures that are not the same in all rows."""
    return [name for name in MEASURES if name not in skip and _varies(rows, name)]


def _panel(axis: "Axes", groups: Groups, x: str, name: str) -> None:
    """Draw one measure with its expected errors, and the same of a half-space."""
    for number, group in enumerate(groups.values()):
        look = _look(number)
        _bars(axis, group, x, name, number)
        for style, column in (("-", name), (":", HERTZ_COLUMN + name)):
            finite = [row for row in group if _number(row, column)]
            axis.plot(
                [row[x] for row in finite],
                [row[column] for row in finite],
                style,
                color=look["color"],
                marker=look["marker"] if style == "-" else None,
                markersize=2.5,
                linewidth=1.6 if style == "-" else 1.1,
            )
    axis.set_title(words(name))
    if name in ("asymmetry", "shift_distal_mm"):
        axis.axhline(0, color=figures.STEEL, linewidth=0.7)


def _bars(axis: "Axes", group: Rows, x: str, name: str, number: int) -> None:
    """Draw the bounds of a measure by its expected error; caps of series differ in size."""
    limits = [(row, bounds(row, name)) for row in group if _number(row, name)]
    bars = [(row, each) for row, each in limits if each is not None]
    if not bars:
        return
    values = np.array([row[name] for row, _ in bars], float)
    ends = np.array([each for _, each in bars])
    axis.errorbar(
        [row[x] for row, _ in bars],
        values,
        yerr=[values - ends[:, 0], ends[:, 1] - values],
        fmt="none",
        ecolor=_look(number)["color"],
        elinewidth=0.9,
        capsize=2 + 1.5 * (number % len(PALETTE)),
        alpha=0.6,
    )


def grouped(rows: Rows, series: Sequence[str], labels: Sequence[str] = ()) -> Groups:
    """Group the rows by the label of their series, in the order of `labels` and of the rows."""
    groups: Groups = {name: [] for name in labels}
    for row in rows:
        groups.setdefault(label(row, series), []).append(row)
    return groups


def _legend(drawn: "Figure", groups: Groups, others: "Sequence[Line2D]" = ()) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], label=name, markersize=2.5, **_look(number))
        for number, (name, group) in enumerate(groups.items())
        if name and group
    ]
    handles += others
    if handles:
        drawn.legend(handles=handles, loc="outside upper center", ncols=min(len(handles), 4))


def _number(row: Row, name: str) -> bool:
    """Return whether a row has a finite number in a column."""
    value = row.get(name)
    return isinstance(value, int | float) and bool(np.isfinite(value))


def _varies(rows: Rows, name: str) -> bool:
    """Return whether numbers of a column vary by more than EQUAL and NOTHING; so does one alone."""
    values = [row[name] for row in rows if _number(row, name)]
    most = max(EQUAL * np.abs(values).max(initial=0.0), NOTHING)
    return len(values) == 1 or (len(values) > 1 and np.ptp(values) > most)


def spikes(rows: Rows, x: str, series: Sequence[str], labels: Sequence[str] = ()) -> "Figure":
    """Draw the spikes of each type against the column `x`, in the colors of `panels`."""
    groups = grouped(rows, series, labels)
    types = [kind for kind in figures.COLORS if any(f"spikes_{kind}" in row for row in rows)]
    with figures.style():
        drawn = figures.figure(figures.WIDE, 2.4)
        axes = drawn.subplots(1, len(types), squeeze=False)
        for axis, kind in zip(axes[0], types, strict=True):
            for number, group in enumerate(groups.values()):
                counted = [row for row in group if _number(row, f"spikes_{kind}")]
                places, counts = ([row[name] for row in counted] for name in (x, f"spikes_{kind}"))
                (line,) = axis.plot(places, counts, markersize=2.5, **_look(number))
                ends = (
                    [row.get(f"{end}_spikes_{kind}", row[f"spikes_{kind}"]) for row in counted]
                    for end in ("least", "largest")
                )
                axis.fill_between(places, *ends, color=line.get_color(), alpha=0.2, linewidth=0)
            axis.set(title=f"{kind}: spikes", xlabel=words(x))
            axis.set_ylim(bottom=0)
            axis.yaxis.get_major_locator().set_params(integer=True)
        _legend(drawn, groups)
        return drawn


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
        lines=(errors(study.rows), *([LEGEND] if has_hertz else [])),
        parts=[*_parts(study), part(HOW, MEANING, *([HERTZ] if has_hertz else []))],
        provenance=list(entries(study.about)),
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
    if isinstance(value, float) and abs(value) < NOTHING:
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
    labels = list(grouped(done, series))
    for at in dict.fromkeys(row["at"] for row in done):
        rows = [row for row in done if row["at"] == at]
        skip = {"N": ("force_N",), "mm": ("depth_mm",)}.get(at.rpartition(" ")[2], ())
        where = {"peak": "at the largest force", "end": "at the end"}.get(at, f"at {at}")
        if not varying(rows, skip):
            yield part(f"The contact {where}", SAME)
            continue
        picture = page.svg(panels(rows, x, series, skip, labels))
        yield part(f"The contact {where}", picture=picture)
    ends = [row for row in done if row["at"] == "end"]
    if any("spikes" in row for row in ends):
        picture = page.svg(spikes(ends, x, series, labels))
        yield part("Spikes of the whole scene", picture=picture)
    more = "All columns are in table.csv."
    yield part("Rows: contact, and expected errors", more, table=table(done, (*study.over, *MAIN)))
    yield part("Rows: shape, Hertz", more, table=table(done, (*study.over, *SHAPE)))

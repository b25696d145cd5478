"""Tables and figure of suite `calibration`: sensitivity of R, m and c0 b to assumptions."""

from collections.abc import Iterator
from typing import Any

from fefinger.validation.calibration.report import calibrated, sensitivity
from fefinger.validation.calibration.subject_target import printed
from fefinger.validation.panels import panels

from fefinger.view.figures import INK, STEEL, WIDE


BLUE, ORANGE = "#0072B2", "#D55E00"
NAMES = ("radius", "m", "c0_b")
HEADS = ("R / mm", "m / 1/mm", "c0 b / kPa/mm")
OF_FORCE = ("stiffness_m", "stiffness_b", "radius")
MISSES = 0.1
"""Misfit from which a finger no longer has the force of its subject: ten times that of the best."""
ROUNDING = 1e-9
"""What the fit leaves of a value that it drives to zero."""

SESSIONS = (
    "Tables 2.1 and 3.2 are from two sessions and do not describe the same contact. Results of "
    "the thesis's fit to frames up to 2.3 N: for the half-space of Table 3.2 with the noise of "
    "the array it returns the printed row. For a Hertz contact with the printed R and the "
    "relaxed force of Table 2.1, with touch at zero force or 0.3 mm earlier, it returns R but "
    "different m and c0 b, which a finger with the force of Table 2.1 therefore shows. Last "
    "row: the calibrated finger at 0.2 mm/s, whose tissue is not fully relaxed."
)


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure: effect of assumptions."""
    yield _caption(), _sensitivity()


def tables() -> Iterator[dict[str, Any]]:
    """Yield the table of the assumptions, if they were tried, and that of the two sessions."""
    if sensitivity()["finger"]:
        yield _assumptions()
    yield _sessions()


def _caption() -> str:
    subject, tried = sensitivity()["subject"], sensitivity()["finger"]
    read = sensitivity()["reading"][subject]
    small = max(
        abs(row["radius"] - read[0]["radius"])
        for row in read
        if not row["lever"].startswith(("touch", "pressed"))
    )
    above = (
        "Upper block: fingers of the coarse mesh, pressed to 1.1 N, modulus and exponent refitted "
        "to the force of Table 2.1, hollow where that force cannot be fitted. Lower block: the "
    )
    return (
        f"Sensitivity of R, m and c0 b of the thesis's fit, subject {subject}: one change at a "
        "time, compared with the unchanged row (line) and Table 3.2 (dashed). "
        f"{above if tried else 'The '}calibrated finger, with changes of the simulated frames and "
        "of their evaluation: noise, clipping, window, centering and relaxation change R by at "
        f"most {small:.1f} mm. A deeper press gives smaller R and c0 b and a larger m, as bone "
        "and stiffening concentrate the pressure; late detection of touch raises R and c0 b."
    )


def _sensitivity() -> Any:
    subject = sensitivity()["subject"]
    blocks = [each for each in (sensitivity()["finger"], sensitivity()["reading"][subject]) if each]
    count = sum(len(block) for block in blocks)
    made, axes = panels(WIDE, 0.8 + 0.21 * count, 1, len(NAMES), sharey=True)
    table_3_2 = printed(subject)
    for ax, name, head in zip(axes, NAMES, HEADS, strict=True):
        first = 0
        for block in blocks:
            _block(ax, block, name, first)
            first += len(block) + 1
        ax.axvline(getattr(table_3_2, name), color=ORANGE, linestyle="--", linewidth=1)
        ax.set_xlabel(head)
        ax.margins(x=0.28)
    names = [name for block in blocks for name in (*(each["lever"] for each in block), "")]
    axes[0].set_yticks(range(len(names) - 1), names[:-1], fontsize=7)
    axes[0].invert_yaxis()
    return made


def _block(ax: Any, block: list[dict[str, Any]], name: str, first: int) -> None:
    """Draw a value of the rows of a block, from the line `first` on; the first row is the plain."""
    plain = block[0][name]
    ax.plot([plain, plain], [first - 0.4, first + len(block) - 0.6], color=STEEL, linewidth=1)
    for place, each in enumerate(block, start=first):
        hollow = each.get("misfit", 0.0) >= MISSES
        ax.plot(each[name], place, "o", color=BLUE, mfc="none" if hollow else BLUE, markersize=4)
        ax.annotate(
            f"{each[name] if each[name] > ROUNDING else 0:.3g}",
            (each[name], place),
            xytext=(5, -2.5),
            textcoords="offset points",
            fontsize=6,
            color=INK,
        )


def _assumptions_caption() -> str:
    rows = sensitivity()["finger"]
    fitted = [row for row in rows if row["misfit"] < MISSES]
    ends = [
        f"{min(r[k] for r in fitted):.2g} to {max(r[k] for r in fitted):.2g}" for k in OF_FORCE[1:]
    ]
    return (
        f"Effect of assumptions, subject {sensitivity()['subject']}: fingers of the coarse mesh "
        "with modulus and exponent refitted to the force of Table 2.1, and the change relative to "
        "the first row. m and b are those of the line of stiffness against force, R is the result "
        "of the thesis's fit to frames up to 1.1 N. Fingers that reproduce the force of the "
        f"subject have b of {ends[0]} N/mm and R of {ends[1]} mm; with a misfit of {MISSES:g} or "
        "more the finger cannot reproduce that force."
    )


def _assumptions() -> dict[str, Any]:
    rows = sensitivity()["finger"]
    heads = ("assumption", "E in kPa", "exponent", "m in 1/mm", "b in N/mm", "R in mm", "misfit")
    cells = [
        [
            row["lever"],
            f"{row['modulus']:.3g}",
            f"{row['exponent']:.2f}",
            *(_changed(row[name], rows[0][name], first=not place) for name in OF_FORCE),
            f"{row['misfit']:.2g}",
        ]
        for place, row in enumerate(rows)
    ]
    return {"caption": _assumptions_caption(), "heading": heads, "rows": cells}


def _changed(value: float, plain: float, *, first: bool) -> str:
    return f"{value:.3g}" if first else f"{value:.3g} ({100 * (value / plain - 1):+.0f} %)"


def _sessions() -> dict[str, Any]:
    cells = [row for name in sensitivity()["force"] for row in ([name], *_rows(name))]
    heads = ("frames of", *HEADS, "squared error")
    return {"caption": SESSIONS, "heading": heads, "rows": cells}


def _rows(subject: str) -> list[list[str]]:
    table_3_2 = printed(subject)
    force = {each["lever"]: each for each in sensitivity()["force"][subject]}
    at_zero, early = (each for name, each in force.items() if name.startswith("relaxed force"))
    residuals = calibrated(subject).residuals
    rows = {
        "Table 3.2": (*(getattr(table_3_2, name) for name in NAMES), None),
        "its half-space, read": _fitted(force["Table 3.2 itself, with noise"]),
        "force of Table 2.1": _fitted(at_zero),
        "touched 0.3 mm before": _fitted(early),
        "calibrated finger": (
            *(residuals[f"array {name}"] for name in NAMES),
            sensitivity()["reading"][subject][0]["error"],
        ),
    }
    return [
        [
            kind,
            *(f"{value:.3g}" for value in row[:3]),
            "" if row[3] is None else f"{100 * row[3]:.1f} %",
        ]
        for kind, row in rows.items()
    ]


def _fitted(row: dict[str, Any]) -> tuple[float, ...]:
    return (*(row[name] for name in NAMES), row["error"])

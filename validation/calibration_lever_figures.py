"""Figures of suite `calibration`: what moves R, m and c0 b, and what two tables leave of them."""

from collections.abc import Iterator
from typing import Any

from fefinger.validation.calibration_report import calibrated, levers

from fefinger.calibration import pad
from fefinger.figures import INK, STEEL, WIDE, figure, style


BLUE, ORANGE = "#0072B2", "#D55E00"
NAMES = ("radius", "m", "c0_b")
HEADS = ("R in mm", "m in 1/mm", "c0 b in kPa/mm")
OF_FORCE = ("stiffness_m", "stiffness_b", "radius")
MISSES = 0.1
"""Misfit from which a finger no longer has the force of its subject: ten times that of the best."""


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and Figure: the levers, and the two tables."""
    with style():
        yield _caption(), _levers()
        if levers()["finger"]:
            yield _assumptions_caption(), _assumptions()
        yield _tables_caption(), _tables()


def _caption() -> str:
    subject, tried = levers()["subject"], levers()["finger"]
    read = levers()["reading"][subject]
    small = max(
        abs(row["radius"] - read[0]["radius"])
        for row in read
        if not row["lever"].startswith(("touch", "pressed"))
    )
    above = (
        "Upper block: fingers of the coarse mesh, pressed to 1.1 N, modulus and exponent fitted to "
        "the force of Table 2.1 again, hollow where they cannot have that force. Lower block: the "
    )
    return (
        f"What moves R, m and c0 b that the thesis's fit finds, subject {subject}: one lever at a "
        "time, beside the row as it is (line) and Table 3.2 (dashed). "
        f"{above if tried else 'The '}calibrated finger, and how its frames are made and read: "
        f"noise, clipping, window, centering and relaxation move R by {small:.1f} mm at most. The "
        "deeper the press, the smaller R and c0 b and the larger m, because bone and stiffening "
        "draw the pressure together; a touch that is found late raises R and c0 b together."
    )


def _levers() -> Any:
    subject = levers()["subject"]
    blocks = [each for each in (levers()["finger"], levers()["reading"][subject]) if each]
    count = sum(len(block) for block in blocks)
    made = figure(WIDE, 0.8 + 0.21 * count)
    axes = made.subplots(1, len(NAMES), sharey=True)
    printed = pad.printed(subject)
    for ax, name, head in zip(axes, NAMES, HEADS, strict=True):
        first = 0
        for block in blocks:
            _block(ax, block, name, first)
            first += len(block) + 1
        ax.axvline(getattr(printed, name), color=ORANGE, linestyle="--", linewidth=1)
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
            f"{each[name]:.3g}",
            (each[name], place),
            xytext=(5, -2.5),
            textcoords="offset points",
            fontsize=6,
            color=INK,
        )


def _assumptions_caption() -> str:
    rows = levers()["finger"]
    met = [row for row in rows if row["misfit"] < MISSES]
    ends = [f"{min(r[k] for r in met):.2g} to {max(r[k] for r in met):.2g}" for k in OF_FORCE[1:]]
    return (
        f"What each assumption would change, subject {levers()['subject']}: fingers of the coarse "
        "mesh whose modulus and exponent were fitted to the force of Table 2.1 again, with the "
        "change beside the first row. m and b are those of the line through stiffness against "
        "force, R what the thesis's fit finds in frames to 1.1 N. Those that have the force of "
        f"their subject show b from {ends[0]} N/mm and R from {ends[1]} mm; a misfit of "
        f"{MISSES:g} or more says that the finger cannot have that force."
    )


def _assumptions() -> Any:
    rows = levers()["finger"]
    made = figure(WIDE, 0.5 + 0.22 * (len(rows) + 1))
    axes = made.subplots()
    axes.axis("off")
    heads = ("", "E in kPa", "exponent", "m in 1/mm", "b in N/mm", "R in mm", "misfit")
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
    drawn = axes.table(cells, colLabels=heads, loc="center", edges="horizontal")
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(7.5)
    drawn.auto_set_column_width(range(len(heads)))
    drawn.scale(1, 1.15)
    return made


def _changed(value: float, plain: float, *, first: bool) -> str:
    return f"{value:.3g}" if first else f"{value:.3g} ({100 * (value / plain - 1):+.0f} %)"


def _tables_caption() -> str:
    return (
        "Tables 2.1 and 3.2 are of two sessions and do not describe one contact. The thesis's fit "
        "of frames to 2.3 N: of Table 3.2's own half-space with the noise of the array it returns "
        "the printed row. Of a contact that is Hertz's with the printed R and has the relaxed "
        "force of Table 2.1, touched where that line has no force or 0.3 mm before, it finds R, "
        "but another m and c0 b: that is what a finger with the force of Table 2.1 can show. Last "
        "the calibrated finger, on a press of 0.2 mm/s, whose tissue is not quite relaxed."
    )


def _tables() -> Any:
    subjects = list(levers()["force"])
    kinds = (
        "Table 3.2",
        "its half-space, read",
        "force of Table 2.1",
        "touched 0.3 mm before",
        "calibrated finger",
    )
    made = figure(WIDE, 0.5 + 0.22 * len(subjects) * len(kinds))
    axes = made.subplots()
    axes.axis("off")
    cells = [row for name in subjects for row in _rows(name, kinds)]
    drawn = axes.table(
        cells, colLabels=["", "", *HEADS, "squared error"], loc="center", edges="horizontal"
    )
    drawn.auto_set_font_size(False)
    drawn.set_fontsize(7.5)
    drawn.scale(1, 1.15)
    return made


def _rows(subject: str, kinds: tuple[str, ...]) -> list[list[str]]:
    printed = pad.printed(subject)
    force = {each["lever"]: each for each in levers()["force"][subject]}
    at_zero, early = (each for name, each in force.items() if name.startswith("relaxed force"))
    found = calibrated(subject).residuals
    rows = [
        (*(getattr(printed, name) for name in NAMES), None),
        *(
            (*(each[name] for name in NAMES), each["error"])
            for each in (force["Table 3.2 itself, with noise"], at_zero, early)
        ),
        (*(found[f"array {name}"] for name in NAMES), levers()["reading"][subject][0]["error"]),
    ]
    return [
        [
            subject if not i else "",
            kind,
            *(f"{value:.3g}" for value in row[:3]),
            "" if row[3] is None else f"{100 * row[3]:.1f} %",
        ]
        for i, (kind, row) in enumerate(zip(kinds, rows, strict=True))
    ]

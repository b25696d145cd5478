"""Write the outcome of validation suites: `validation.json` and a self-contained page.

The page lists the verdict of every case: pass, documented (fefinger agrees with the reference, the
published value does not), short (as expected, but off the target) or fail.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from fefinger.pages import page
from fefinger.support import atomic_write
from fefinger.support.text import entries, unit_suffix


VERDICTS = ("pass", "documented", "short", "fail")

Figures = Mapping[str, Sequence[tuple[str, Any]]]
"""Captions and matplotlib Figures by the name of the suite that drew them."""

Findings = Mapping[str, Mapping[str, Any]]
"""Findings by suite: `about`, `texts`, and `tables` of caption, heading and rows."""

SHORT = ("Missed targets", "short", "shortfall")
ERRATA = ("Differing published values", "documented", "erratum")
"""Title, verdict, and key of the sentence of a case that explains it."""

BESIDE = ("printed", "wanted")
"""Optional numbers of a case besides the expected one."""

NOTES = ("failure", "note", "erratum", "shortfall", "reason")
"""Optional sentences of a case."""

NEAREST = 3
"""Number of cases that are named for using most of their tolerance."""

COLUMN = 7.0
"""Inches: a wider figure takes the whole width of the page; others are set side by side."""


def save(
    record: dict[str, Any],
    folder: Path,
    figures: Figures,
    provenance: Mapping[str, Any],
    name: str = "validation",
    findings: Findings | None = None,
) -> None:
    """Write `validation.json` and `validation.html` (or of another `name`) into a folder.

    `record` is what `validation.suites.as_json` returns; `provenance` maps names to texts or to
    tables of texts.
    """
    texts = {
        f"{name}.html": html(
            record, figures, provenance, data=f"{name}.json", findings=findings or {}
        ),
        f"{name}.json": json.dumps(record | {"provenance": provenance}, separators=(",", ":"))
        + "\n",
    }
    atomic_write.write(folder, texts)


def html(
    record: dict[str, Any],
    figures: Figures,
    provenance: Mapping[str, Any],
    *,
    data: str = "",
    findings: Findings | None = None,
) -> str:
    """Return the page on `record`, with the figures of its suites; `data` is the file beside it."""
    suites = [
        _suite(suite, figures.get(suite["suite"], ()), (findings or {}).get(suite["suite"], {}))
        for suite in record["suites"]
    ]
    total = {key: sum(suite["counts"][key] for suite in suites) for key in VERDICTS}
    only = f": {suites[0]['name']}" if len(suites) == 1 else ""
    return page.render(
        "validation.html",
        title=f"Validation{only}",
        answer=_answer(total),
        verdicts=VERDICTS,
        total=total,
        suites=suites,
        provenance=list(entries(provenance)),
        data=data,
    )


def _answer(total: dict[str, int]) -> str:
    text = f"Of {sum(total.values())} comparisons, {total['pass']} pass."
    if total["documented"]:
        text += (
            f" In {total['documented']} more, fefinger is within the tolerance and the published "
            "value is not."
        )
    if total["short"]:
        miss = "misses its target" if total["short"] == 1 else "miss their targets"
        text += f" {total['short']} {miss}."
    return f"{text} {total['fail'] or 'None'} failed."


def _suite(
    suite: dict[str, Any], figures: Sequence[tuple[str, Any]], finding: Mapping[str, Any]
) -> dict[str, Any]:
    cases = suite["cases"]
    verdicts = [case["verdict"] for case in cases]
    return {
        "name": suite["suite"],
        "counts": {key: verdicts.count(key) for key in VERDICTS},
        "finding": finding,
        "why": [
            (title, list(_texts(cases, verdict, key).items()))
            for title, verdict, key in (SHORT, ERRATA)
        ],
        "nearest": _nearest(cases),
        "beside": [key for key in BESIDE if any(case.get(key) is not None for case in cases)],
        "rows": list(_rows(cases)),
        "figures": [_figure(text, drawn) for text, drawn in figures],
    }


def _texts(cases: Sequence[dict[str, Any]], verdict: str, key: str) -> dict[str, list[str]]:
    """Return why cases have a verdict other than pass, with their names."""
    names: dict[str, list[str]] = {}
    for case in cases:
        if case["verdict"] == verdict:
            names.setdefault(case.get(key, ""), []).append(case["name"])
    return names


def _nearest(cases: Sequence[dict[str, Any]]) -> list[tuple[int, str]]:
    """Share in % of its limit that each case uses, with its name, the largest first."""
    shares = [
        (round(100 * _used(case)), case["name"])
        for case in cases
        if case["verdict"] != "fail" and case["tolerance"] > 0 and math.isfinite(case["value"])
    ]
    return sorted(shares, key=lambda share: -share[0])[:NEAREST]


def _from_zero(case: Mapping[str, Any]) -> bool:
    """Whether a case expects a range from 0 on: of errors and counts, where 0 is no limit."""
    return case["tolerance"] > 0 and case["expected"] == case["tolerance"]


def _used(case: Mapping[str, Any]) -> float:
    """Deviation over the tolerance; in a range from 0 on, value over the upper limit."""
    if _from_zero(case):
        return float(case["value"]) / (2 * case["tolerance"])
    return float(abs(case["value"] - case["expected"]) / case["tolerance"])


def _figure(caption: str, drawn: Any) -> dict[str, Any]:
    wide = drawn.get_size_inches()[0] > COLUMN
    return {"caption": caption, "source": page.svg(drawn), "wide": wide}


def _rows(cases: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Give one row per case; a note that holds for several in a row follows the last of them."""
    for case, following in zip(cases, [*cases[1:], {}], strict=True):
        limit = case["tolerance"]
        notes = {key: case.get(key, "") for key in NOTES}
        beside = {key: case.get(key) for key in BESIDE}
        yield {
            "name": case["name"],
            "value": _number(case["value"], limit),
            "expected": _expected(case),
            "beside": {k: "" if value is None else f"{value:g}" for k, value in beside.items()},
            "unit": unit_suffix(case["unit"]),
            "source": case["source"],
            "verdict": case["verdict"],
        } | {key: "" if following.get(key) == note else note for key, note in notes.items()}


def _expected(case: Mapping[str, Any]) -> str:
    """Return the expected value with its tolerance, or the range from 0 on."""
    limit = case["tolerance"]
    if _from_zero(case):
        return f"0 to {2 * limit:.3g}"
    return f"{_number(case['expected'], limit)} ± {limit:.3g}"


def _number(value: float | None, tolerance: float) -> str:
    """Return a value with the digits that its tolerance resolves, at least three."""
    if value is None:
        return "none"
    if not math.isfinite(value) or not tolerance > 0:
        return f"{value:.6g}"
    digits = 1 - math.floor(math.log10(tolerance))
    if digits <= 6:
        enough = abs(value) >= 10.0 ** (2 - digits)
        return f"{value:.{max(digits, 0)}f}" if enough else f"{value:.3g}"
    return f"{value:.6g}" if abs(value) > tolerance else f"{value:.2g}"

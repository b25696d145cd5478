"""Index page of a folder of reports: suites, benchmarks and evidence.

`python -m fefinger.validation.index reports` writes `reports/index.html` from the files there;
with `--pages` it first writes the page of every suite anew from its JSON, without measuring.
"""

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from fefinger.validation import suites
from fefinger.validation.page import VERDICTS, save

from fefinger.pages import page


ABOUT = suites.ABOUT | {
    "calibrated": "Calibrated subjects: parameters, curves, parts of the stiffening, profiles.",
    "calibration_sensitivity": (
        "Effect of assumptions on R, m and c0 b of the fit to simulated frames."
    ),
    "rig-faults": "Calibrations of records with faults of a rig, before it was modeled and after.",
    "coverage": "By how many deviations calibrations of drawn fingers and rigs miss the truth.",
    "ridges": "Rates over scanned dots with ridges of the skin, and what they depend on.",
    "gratings": "Rates over moved gratings by period and speed, with and without ridges.",
    "grid-errors": "Errors of layered on a grid: bars, pins, gratings, a cylinder, a plate.",
    "grid-cost": "CPU time of layered on a grid, with and without friction and ridges.",
    "round-tip": "From the flat pad of a.h. to a finger with a round tip, step by step.",
    "contact-angle": "Effect of the angle of a plate on contact, asymmetry, strain and spikes.",
    "bench-condensed": "Speed and memory of building and stepping condensed fingers.",
    "bench-fem": "Speed and memory of assembly, factor and loads.",
    "bench-modal": "Speed of modes, harmonic answers and steps with inertia.",
    "bench-neural": "Speed of membranes and units.",
    "bench-recorded": "Speed of the units of recorded: whole series, and in a loop with a finger.",
    "bench-sliding": "Speed of sliding with and without friction: operator, steps, a scan.",
    "bench-tactile": "Speed and memory of a tactile finger: steps, many worlds, starts.",
    "bench-solid": "Speed and iterations of finite strain.",
    "bench-pressed": "Speed of tabulated finite strain: a table, a scene, a step.",
    "calibrated-means": "The finger calibrated on the mean curves of the subjects.",
    "evidence": "Presses, factors of stated errors and costs in one layout; the planner reads it.",
    "agreement": "Whether stated intervals of mechanics that answer one scene overlap.",
    "strain-types": "Errors of the strain at the end organs of each type of afferent.",
    "pressed-error": "Errors of tabulated finite strain against `solid`.",
    "held-out": "Stated errors against scenes that no rule was fitted to; suite tradeoff.",
    "human-presses": "Presses of the suite human: force, area and pressure of the default finger.",
    "press-mesh": "Error of a press by mesh, object and depth.",
    "elements": "Error and cost of the types of elements that were compared.",
    "modal": "What inertia changes, what modes leave out and cost; the planner reads it.",
    "lumped-force": "Force laws identified from presses of fingers; the planner reads it.",
    "small-strain-cost": "CPU time of linear and condensed.",
    "afferent-cost": "CPU time of end organs, spikes and fields, in whole answers.",
    "mesh-curves": "Error of the force of a press due to the mesh; calibration corrects for it.",
    "solid-cost": "CPU time of finite strain by mesh and depth.",
    "solid-force": "Force of every mechanics against finite strain, cause by cause.",
}
"""Content of a file by its name; other files describe themselves in their entry `about`."""


def html(folder: Path) -> str:
    """Return the page on the JSON files of a folder."""
    records = {path.stem: _read(path) for path in sorted(folder.glob("*.json"))}
    suites = [_suite(folder, name, record) for name, record in records.items() if _cases(record)]
    others = {name: record for name, record in records.items() if not _cases(record)}
    benches = [name for name in others if name.startswith("bench-")]
    studies = [name for name in others if (folder / f"{name}.html").exists()]
    rest = [name for name in others if name not in (*benches, *studies)]
    groups = [
        ("studies", "Studies and campaigns", "Parameter studies; each has a page.",
         studies),
        ("benchmarks", "Benchmarks", "Speed and memory, each against a baseline of the same run; "
         "fefinger bench repeats the measurements.", benches),
        ("evidence", "Evidence", "Measurements behind the stated errors and costs; each file "
         "names the command that made it.", rest),
    ]  # fmt: skip
    return page.render(
        "index.html",
        title="Reports",
        verdicts=VERDICTS,
        suites=suites,
        total={key: sum(suite["counts"][key] for suite in suites) for key in VERDICTS},
        groups=[
            {"key": key, "title": title, "text": text,
             "rows": [_row(folder, name, others[name]) for name in names]}
            for key, title, text, names in groups
        ],
    )  # fmt: skip


def write(folder: Path) -> Path:
    """Write `index.html` into the folder and return its path."""
    path = folder / "index.html"
    path.write_text(html(folder), encoding="utf-8")
    return path


def rewrite_pages(folder: Path) -> Iterator[Path]:
    """Write the page of every suite anew from its JSON file, and give its path."""
    for path in sorted(folder.glob("*.json")):
        record = _read(path)
        if _cases(record) and path.with_suffix(".html").exists():
            provenance = record.pop("provenance", {})
            save(
                record,
                folder,
                suites.figures(record),
                provenance,
                path.stem,
                suites.findings(record),
            )
            yield path.with_suffix(".html")


def _read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def _cases(record: Any) -> list[dict[str, Any]]:
    """Return the cases of a record of `fefinger validate`, none of another file."""
    if not isinstance(record, dict) or not isinstance(record.get("suites"), list):
        return []
    return [case for suite in record["suites"] for case in suite["cases"]]


def _suite(folder: Path, name: str, record: dict[str, Any]) -> dict[str, Any]:
    verdicts = [case["verdict"] for case in _cases(record)]
    row = _row(folder, name, record.get("provenance", {}) | record)
    return row | {"counts": {key: verdicts.count(key) for key in VERDICTS}, "cases": len(verdicts)}


def _row(folder: Path, name: str, record: Any) -> dict[str, Any]:
    """Return the cells of one record: its files, and when and from which code it was made.

    A record whose numbers are in a file of their own names it in its entry `data`.
    """
    entries = record if isinstance(record, dict) else {}
    made = entries | entries.get("provenance", {})
    page = f"{name}.html" if (folder / f"{name}.html").exists() else ""
    record_file = f"{name}.json"
    return {
        "name": name,
        "about": ABOUT.get(name) or str(entries.get("about", "")),
        "page": page,
        "data": list(dict.fromkeys([str(entries.get("data", record_file)), record_file])),
        "date": str(made.get("date", ""))[:10],
        "commit": str(made.get("commit", "")),
        "command": str(made.get("command", "")),
    }


def main(arguments: list[str]) -> int:
    """Write the index of the folder named, and with --pages the suites' pages before it."""
    folders = [Path(word) for word in arguments if word != "--pages"]
    if len(folders) != 1 or not folders[0].is_dir():
        print("index: expected one folder of reports, as in `... reports`", file=sys.stderr)
        return 2
    if "--pages" in arguments:
        for path in rewrite_pages(folders[0]):
            print(path)
    print(write(folders[0]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

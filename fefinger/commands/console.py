"""Console output of the commands: progress bar, tables of text, and records for --json."""

import math
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from fefinger.support.text import brief, percent, strict_json, table, unit_suffix


if TYPE_CHECKING:
    from fefinger.geometry.finger_mesh import FingerMesh
    from fefinger.neural.trains import SpikeTrains
    from fefinger.result import Result
    from fefinger.results.records import Lateral
    from fefinger.studies.study import Study
    from fefinger.support.cache import Entry
    from fefinger.support.progress import Progress


@contextmanager
def progress() -> "Iterator[Progress | None]":
    """Yield a progress callback that draws bars on standard error; None outside a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress as Bars
    from rich.progress import TaskID

    with Bars(console=Console(stderr=True), transient=True) as bars:
        tasks: dict[str, TaskID] = {}

        def report(stage: str, fraction: float) -> None:
            if stage not in tasks:
                tasks[stage] = bars.add_task(stage, total=1.0)
            bars.update(tasks[stage], completed=fraction)

        yield report


def remark(line: str) -> None:
    """Print a line on standard error if that is a terminal."""
    if sys.stderr.isatty():
        click.echo(line, err=True)


def print_answer(record: Any, text: str, *, as_json: bool) -> None:
    """Print the answer of a command: its record as JSON, null where not finite, or else a text."""
    click.echo(strict_json(record) if as_json else text)


def run_record(result: "Result", seconds: dict[str, float], files: list[str]) -> dict[str, Any]:
    """JSON record of `fefinger run`; area and centroid are those at the peak."""
    force, area, centroid = result.force, result.contact_area, result.centroid
    peak = result.peak
    return {
        "status": result.status,
        "mechanics": result.plan.mechanics,
        "peak_force_N": None if force is None else float(force.max()),
        "final_force_N": None if force is None else float(force[-1]),
        "contact_area_mm2": None if area is None else float(area[peak]),
        "centroid_mm": None if centroid is None else [float(x) for x in centroid[peak]],
        **({} if result.lateral is None else slid_record(result.lateral)),
        **({} if result.spikes is None else fired_record(result.spikes)),
        "seconds": seconds,
        "files": files,
    }


def slid_record(lateral: "Lateral") -> dict[str, Any]:
    """Largest lateral force, and the outcome of friction in words."""
    peak = max(math.hypot(*force) for force in lateral.force.tolist())
    return {"peak_lateral_force_N": peak, "friction": lateral.outcome or None}


def fired_record(trains: "SpikeTrains") -> dict[str, Any]:
    """Family of the afferents, spikes of each type, and mean rate in Hz of its units.

    Rates are over the time in which spikes count.
    """
    counts = dict.fromkeys(trains.types, 0)
    for kind, times in zip(trains.types, trains.times, strict=True):
        counts[kind] += len(times)
    span = trains.t_stop - trains.t_start
    rates = {kind: n / span / trains.types.count(kind) for kind, n in counts.items()}
    return {"afferents": trains.family, "spikes": counts, "rates_Hz": rates}


def run_summary(
    result: "Result", seconds: dict[str, float], files: list[str], *, verbose: bool = False
) -> str:
    """Summary of a result as text of a dozen lines; all that is known of it if `verbose`."""
    from fefinger.results import key_numbers

    rows = key_numbers.rows(result)
    saving = f" (saved in {seconds['save']:.1f} s)" if "save" in seconds else ""
    spent = f"{sum(result.seconds.values()):.1f} s{saving}"
    rows.append(("computed", f"by {result.plan.on}, in {spent}"))
    if result.plan.overridden:
        reasons = "; ".join(dict.fromkeys(refusal.reason for refusal in result.plan.overridden))
        rows.append(("WARNING", f"chosen by name despite: {reasons}"))
    if verbose:
        return "\n".join([table(rows), "", table(_details(result, seconds, files))])
    report = [file for file in files if file.endswith(".html")]
    notes = f"{len(result.notes)} notes"
    where = f"{report[0]} ({notes})" if report else f"-o DIR writes it, -v prints its {notes}"
    rows.append(("report", where))
    return f"{result.scene.name}\n{table(rows)}"


def _details(
    result: "Result", seconds: dict[str, float], files: list[str]
) -> list[tuple[str, str]]:
    """Rows on how a result was reached: convergence, choice, trust, stages, notes, files."""
    rows = [("status", result.status), ("mechanics", result.plan.sentence)]
    if result.centroid is not None:
        x, y = result.centroid[result.peak]
        rows.append(("centroid", f"x {x:.3f} mm, y {round(y, 3) + 0.0:.3f} mm at the peak"))
    if result.plan.trust:
        rows.append(("trust", f"{result.plan.trust} Source: {result.plan.chosen.evidence}."))
    stages = ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items())
    rows.append(("seconds", stages))
    return [*rows, *(("note", note) for note in result.notes), *(("file", file) for file in files)]


def mesh_record(mesh: "FingerMesh") -> dict[str, Any]:
    """JSON record of `fefinger mesh`."""
    return {
        "name": mesh.name,
        "half": mesh.half,
        "points": len(mesh.points),
        "tetrahedra": len(mesh.cells),
        "recipe": dict(mesh.recipe),
        "quality": dict(mesh.quality),
    }


def mesh_summary(mesh: "FingerMesh") -> str:
    """Describe a mesh in a few lines: finger, size and quality; `mesh_record` has all figures."""
    recipe, quality = mesh.recipe, mesh.quality
    made = f"shaped from {quality['template']}" if "template" in quality else "made by the mesher"
    shape = recipe["surface"] or f"pad radius {recipe['pad_radius']:g} mm"
    volumes = ", ".join(f"{name} {value:.0f}" for name, value in quality["volumes"].items())
    off = max(abs(error) for error in quality["volume_errors"].values())
    angles = f"{quality['min_dihedral_deg']:.0f} to {quality['max_dihedral_deg']:.0f} degrees"
    along, across = quality["radii"]
    lines = [
        ("mesh", f"{mesh.name}, {'half a' if mesh.half else 'the whole'} finger, {made}"),
        ("finger", f"{recipe['width']:g} mm wide, {recipe['thickness']:g} mm thick, {shape}"),
        ("size", f"{len(mesh.points)} points, {len(mesh.cells)} tetrahedra"),
        (
            "pad",
            f"edges of {quality['pad_edge_mean']:.2g} mm (at most {quality['pad_edge_max']:.2g}), "
            f"radii {along:.3g} mm along and {across:.3g} mm across the finger",
        ),
        (
            "soft tissue",
            f"{quality['pulp_thickness']:.2g} mm from first touch at 30 degrees to bone",
        ),
        ("volumes", f"{volumes} mm³, within {percent(off)} of the smooth surfaces"),
        ("quality", f"dihedral angles of {angles}; all checks passed"),
        *(("note", note) for note in quality.get("notes", ())),
    ]
    return table(lines)


def spikes_record(trains: "SpikeTrains", files: list[str]) -> dict[str, Any]:
    """JSON record of `fefinger spikes`; null where a unit has too few spikes for a value."""
    span = trains.t_stop - trains.t_start
    units = [
        {
            "name": trains.names[i],
            "type": trains.types[i],
            "spikes": len(times),
            "mean_rate_Hz": len(times) / span,
            "peak_rate_Hz": float(1.0 / (times[1:] - times[:-1]).min()) if len(times) > 1 else None,
            "first_spike_s": float(times[0]) if len(times) else None,
            "block_s": float(trains.block_seconds[i]),
        }
        for i, times in enumerate(trains.times)
    ]
    return {"units": units, "notes": list(trains.notes), "files": files}


def spikes_summary(record: dict[str, Any]) -> str:
    """Format the record of `spikes_record`: a table of units, then notes and files."""
    keys = ("spikes", "mean_rate_Hz", "peak_rate_Hz", "first_spike_s")
    rows = [
        (unit["name"], unit["type"], *("" if unit[k] is None else _short(unit[k]) for k in keys))
        for unit in record["units"]
    ]
    below = [(kind, each) for kind in ("note", "file") for each in record[f"{kind}s"]]
    text = table(rows, ("unit", "type", "spikes", "mean Hz", "peak Hz", "first s"))
    return f"{text}\n{table(below)}" if below else text


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def study_record(study: "Study", files: list[str]) -> dict[str, Any]:
    """JSON record of `fefinger study`."""
    return {
        "scenes": study.scenes,
        "reused": study.reused,
        "failed": [{"scene": values, "error": error} for values, error in study.failures],
        "over": list(study.over),
        "chosen": study.about.get("chosen", ""),
        "rows": list(study.rows),
        "files": files,
    }


STUDY = {
    **{"at": "at", "force_N": "force/N", "force_rel_error": "error", "depth_mm": "depth/mm"},
    **{"contact_area_mm2": "area/mm²", "highest_pressure_1mm2_kPa": "kPa", "spikes": "spikes"},
    **{"shift_distal_mm": "shift/mm", "asymmetry": "asym.", "ellipticity": "ellip."},
    "stiffness_N_per_mm": "N/mm",
}
"""Columns of a study that a terminal shows, with short headings."""


def study_summary(record: dict[str, Any]) -> str:
    """Format the record of `study_record`: main columns, failed scenes, notes and files."""
    from fefinger.studies.grid import remarks

    available = {name for row in record["rows"] for name in row}
    shown = [*record["over"], *(name for name in STUDY if name in available)]
    finished = [row for row in record["rows"] if row["status"] == "done"]
    rows = [["" if row.get(n) is None else _cell(n, row[n]) for n in shown] for row in finished]
    notes = [record["chosen"], *remarks(record["rows"], record["over"])]
    below = [
        *(("failed", f"{_at(each['scene'])}: {brief(each['error'])}") for each in record["failed"]),
        *(("note", note) for note in notes if note),
        *(("file", file) for file in record["files"]),
    ]
    done = record["scenes"] - len(record["failed"])
    used = dict.fromkeys(f"{row['mechanics']} {row.get('mesh') or ''}".strip() for row in finished)
    by = f" by {', '.join(used)}" if used else ""
    total = f"{done} of {record['scenes']} scenes{by}, {record['reused']} of them reused"
    short = [STUDY.get(name) or _heading(name, record["over"]) for name in shown]
    return "\n".join([table(rows, short), total, *([table(below)] if below else [])])


def _cell(name: str, value: Any) -> str:
    return percent(value) if name == "force_rel_error" else _short(value)


def _heading(name: str, names: list[str]) -> str:
    """Return a short heading of a column of the grid: without its table, if the others differ."""
    from fefinger.scene.field_units import split

    last, unit = split(name.rpartition(".")[2])
    alone = sum(other.rpartition(".")[2] == name.rpartition(".")[2] for other in names) == 1
    if not alone:
        last, unit = split(name)
    return f"{last}/{unit}" if unit else last


def _at(scene: dict[str, Any]) -> str:
    return ", ".join(f"{field} = {value}" for field, value in scene.items())


def validation_summary(record: dict[str, Any]) -> str:
    """Format the outcome of validation suites, one line per case."""
    rows = [
        (
            suite["suite"],
            case["name"],
            "none" if case["failure"] else f"{case['value']:.6g}",
            f"{case['expected']:.6g} +- {case['tolerance']:.3g} {unit_suffix(case['unit'])}",
            " ".join(filter(None, (case["verdict"], case["failure"]))),
        )
        for suite in record["suites"]
        for case in suite["cases"]
    ]
    verdicts = [case["verdict"] for suite in record["suites"] for case in suite["cases"]]
    counts = ((verdicts.count(name), meaning) for name, meaning in VERDICTS.items())
    total = ", ".join(f"{count} {meaning}" for count, meaning in counts if count)
    return f"{table(rows, ('suite', 'case', 'value', 'expected', 'verdict'))}\n{total}"


VERDICTS = {
    "pass": "pass",
    "documented": "documented (the published number is wrong, for a documented reason)",
    "short": "short (within its known error, but not within the wanted one)",
    "fail": "FAIL",
}
"""Verdicts of a validation with their meaning."""


def bench_summary(record: dict[str, Any]) -> str:
    """Format the figures of a benchmark, one line each."""
    rows = []
    for figure in record["figures"]:
        beside = ((figure["baseline"], ".4g"), (figure["ratio"], ".3g"))
        texts = ("" if value is None else f"{value:{digits}}" for value, digits in beside)
        rows.append((figure["name"], f"{figure['value']:.4g} {figure['unit']}", *texts))
    return table(rows, ("figure", "value", "baseline", "ratio"))


def cache_record(entry: "Entry") -> dict[str, Any]:
    """JSON record of one entry of the cache."""
    from datetime import UTC, datetime

    return {
        "kind": entry.kind,
        "what": entry.what,
        "MB": round(entry.size / 1e6, 1),
        "used": datetime.fromtimestamp(entry.used, UTC).isoformat(timespec="seconds"),
        "paths": [str(entry.path)],
    }


def cache_summary(record: dict[str, Any]) -> str:
    """Format the entries of the cache and what was removed."""
    rows = [
        (entry["kind"], f"{entry['MB']:.1f}", entry["used"][:16], entry["what"])
        for entry in record["entries"]
    ]
    total = sum(entry["MB"] for entry in record["entries"])
    lines = [f"{record['folder']}: {len(rows)} entries, {total:.0f} MB"]
    if record["removed"]:
        freed = sum(entry["MB"] for entry in record["removed"])
        lines.append(f"{len(record['removed'])} removed, {freed:.0f} MB")
    if rows:
        lines.append(table(rows, ("kind", "MB", "last used", "what")))
    return "\n".join(lines)

"""Table and figures of the suite `fem`: other programs and elements, pressures, histories."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from fefinger.validation.fem import element_kinds, hertz, history, solid
from fefinger.validation.fem import exact as fem_exact
from fefinger.validation.panels import panel, panels

from fefinger.mechanics.evidence.presses import read
from fefinger.view.figures import INK, STEEL


WIDE = 6.2  # inches; two stand side by side
COLORS = ("#D55E00", "#E69F00", "#009E73", "#56B4E9", "#0072B2", "#AA4499", STEEL)
DRAWN = (
    *("sphere, a / R = 0.3", "cone", "ellipse", "bonded layer, a = h"),
    *("bonded layer, a = h, nu 0.5", "sliding layer, a = h"),
)
COLUMNS = ("program", "nodes", "force %", "peak %", "pressure RMS %", "CPU time / s")


def figures() -> Iterator[tuple[str, Any]]:
    """Yield caption and matplotlib Figure."""
    yield (
        "Elements on the same meshes: error of force and of strain against the CPU seconds of "
        "assembly, factor, loads and contact (reports/elements.json). P1 at nu = 0.4999 is "
        "beyond the axis. Right: skin on softer tissue, where one continuous pressure smears "
        "what the pressure per tissue keeps.",
        kinds(measured()),
    )
    yield "Hertz pressure at nu = 0.49 on two meshes, at every vertex, over the peak.", _hertz()
    yield (
        "Pressure at every vertex (dots) beside the exact contact (line), over the exact "
        "largest; for the ellipse against the distance in its own axes.",
        _profiles(),
    )
    yield (
        "A bonded viscoelastic layer: force of the finite elements (line) and of Ting's theory "
        "on the exact layer (dots). Where the line is at zero, the indenter has left the pad.",
        _histories(),
    )
    yield (
        "Finite strain. Left: unit cubes of 100 kPa squeezed to half between frictionless "
        "plates, nu = 0.49, finite elements (dots) on the closed form (lines). Right: the "
        "relaxing hemisphere (radius 14 mm, 60 mm/s to 1.5 mm); squares: FEBio 4.11.",
        _finite_strain(),
    )


def measured() -> list[dict[str, Any]]:
    """Return the rows of the report on kinds of elements."""
    return list(read(element_kinds.REPORT)["rows"])


def finding() -> dict[str, Any]:
    """Return the table of Hertz contact by our element and by other programs."""
    caption = (
        "Hertz contact: fefinger (reports/elements.json) beside other programs, each in its own "
        "mesh of tetrahedra and measured on two cores. Errors of force, largest pressure and "
        "pressure over the true disk; FEBio's RMS is the scatter about its own fit."
    )
    return {"tables": [{"caption": caption, "heading": COLUMNS, "rows": beside(measured())}]}


def beside(rows: list[dict[str, Any]]) -> list[list[str]]:
    """Return the rows of the table, those of a Poisson's ratio under its heading."""
    ours = [
        Peer(
            "fefinger",
            row["nodes"],
            row["poisson"],
            row["force_%"],
            row["peak_%"],
            row["pressure_%"],
            row["cpu_s"],
        )
        for row in rows
        if row["case"] == "Hertz" and row["element"] == element_kinds.OURS.name
    ]
    lines = []
    for poisson in sorted({one.poisson for one in ours}):
        lines.append([f"Poisson's ratio {poisson:g}"])
        lines += [
            [
                one.program,
                f"{one.nodes:,}",
                f"{one.force:+.2f}",
                f"{one.peak:+.2f}",
                f"{one.rms:.1f}",
                _seconds(one.cpu_s),
            ]
            for one in (*ours, *PEERS)
            if one.poisson == poisson
        ]
    return lines


def _seconds(value: float) -> str:
    if np.isnan(value):
        return ""
    return f"{value:.2g}" if value < 1 else f"{value:.0f}"


def kinds(rows: list[dict[str, Any]]) -> Any:
    """Draw errors of force and strain against CPU seconds, one line per element."""
    drawn, axes = panels(WIDE, 5.4, 2, 3, sharex="col", sharey="row")
    compared = (("Hertz", 0.3), ("Hertz", 0.4999), ("stack", 0.49))
    for column, (case, poisson) in zip(axes.T, compared, strict=True):
        for kind, color in reversed([*zip(element_kinds.KINDS, COLORS, strict=True)]):
            chosen = [
                row
                for row in rows
                if (row["case"], row["poisson"], row["element"]) == (case, poisson, kind.name)
            ]
            seconds = [row["cpu_s"] for row in chosen]
            for axis, key in zip(column, ("force_%", "strain_%"), strict=True):
                error = np.abs([row[key] for row in chosen])
                axis.loglog(seconds, error, "o-", ms=3, color=color, label=kind.name)
                axis.tick_params(which="minor", length=0)
        column[0].set_title(f"{case}, nu {poisson:g}" if case == "Hertz" else "skin on soft tissue")
        column[1].set_xlabel("CPU time / s")
    axes[0, 0].set(ylabel="force error / %", ylim=(0.01, 50))
    axes[1, 0].set(ylabel="strain error / %", ylim=(0.2, 40))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper center", ncols=3)
    return drawn


def _hertz() -> Any:
    drawn, axis = panel(WIDE, 3.4, xlabel="r / a", ylabel="pressure / peak")
    truth = hertz.hertz(0.49)
    r = np.linspace(0, 1.3, 400)
    axis.plot(r, truth.pressure(r) / truth.peak_pressure, color=STEEL, label="Hertz")
    for level, color in ((0, COLORS[1]), (1, COLORS[0])):
        body = hertz.body(0.49, level)
        places = body.space.points[body.patch.vertices]
        pressure = body.pressed(truth.depth).pressure / truth.peak_pressure
        label = f"{body.space.n_nodes} nodes"
        axis.plot(np.hypot(*places.T[:2]), pressure, "o", ms=3, color=color, label=label)
    axis.legend()
    return drawn


def _profiles() -> Any:
    drawn, axes = panels(WIDE, 4.0, 2, len(DRAWN) // 2, sharey=True, sharex=True)
    for axis, name in zip(axes.flat, DRAWN, strict=True):
        solution = fem_exact.solved(name)
        distance = np.hypot(*solution.places.T)
        if name == "ellipse":
            distance = np.hypot(*(solution.places / fem_exact.ellipse().exact.axes).T)
        finite = np.isfinite(solution.exact)
        order = np.argsort(distance[finite])
        scale = solution.exact[finite].max()
        axis.plot(
            distance[finite][order],
            solution.exact[finite][order] / scale,
            color=STEEL,
            label="exact",
        )
        axis.plot(distance, solution.pressure / scale, "o", ms=2, color=COLORS[0])
        axis.set_title(name)
    for axis in axes[-1]:
        axis.set_xlabel("r / a")
    for axis in axes[:, 0]:
        axis.set(ylabel="pressure / exact largest", ylim=(-0.05, 1.4))
    return drawn


def _histories() -> Any:
    names = history.UNLOADED
    drawn, axes = panels(WIDE, 2.8, 1, len(names), sharey=True)
    for axis, name in zip(axes, names, strict=True):
        time, computed, exact = history.cycle(name, history.STEPS)
        axis.plot(time[::25], exact[::25], "o", ms=3, color=COLORS[0], label="Ting")
        axis.plot(time, computed, color=INK, lw=1.2, label="finite elements")
        axis.set_title(name)
        axis.set_xlabel("time / s")
    axes[0].set_ylabel("force / mN")
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside upper right", ncols=2)
    return drawn


def _finite_strain() -> Any:
    drawn = solid.drawn()
    drawing, (left, right) = panels(WIDE, 2.8, 1, 2)
    for color, (name, (depth, computed, exact)) in zip(
        COLORS, drawn["cubes"].items(), strict=False
    ):
        left.plot(100 * depth, exact, color=color, label=name)
        left.plot(100 * depth, computed, "o", color=color, markersize=3)
    left.set(xlabel="compression / %", ylabel="nominal pressure / kPa")
    left.legend()
    right.semilogx(np.maximum(drawn["time"], 1e-3), drawn["force"], color=INK)
    right.plot([0.025, 5.025], [1.11, 0.432], "s", color=STEEL)
    right.set(xlabel="time / s", ylabel="force / N")
    return drawing


class Peer(NamedTuple):
    """One run: errors in %, and CPU seconds, NaN where not measured."""

    program: str
    nodes: int
    poisson: float
    force: float
    peak: float
    rms: float
    cpu_s: float


NAN = float("nan")
PEERS = (
    Peer("scikit-fem P1, active set", 13_000, 0.3, 1.6, 4.5, 4.1, 22.7),
    Peer("scikit-fem P1, active set", 39_000, 0.3, 0.7, 2.8, 3.1, 180),
    Peer("FElupe 11.3 P1, penalty", 13_000, 0.3, 1.5, 4.3, 4.0, 23),
    Peer("FElupe 11.3 P1, penalty", 39_000, 0.3, 0.7, 2.7, 3.0, 174),
    Peer("EasyFEA 7.1 P1, penalty", 13_000, 0.3, 0.65, 1.2, 2.1, 28.9),
    Peer("SfePy 2026.3 P1, penalty", 13_000, 0.3, 0.65, 1.2, 2.1, 29.3),
    Peer("CalculiX 2.20 P1", 13_000, 0.3, 0.65, 1.2, 2.0, 54),
    Peer("GetFEM 5.4 P1, augmented", 13_000, 0.3, 1.6, 4.5, 4.6, 29),
    Peer("NGSolve P2, 1.4k vertices", 1_400, 0.3, -1.25, -1.8, 4.1, 37),
    Peer("any P1", 13_000, 0.49, 11.0, 69.0, 33.0, NAN),
    Peer("FElupe MINI", 3_400, 0.49, 2.8, 7.1, 5.0, 24),
    Peer("NGSolve P2, 1.4k vertices", 1_400, 0.49, -1.0, -1.8, 3.9, 37),
    Peer("FEBio 4.11 tet10, finite strain", 8_400, 0.49, -0.22, -1.3, 5.9, 27),
    Peer("FEBio 4.11 tet10, finite strain", 20_400, 0.49, -0.16, -1.4, 5.5, 210),
)
"""The finest runs of each program for the same Hertz contact, on two cores with one thread: a / R =
0.0015, the displacement of the half-space prescribed around tetrahedra, a rigid frictionless plate;
pressure is nodal reaction over tributary area, RMS over the true disk. The scatter of FEBio's
pressure is about its own fit."""

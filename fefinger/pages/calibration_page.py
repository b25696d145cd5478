"""Page of a calibration as one HTML file with its pictures: `write(calibration, path)`."""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.calibration.record import FILE, LIMIT, Calibration, PressFit
from fefinger.pages import page
from fefinger.support.arrays import Array
from fefinger.view import figures


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

RECORD, MODEL, MARK = figures.COLORS["SAI"], figures.INK, figures.COLORS["FAI"]
LAGS = 40
"""Averages over which the autocorrelation of a residual is drawn."""

SHOWN = (
    "Averages of samples, about touch and the ramp (left) and over the hold (middle). The residual "
    "is model less record; of it, the dark band holds 95 % if the noise of force and position is "
    "all, and the pale band if the model is off as far as the fit takes it to be. Vertical lines "
    "mark what is wrong with the record. The autocorrelation is that of the residual over the "
    "noise, between averages; of white noise, 95 % lies between the dashed lines, and what sticks "
    "out is not noise but rig or model."
)
PREDICTED = "It was not fitted: the model is the finger of the fit under the motion of the record."


def write(found: Calibration, path: str | PathLike[str]) -> None:
    """Write the page of a calibration to the HTML file `path`."""
    html = page.render(
        "study.html",
        made_by="fefinger calibrate",
        title=f"Calibration of {found.target}",
        data=(FILE,),
        answer=found.status,
        notes=found.findings,
        lines=[f"{name}: {value:g} mm" for name, value in _lengths(found)],
        parts=list(_parts(found)),
    )
    Path(path).write_text(html, encoding="utf-8")


def _lengths(found: Calibration) -> Iterator[tuple[str, float]]:
    for name in ("width", "thickness", "pad_radius"):
        if found.finger.get(name):
            yield name, found.finger[name]


def _parts(found: Calibration) -> Iterator[dict[str, object]]:
    """Yield the sections: parameters, presses, and what the record does not tell."""
    heading = ("", "value", "standard deviation", "95 % interval", "unit", "prior")
    rows = [
        (
            each.name,
            f"{each.value:.4g}",
            f"{each.sd:.2g}",
            f"{each.interval[0]:.3g} to {each.interval[1]:.3g}",
            each.unit,
            each.source,
        )
        for each in found.parameters
    ]
    yield {"title": "Parameters", "texts": (), "table": {"heading": heading, "rows": rows}}
    with figures.style():
        for press in found.presses:
            how = "held out" if press.held_out else "fitted"
            texts = (summary(press), PREDICTED if press.held_out else SHOWN)
            picture = page.svg(residuals(press))
            yield {"title": f"{press.name}: {how}", "texts": texts, "picture": picture}
    if found.unidentified:
        yield {"title": "Not identified", "texts": (), "bullets": found.unidentified}


def summary(press: PressFit) -> str:
    """State the misfit of the model of a press in a sentence with units."""
    off = np.subtract(press.model, press.force)
    force = np.array(press.force)
    rms, share = float(np.sqrt(np.mean(off**2))), float(off.var() / force.var())
    text = f"Residual: {1e3 * rms:.3g} mN (root mean square), {100 * share:.2g} % of the variance"
    if press.noise:
        noise, first = float(np.median(press.noise)), autocorrelation(press)[1]
        text += f"; noise of an average: {1e3 * noise:.2g} mN; autocorrelation: {first:.2f}"
    return text + "."


def autocorrelation(press: PressFit) -> Array:
    """Return the autocorrelation (LAGS + 1,) of a residual over its noise, from lag 0 on."""
    off = np.subtract(press.model, press.force) / np.array(press.noise or 1.0)
    off = off - off.mean()
    count = min(LAGS, len(off) - 1)
    products = [float(off[: len(off) - lag] @ off[lag:]) for lag in range(count + 1)]
    return np.array(products) / max(products[0], 1e-300)


def residuals(press: PressFit) -> "Figure":
    """Return a figure of a press: force, and residual against time and depth, with its noise."""
    drawn = figures.figure(figures.WIDE, 5.2)
    above, below = drawn.subplots(2, 3)
    time, depth = np.array(press.time), np.array(press.depth)
    touch = float(time[np.argmax(depth > 0)])
    deepest = float(time[np.argmax(depth >= depth.max() - 0.01 * np.ptp(depth))])
    ramp = max(deepest - touch, 1e-6)
    before = 0.2  # part of the ramp's time that is drawn before touch
    spans = ((touch - before * ramp, deepest + ramp), (float(time[0]), float(time[-1])))
    for column, (begin, end) in enumerate(spans):
        inside = (time >= begin) & (time <= end)
        scale, unit = (1e3, "ms") if end - begin < figures.SHORT else (1.0, "s")
        since = scale * (time[inside] - touch)
        _force(above[column], since, press, inside)
        _off(below[column], since, press, inside)
        for at, name in press.marks:
            if begin <= at <= end:
                _mark(below[column], scale * (at - touch), name)
        below[column].set_xlabel(f"time since touch / {unit}")
    above[0].legend()
    _autocorrelation(above[2], press)
    touching = np.flatnonzero(depth > 0)
    order = touching[np.argsort(depth[touching], kind="stable")]
    _off(below[2], depth[order], press, order)
    below[2].set_xlabel("depth / mm")
    if press.noise:
        below[0].legend()
    return drawn


def _force(axes: "Axes", at: Array, press: PressFit, inside: "NDArray[Any]") -> None:
    axes.plot(at, np.array(press.force)[inside], ".", markersize=3, color=RECORD, label="record")
    axes.plot(at, np.array(press.model)[inside], color=MODEL, linewidth=1, label="model")
    axes.set_ylabel("force / N")


def _off(axes: "Axes", at: Array, press: PressFit, which: "NDArray[Any]") -> None:
    """Draw a residual in mN over the bands of the noise and the errors of the model."""
    off = 1e3 * np.subtract(press.model, press.force)[which]
    bands = (press.spread, "#dbe9f4", "noise and model"), (press.noise, "#9cc3e0", "noise")
    for sds, color, label in bands:
        if sds:
            limit = 1e3 * LIMIT * np.array(sds)[which]
            axes.fill_between(at, -limit, limit, color=color, linewidth=0, label=label)
    axes.plot(at, off, ".", markersize=3, color=RECORD)
    axes.axhline(0.0, color=MODEL, linewidth=0.8)
    axes.set_ylabel("residual / mN")


def _mark(axes: "Axes", at: float, name: str) -> None:
    axes.axvline(at, color=MARK, linewidth=1)
    axes.annotate(
        name,
        (at, 1.0),
        xycoords=("data", "axes fraction"),
        xytext=(2, -2),
        textcoords="offset points",
        rotation=90,
        va="top",
        fontsize=7,
        color=MARK,
    )


def _autocorrelation(axes: "Axes", press: PressFit) -> None:
    found = autocorrelation(press)
    axes.bar(np.arange(len(found)), found, color=RECORD, width=0.6)
    limit = LIMIT / np.sqrt(len(press.time))
    for each in (-limit, limit):
        axes.axhline(each, color=MODEL, linestyle="--", linewidth=0.8)
    axes.set(xlabel="lag / averages", ylabel="autocorrelation of the residual")

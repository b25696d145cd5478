"""The report on a Result as one HTML page with its pictures: `write(result, path)`.

What the scene did not ask for has no section.
"""

from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger import view
from fefinger.geometry.finger_mesh import BONE
from fefinger.neural.trains import FEW
from fefinger.pages import page
from fefinger.results import key_numbers
from fefinger.results.pressure import highest
from fefinger.results.records import Harmonic
from fefinger.results.result_record import ResultRecord
from fefinger.support.atomic_write import temporary_folder
from fefinger.support.registry import AFFERENTS
from fefinger.support.text import entries
from fefinger.view import (
    figures,
    frames,
    pictures,
    quantities,
    renderer,
    section_figure,
    spatial_figures,
    spectrum_figure,
)


if TYPE_CHECKING:
    from matplotlib.figure import Figure

Part = dict[str, object]
"""A section of the report: key, title, text, picture, and perhaps more `pictures`."""

STANDING = (
    "One touch: no history of earlier touches, no blood flow, no temperature, no active muscle."
)
"""Limits of every mechanics, listed after the notes of the result."""

PLAIN = "No ridges and no papillae: the skin is smooth, and an end organ is a point in it."
RIDGED = "No papillae: an end organ is a point in the skin."
"""Limits of skin without and with ridges."""

RUBS = "No sweat: friction does not depend on time, speed or the pressure of fluid."
SMOOTH = "No sweat and no friction: the contact carries pressure only."
"""Limits of contacts with and without friction."""

TILES = 4
"""Number of summary numbers at the top of the page."""

ALIKE = (
    "No noise: a unit fires the same spikes every time, and units do not differ from each other."
)


def write(result: ResultRecord, path: str | PathLike[str]) -> None:
    """Write the report on `result` to the HTML file `path`."""
    cautions = [f"{text[0].upper()}{text[1:]}." for text in key_numbers.cautions(result)]
    friction = result.lateral is not None and result.lateral.work is not None
    skin = PLAIN if result.scene.finger.raised_ridges is None else RIDGED
    limits = (RUBS if friction else SMOOTH, skin, STANDING)
    notes = (*result.notes, *limits, *_chance(result))
    html = page.render(
        "report.html",
        title=result.scene.name,
        scene=result.scene,
        answer=answer(result),
        touch=_touch(result),
        tiles=list(_tiles(result)),
        files=list(_files(result)),
        warnings=[*result.warnings, *cautions, *_blocked(result)],
        parts=list(_parts(result)),
        membranes=result.spikes is not None and _membranes(result.spikes.family),
        units=list(_units(result)),
        plan=result.plan,
        status=result.status,
        seconds=f"{sum(result.seconds.values()):.3g}",
        stages=page.svg(figures.stages(result)),
        notes=[note if note.endswith(".") else f"{note}." for note in notes],
        folder="out",
        fields=result.fields is not None,
        provenance=list(entries(result.provenance)),
        toml=result.scene.to_toml(),
    )
    Path(path).write_text(html, encoding="utf-8")


def _chance(result: ResultRecord) -> list[str]:
    """Return a note on what is drawn at random, if there are spikes."""
    spikes, layout = result.spikes, result.scene.ask.population
    if spikes is None:
        return []
    if spikes.seed is None:
        return [ALIKE]
    drawn = "The gains of the units or the noise of their membranes are drawn"
    if layout is not None and layout.spread is not None and layout.noise is not None:
        drawn = (
            f"Drawn: the gains of the units (standard deviation of their logarithm "
            f"{layout.spread:g}) and the noise of their membranes ({layout.noise:g} µA/cm²)"
        )
    source = f"the seed {spikes.seed}" + (f" and the trial {spikes.trial}" if spikes.trial else "")
    return [f"{drawn}, from {source}: the same seed gives the same spikes."]


def _membranes(family: str) -> bool:
    """Whether units of a family have membranes; not known where its plugin is not loaded."""
    return family in AFFERENTS and AFFERENTS[family].membranes


def answer(result: ResultRecord) -> str:
    """Return the answer in one sentence: peak force or depth, contact area, spikes."""
    parts, step = [], result.peak
    when = key_numbers.format_instant(result.time[step])
    if result.force is not None and result.scene.motion.by_force:
        parts.append(
            f"the force reaches {result.force.max():.3g} N and the indentation "
            f"{result.depth[step]:.3g} mm (at {when})"
        )
    elif result.force is not None:
        parts.append(
            f"the force peaks at {result.force[step]:.3g} N (at {when}) and is "
            f"{result.force[-1]:.3g} N at the end"
        )
    if result.contact_area is not None:
        parts.append(f"the contact area is at most {np.nanmax(result.contact_area):.3g} mm²")
    if result.spikes is not None:
        parts.append(f"spikes: {result.spikes.summary(result.unmodeled)}")
    if not parts:
        return f"The indenter travels {np.max(result.depth):.3g} mm."
    sentence = "; ".join(parts)
    return sentence[0].upper() + sentence[1:] + "."


def _touch(result: ResultRecord) -> str:
    """Return the finger, the object and the motion in one sentence."""
    scene = result.scene
    finger, motion = scene.finger, scene.motion
    who = f"subject {finger.subject_name}" if finger.subject_name else "a finger"
    peak = f"{motion.peak:.3g} {motion.unit}"
    size = f"{finger.width:g} mm wide, {finger.thickness:g} mm thick"
    what = f"{scene.indenter.describe()}; {motion.kind} to {peak}"
    return f"{who} ({size}) and {what}, {key_numbers.format_instant(motion.duration)} in all."


def _tiles(result: ResultRecord) -> Iterator[dict[str, str]]:
    """Yield the first TILES summary numbers, each with its expected error."""
    for number in key_numbers.leading(result, TILES):
        parts = number.within, number.about
        yield {"name": number.name, "value": number.value, "source": "; ".join(filter(None, parts))}


def _files(result: ResultRecord) -> Iterator[tuple[str, str]]:
    """Yield the files saved with the report, and their contents."""
    yield "result.nc", "every array with its unit, the scene and the plan (netCDF)"
    if result.fields is not None:
        yield "result.vtkhdf", "displacement, strain and pressure on the mesh (ParaView, PyVista)"
    if result.spikes is not None:
        yield "spikes.csv", "one row per spike: unit, type, place in mm, time in s"
        yield "units.csv", "one row per afferent unit, silent ones too, with its number of spikes"


def _blocked(result: ResultRecord) -> list[str]:
    """Return warnings on units in depolarization block."""
    if result.spikes is None:
        return []
    seconds = result.spikes.block_seconds
    blocked = np.flatnonzero(seconds > 0)
    who = [f"{result.spikes.names[unit]} spends {seconds[unit]:.3g} s" for unit in blocked]
    whose = "its"
    if len(blocked) > FEW:
        who = [f"{len(blocked)} of {len(seconds)} units spend up to {seconds.max():.3g} s"]
        whose = "their"
    why = f"the current is above the range in which {whose} membrane fires"
    return [f"{each} in depolarization block: {why}." for each in who]


def _parts(result: ResultRecord) -> Iterator[Part]:
    """Yield the sections of the report."""
    if result.force is not None:
        text = "Force of the whole finger along the indenter's normal, and the indenter's travel."
        if misfit := key_numbers.beside_record(result):
            text = f"{text} Measured: {misfit}."
        yield _part("force", "Force and depth", text, figures.force(result))
    if result.pad is not None and result.pressure is not None:
        lines = "; lines show the mesh" if result.meshed else ""
        text = f"Contact pressure at {result.peak_name}, seen along the z axis{lines}. "
        text = f"{text}{_top_pressure(result)}"
        part = _part("pressure", "Pressure on the pad", text, spatial_figures.pressure_map(result))
        yield part | {"narrow": True}
    if result.contact_area is not None or result.centroid is not None:
        text = "Area of the pad in contact, and centroid of the pressure."
        yield _part("contact", "Contact area and centroid", text, figures.contact(result))
    if result.fields is not None:
        yield _section(result)
    if result.lateral is not None:
        text = "Path of the object over the pad, and the force with which it pushes along its plane"
        if result.lateral.stick_area is not None:
            text = f"{text}; the part of the contact that does not slip, and the work of friction"
            text = f"{text}. {result.lateral.outcome}".removesuffix(".")
        yield _part("sideways", "Sliding", f"{text}.", spatial_figures.sideways(result))
    if result.strain is not None and result.sites is not None:
        text = (
            "Largest compressive and tensile principal strain at the end organs; of a population, "
            "at the most strained one of each type. The number after the type is the depth below "
            "the skin surface."
        )
        yield _part("strain", "Strain at the end organs", text, figures.site_strain(result))
    if result.harmonic is not None:
        yield _harmonic(result.harmonic, result)
    if result.spikes is not None:
        text = (
            "Input of the end organs as an equivalent skin displacement (compression positive), "
            "and generator current into the membrane; of a population, the unit of each type with "
            "the largest current."
        )
        yield _part("current", "From strain to current", text, figures.currents(result))
        yield _spikes(result)
        if found := spectrum_figure.even_slide(result):
            text = spectrum_figure.caption(found)
            yield _part("spectrum", "Spectrum", text, spectrum_figure.draw(result, found))
        if result.scene.motion.slides and result.spikes.positions is not None:
            yield from _on_object(result)


def _top_pressure(result: ResultRecord) -> str:
    """Return sentences on the highest pressure of all times, over 1 mm² and at one point."""
    assert result.pad is not None
    assert result.pressure is not None
    step = int(np.argmax(result.pressure.max(axis=1)))
    top, when = result.pressure[step].max(), key_numbers.format_instant(result.time[step])
    mean, _ = highest(result.pad, result.pressure)
    return (
        f"The highest pressure of all times is {mean:.3g} kPa over 1 mm²; at {result.one_point} "
        f"alone, which is less certain, it is at most {top:.3g} kPa, at {when}."
    )


def _harmonic(harmonic: Harmonic, result: ResultRecord) -> Part:
    text = (
        f"Response to small oscillations about {harmonic.preload_depth:.3g} mm and "
        f"{harmonic.preload_force:.3g} N of relaxed tissue, with contact as it is there. What the "
        f"modes leave out changes the stiffness by at most {100 * harmonic.error.max():.2g} %. The "
        "lowest resonances of the finger held by the indenter, with relaxed tissue, lie at "
        f"{', '.join(f'{f:.0f}' for f in harmonic.modes[:3])} Hz."
    )
    types = result.sites.types if result.sites is not None else ()
    return _part("harmonic", "Vibration", text, figures.harmonic(harmonic, types))


def _spikes(result: ResultRecord) -> Part:
    """Return the section on spikes: of few units their rates, else a raster and a map."""
    assert result.spikes is not None
    if len(result.spikes) <= FEW:
        text = "Spike times, and the rate as the inverse of the interval between two spikes."
        return _part("spikes", "Spikes", text, figures.spikes(result))
    text = (
        "Every spike of the population by type, the units nearest to the first touch on top; the "
        "mean rate of each type; and the places of the units, colored by their rates, over the "
        f"pressure at {result.peak_name}."
    )
    part = _part("spikes", "Spikes of the population", text, spatial_figures.raster(result))
    if result.spikes.positions is None:
        return part
    counted = f"{result.spikes.t_start:.3g} to {result.spikes.t_stop:.3g} s"
    caption = f"Mean rates from {counted}, at the units' places, seen along z."
    map_ = {"source": page.svg(spatial_figures.rate_map(result)), "caption": caption}
    return part | {"pictures": [map_]}


def _on_object(result: ResultRecord) -> Iterator[Part]:
    text = (
        "Every spike at the place on the object that was over the unit then (spatial event plot), "
        "in the object's own x and y; darker is lower."
    )
    yield _part("events", "Spikes on the object", text, spatial_figures.events(result))
    text = (
        "Mean rate against the place on the object: of units on up to five scan lines (their "
        "place across the path), and of all. Time in which the object stands does not count."
    )
    yield _part("lines", "Rate along the object", text, spatial_figures.scan_lines(result))


def _part(key: str, title: str, text: str, drawn: "Figure") -> Part:
    return {"key": key, "title": title, "text": text, "picture": page.svg(drawn)}


def _section(result: ResultRecord) -> Part:
    assert result.fields is not None
    text = (
        f"The deformed finger at the stored time next to {result.peak_name}. Lines bound skin and "
        "subcutaneous tissue; the pale part is the bone; dots are the end organs."
    )
    drawn = []
    if missing := renderer.renderer_lacking():
        text = f"{text} {missing}"
    else:
        frame = frames.nearest_frame(result.fields, frames.peak_time(result))
        when = key_numbers.format_instant(result.fields.times[frame])
        places = ("on the skin, seen from below", "behind the medial plane")
        soft = np.unique(result.fields.cells[result.fields.region != BONE])
        for field, where in zip(("pressure", quantities.DEFAULT), places, strict=True):
            top = quantities.values(result, field, frame)[soft].max()
            caption = (
                f"{field.capitalize()} {where}, {when}: at most {top:.3g} {quantities.unit(field)} "
                f"at {result.one_point}."
            )
            drawn.append({"source": _screenshot(result, field), "caption": caption})
    title = "A section through the finger"
    return _part("section", title, text, section_figure.draw(result)) | {"pictures": drawn}


def _screenshot(result: ResultRecord, field: str) -> str:
    """Return a view in space as the source of a picture."""
    from PIL import Image

    with temporary_folder() as folder:
        path = folder / "picture.png"
        view.screenshot(result, path, field)
        with Image.open(path) as drawn:
            picture = pictures.trimmed(np.asarray(drawn.convert("RGB")))
        Image.fromarray(picture).save(path, optimize=True)
        return page.png(path.read_bytes())


def _units(result: ResultRecord) -> Iterator[dict[str, str]]:
    """Yield the rows of the table of spikes: one per unit, or of many units one per type."""
    spikes = result.spikes
    if spikes is None:
        return
    groups = {name: np.array([i]) for i, name in enumerate(spikes.names)}
    if len(spikes) > FEW:
        groups = {
            f"{kind} ({len(which)} units)": which
            for kind, which in figures.of_each(spikes.types).items()
        }
    for name, which in groups.items():
        times = [spikes.times[i] for i in which]
        gaps = [np.diff(each).min() for each in times if len(each) > 1]
        firsts = [each[0] for each in times if len(each)]
        kind = spikes.types[which[0]]
        yield {
            "name": name,
            "kind": kind,
            "color": figures.COLORS.get(kind, figures.INK),
            "count": str(sum(map(len, times))),
            "driven": str(int(spikes.stimulus_driven[which].sum())),
            "rate": f"{1 / min(gaps):.3g}" if gaps else "none",
            "first": f"{1e3 * min(firsts):.3g}" if firsts else "none",
            "block": f"{spikes.block_seconds[which].sum():.3g}",
            "peak": f"{spikes.peak_mV[which].max():.3g}",
        }

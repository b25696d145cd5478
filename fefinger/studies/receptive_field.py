"""Receptive field of afferent units: their impulses as an object is pressed at places around them.

    field = ff.receptive_field("pin-hold", ("SAI",), reach=3, spacing=0.5)
    field.area("SAI")                # mm² in which the unit fires at least half of its most

The units stay under the first touch of the 30 degree plate, with their end organs; the object and
its motion are the scene's.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fefinger.afferents import fire
from fefinger.mechanics import get
from fefinger.mechanics.situation import Situation
from fefinger.plan import choose, rungs, settled
from fefinger.results.candidate import MECHANICS
from fefinger.results.records import Response
from fefinger.results.result_record import Plan
from fefinger.scene import builtin
from fefinger.scene.ask import Places
from fefinger.scene.scene import Scene
from fefinger.support import atomic_write
from fefinger.support.arrays import Array, Integers
from fefinger.support.atomic_write import keep, output_folder
from fefinger.support.checks import InputError, choice, choices, number
from fefinger.support.inputs import first_line
from fefinger.support.progress import Progress
from fefinger.support.text import outline
from fefinger.support.vocabulary import TYPE_SYNONYMS, TYPES


if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST = 1000
"""Largest number of places, each a press of its own."""

ASIDE = np.array([0.5, 0.5])
"""Place in mm for which the mechanics is chosen: off the medial plane, like most places."""

FILES = ("field.csv", "field.svg")
"""Files that `ReceptiveField.save` writes."""

PLACE = ("x_mm", "y_mm")
"""First columns of the table of a field."""


@dataclass(frozen=True)
class ReceptiveField:
    """Impulses (n_places, n_kinds) of one unit of each kind, by the place of the object.

    places (n_places, 2): x, y in mm from the unit, on a square grid with a `spacing` in mm; organs:
    places (n_organs, 2) mm of the unit's end organs by kind; scene and mechanics: names; left_out:
    places at which the object cannot be pressed, and why.
    """

    kinds: tuple[str, ...]
    places: Array
    impulses: Integers
    spacing: float
    organs: dict[str, Array]
    scene: str
    mechanics: str
    left_out: tuple[tuple[tuple[float, float], str], ...] = ()

    __repr__ = outline

    def of(self, kind: str) -> Integers:
        """Return the impulses (n_places,) of the unit of a kind; InputError for another kind."""
        return self.impulses[:, self.kinds.index(choice("kind", kind, self.kinds))]

    def area(self, kind: str, part: float = 0.5) -> float:
        """Area in mm² where the unit fires at least a part of its most impulses, and at least one.

        part: 0.5 for half of the most, as fields under steady pressure are drawn; 0 for wherever it
        fires at all, as those near threshold are. In whole squares of the grid; a lower bound if
        the field leaves the grid.
        """
        fired = self.of(kind)
        reached = fired >= max(1.0, number("part", part, at_least=0, at_most=1) * fired.max())
        return float(np.count_nonzero(reached) * self.spacing**2)

    def record(self) -> dict[str, object]:
        """Return the numbers as plain values."""
        kinds = {
            kind: {
                "impulses": self.of(kind).tolist(),
                "half_area_mm2": self.area(kind),
                "area_mm2": self.area(kind, 0.0),
            }
            for kind in self.kinds
        }
        return {
            "scene": self.scene,
            "mechanics": self.mechanics,
            "places_mm": self.places.tolist(),
            "units": kinds,
            "left_out": [{"place_mm": place, "reason": why} for place, why in self.left_out],
        }

    def figure(self) -> "Figure":
        """Draw the field of every unit."""
        from fefinger.view.spatial_figures import receptive_fields

        fields = {kind: self.of(kind) for kind in self.kinds}
        return receptive_fields(self.places, self.spacing, fields, self.organs)

    def save(self, folder: str | Path) -> list[str]:
        """Write FILES into a folder and return their paths.

        InputError where it is unusable, or where files of these names hold no field.
        """
        from fefinger.view.figures import svg

        lines = [",".join([*PLACE, *(f"{kind}_impulses" for kind in self.kinds)])]
        for (x, y), counts in zip(self.places.tolist(), self.impulses.tolist(), strict=True):
            lines.append(",".join([f"{x:g}", f"{y:g}", *map(str, counts)]))
        place = output_folder(folder)
        keep_others(place)
        texts = dict(zip(FILES, ("\n".join(lines) + "\n", svg(self.figure())), strict=True))
        atomic_write.write(place, texts)
        return [str(place / name) for name in FILES]


def keep_others(folder: Path) -> None:
    """Raise InputError where files named as FILES in a folder hold no earlier field."""
    present = [name for name in FILES if (folder / name).exists()]
    header = rf"{','.join(PLACE)}(,\w+_impulses)+"
    if re.fullmatch(header, first_line(folder / FILES[0])):
        present = []
    keep(present, folder, "receptive field")


def receptive_field(
    scene: Scene | str | Path,
    kinds: Sequence[str] = ("SAI", "FAI"),
    *,
    changes: Mapping[str, object] | None = None,
    reach: float = 3.0,
    spacing: float = 1.0,
    branched: bool = True,
    seed: int = 0,
    mechanics: str | None = None,
    progress: Progress | None = None,
) -> ReceptiveField:
    """Press the object of a scene at places around one unit of each kind.

    Parameters
    ----------
    scene
        A Scene, the name of a built-in one, or a TOML file; its object has a place (`indenter.at`).
    kinds
        Types of the units.
    changes
        Values of fields of the scene by their path.
    reach, spacing
        Half the side of the square of places, and the distance between them, in mm.
    branched, seed
        Whether units have the published numbers of end organs, and the seed of their places and of
        the noise. Gains are as of the type: units of a seed do not differ in sensitivity.
    mechanics
        Name of the mechanics; by default as the scene asks (`ask.mechanics`), or the cheapest for
        all places that does not refuse.
    progress
        Called with "places" and the fraction that is done.

    Raises
    ------
    InputError
        An object without a place, such as a plate, too many places, or a scene that no mechanics
        answers with the object over the unit. Another place that none answers, as one beside the
        pad, is left out.
    """
    spacing = number("spacing", spacing, above=0, unit="mm")
    places = _grid(reach, spacing)
    given = builtin.given(scene, changes)
    units = Places(places=((0.0, 0.0),), branched=branched, spread=0.0, seed=seed)
    spikes = choices("kinds", kinds, TYPES, TYPE_SYNONYMS)
    ask = replace(given.ask, spikes=spikes, population=units, fields=False, pressure=False)
    prepared = replace(given, ask=ask)
    aside = _moved(prepared, ASIDE)
    plan = choose(aside, mechanics or ask.mechanics or cheapest(aside, len(places)))
    press = partial(_pressed, prepared, plan)
    response, middle = press(np.zeros(2))
    impulses, on, left_out = [], np.ones(len(places), bool), []
    for i, place in enumerate(places):
        try:
            impulses.append(press(place)[1] if place.any() else middle)
        except InputError as error:
            on[i] = False
            left_out.append(((float(place[0]), float(place[1])), str(error)))
        if progress is not None:
            progress("places", (i + 1) / len(places))
    sites = response.sites
    assert sites is not None
    organs = {
        kind: sites.points[[each == kind for each in sites.types]][:, :2]
        for kind in prepared.ask.spikes
    }
    return ReceptiveField(
        prepared.ask.spikes,
        places[on],
        np.array(impulses, np.int64),
        spacing,
        organs,
        prepared.name,
        plan.mechanics,
        tuple(left_out),
    )


def _grid(reach: float, spacing: float) -> Array:
    """Return places (n, 2) mm of a square grid about the unit; InputError for more than MOST."""
    count = int(number("reach", reach, at_least=spacing, unit="mm") / spacing + 1e-9)
    if (2 * count + 1) ** 2 > MOST:
        raise InputError(
            f"spacing: expected at most {MOST} places, received {(2 * count + 1) ** 2}; choose a "
            "larger spacing or a smaller reach"
        )
    lines = spacing * np.arange(-count, count + 1)
    return np.stack(np.meshgrid(lines, lines, indexing="ij"), axis=-1).reshape(-1, 2)


def _pressed(scene: Scene, plan: Plan, place: Array) -> tuple[Response, Integers]:
    """Press the object at a place (2,) mm; return the response, and the impulses of the units."""
    response = get(plan.mechanics).respond(settled(_moved(scene, place), plan))
    trains = fire(scene.ask, response, since=scene.motion.recorded_from, check=False)
    return response, trains.count()


def _moved(scene: Scene, place: Array) -> Scene:
    x, y = place.tolist()
    return replace(scene, indenter=scene.indenter.moved((x, y)))


def cheapest(scene: Scene, count: int) -> str | None:
    """Return the mechanics that answers `count` such scenes first; None where all refuse.

    What a mechanics builds once, such as the operator of `condensed`, serves all scenes, except for
    a press at finite strain, which holds at one place of the object.
    """
    case, total = Situation.of(scene), {}
    for rung in rungs(scene):
        if not rung.refusals and np.isfinite(rung.error):
            on = case if rung.resolution is None else case.on(rung.resolution)
            shared = not MECHANICS[rung.mechanics].finite
            once = get(rung.mechanics).once(on) if shared else 0.0
            total[rung.mechanics] = once + count * (rung.seconds - once)
    return min(total, key=total.__getitem__, default=None)

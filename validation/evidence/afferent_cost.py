"""Measure what end organs, spikes, fields and long motions cost; write the report of the planner.

Run as `python -m fefinger.validation.evidence.afferent_cost reports` on a machine that does nothing
else; some four minutes of one core. The seconds are those of an answer for which all that is kept
is at hand, with the counts that they grow with; `cost_table.py` fits them.
"""

import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fefinger.validation.problems import published
from fefinger.validation.provenance import save

from fefinger.afferents import fire
from fefinger.mechanics import get
from fefinger.mechanics.evidence import costs
from fefinger.mechanics.situation import Situation
from fefinger.results.candidate import Candidate
from fefinger.scene.scene import Scene


REPORT = "afferent-cost.json"

CANDIDATES = (
    *("hertz", "layered"),
    *(f"{name} {mesh}" for name in ("condensed", "pressed") for mesh in ("coarse", "standard")),
    *("linear coarse", "solid coarse"),
)
"""Candidates that are timed."""

BASE: dict[str, object] = {
    "motion.depth": 1.2,
    "motion.speed": 20,
    "motion.hold": 0.5,
    "ask.fields": False,
    "ask.spikes": ["SAI", "FAI"],
}
"""Changes of the built-in press in all variants."""

SHALLOW = 0.6
"""Depth in mm without a mesh, where the contact may not be wide."""

PLAIN: dict[str, object] = {"ask.spikes": []}
SINGLE: dict[str, object] = {"kind": "grid", "branched": False}
FEW: dict[str, object] = {"ask.population": SINGLE | {"spacing": 1.0, "radius": 2.0}}
MANY: dict[str, object] = {"ask.population": SINGLE | {"spacing": 0.5, "radius": 4.0}}
SLOW: dict[str, object] = {"motion.speed": 0.5}
ALL: dict[str, object] = {"ask.spikes": ["SAI", "SAII", "FAI", "FAII"]}
THESIS: dict[str, object] = {"ask.afferents": "thesis"}
LONG: dict[str, object] = {"motion.hold": 10.0}

VARIANTS: Mapping[str, dict[str, object]] = {
    "plain": PLAIN,
    "fields": PLAIN | {"ask.fields": True},
    "slow": PLAIN | SLOW,
    "slow, without pressure": PLAIN | SLOW | {"ask.pressure": False},
    "one": {},
    "few": FEW,
    "many": MANY,
    "many, slow": MANY | SLOW,
    "fine steps": ALL,
    "few, fine steps, slow": FEW | ALL | SLOW,
    "few, long": FEW | LONG,
    "few, of the thesis": FEW | THESIS,
    "few, long, of the thesis": FEW | THESIS | LONG,
    "one, slow, of the thesis": SLOW | THESIS,
}
"""Further changes."""


def scene(candidate: Candidate, changes: Mapping[str, object], number: int) -> Scene:
    """Return the press for a candidate; those without a mesh have a skin of its own in each.

    Contacts of a stack of layers are kept for as long as a process lives, and no longer.
    """
    base: dict[str, object] = dict(BASE)
    if candidate.resolution is None:
        base |= {"finger.skin.modulus": 100.0 + number, "motion.depth": SHALLOW}
    else:
        base["finger.resolution"] = candidate.resolution
    return published.load("flat-press", base | dict(changes))


def rows(label: str) -> Iterator[dict[str, Any]]:
    """Yield the CPU seconds of a candidate in each variant, with what they grow with."""
    candidate = Candidate.of(label)
    respond = get(candidate.mechanics).respond
    respond(scene(candidate, PLAIN, len(VARIANTS)))  # compiles
    for number, (name, changes) in enumerate(VARIANTS.items()):
        given = scene(candidate, changes, number)
        if candidate.resolution is None and given.ask.wants("fields"):
            continue
        if candidate.resolution is not None:
            respond(given)  # builds what is kept
        started = time.process_time()
        response = respond(given)
        answered = time.process_time()
        fired = 0.0
        if given.ask.spikes:
            fire(given.ask, response)
            again = time.process_time()
            fire(given.ask, response)
            fired = time.process_time() - again
        print(label, name, f"{answered - started:.3g} s", flush=True)
        yield {
            "variant": name,
            "candidate": label,
            "family": given.ask.afferents,
            "steps": len(response.time),
            "load_steps": int(response.numbers.get("steps", 0)),
            "areas": Situation.of(given).changes * given.ask.wants("pressure"),
            "fields": int(given.ask.wants("fields")),
            "organs": 0 if response.sites is None else len(response.sites.points),
            "population": int(given.ask.population is not None),
            "blocks": costs.blocks(given.ask),
            "duration_s": given.motion.duration,
            "seconds": round(answered - started, 4),
            "spike_seconds": round(fired, 4),
        }


def main(folder: Path) -> None:
    """Write the report."""
    found = [row for label in CANDIDATES for row in rows(label)]
    save(folder / REPORT, {"scene": "flat-press", "rows": found})


if __name__ == "__main__":
    main(Path(sys.argv[1]))

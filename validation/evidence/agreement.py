"""Measure whether the stated intervals of all mechanics that answer one scene overlap.

Run as `python -m fefinger.validation.evidence.agreement reports [MECHANICS ...]`, by default of all
mechanics, which take some 40 s of a core for each of the scenes; `lumped`, `hertz`, `layered` and
`condensed` take 3 s. Scenes are drawn at random, on the coarse mesh; no truth is needed. A value v
that is stated within e lies between v / (1 + e) and v / (1 - e). Answers that are in the report
already are not computed again, but judged again.
"""

import itertools
import math
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from fefinger.validation.provenance import save, saved, short
from fefinger.validation.tradeoff.scenes import DEEPEST, STEEP, STEEP_DEEPEST, object_of

from fefinger.mechanics import get, names
from fefinger.mechanics.evidence.stated_errors import strain_of
from fefinger.mechanics.situation import Situation
from fefinger.plan import rungs
from fefinger.results.candidate import MECHANICS
from fefinger.results.pressure import highest
from fefinger.results.records import Response
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold, Trapezoid
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError, InputError


REPORT = "agreement.json"

COUNT, SEED = 54, 54

SUBJECTS = "a.h.", "d.s.", "d.p.", "p.w."
TISSUES = None, "maeno1998", "dandekar2003", "saal2017"
"""Tissues of the fingers: their own, and the published ones."""

OBJECTS = "plate", "ball", "plate", "tilted", "cylinder", "plate", "ball", "bar", "grating"
"""Kinds of objects, in turn."""

SPIKES = "SAI", "FAI"
"""Types at whose end organs strain is compared."""

EVERYTHING = Ask(pressure=True, strain=True, fields=False, spikes=SPIKES, rel_error=1.0)


def drawn(count: int = COUNT, seed: int = SEED) -> dict[str, Scene]:
    """Return scenes at random: finger and tissue, object, motion to a depth or a force."""
    rng = np.random.default_rng(seed)
    scenes = {}
    for number in range(count):
        kind, tissue = OBJECTS[number % len(OBJECTS)], TISSUES[number % len(TISSUES)]
        subject = str(rng.choice(SUBJECTS))
        finger = Finger.subject(
            subject, resolution="coarse", **({"tissue": tissue} if tissue else {})
        )
        indenter = object_of(rng, kind)
        steep = indenter.flat is not None and indenter.flat.angle > STEEP
        deepest = finger.thickness * (STEEP_DEEPEST if steep else DEEPEST[kind])
        key = f"{number:02d} {tissue or 'own'} {subject}, {kind}"
        motion = _motion(rng, deepest, forced=number % 5 == 4)
        scenes[key] = Scene(finger=finger, indenter=indenter, motion=motion, ask=EVERYTHING)
    return scenes


def _motion(rng: np.random.Generator, deepest: float, *, forced: bool) -> Motion:
    """Return a ramp and hold to .05 to .5 N, or a motion to 15 to 95 % of the largest depth."""
    if forced:
        force = round(float(np.exp(rng.uniform(*np.log([0.05, 0.5])))), 3)
        return RampHold(loading_rate=10 * force, force=force, hold=0.1)
    depth = round(float(rng.uniform(0.15, 0.95)) * deepest, 3)
    speed = float(f"{10 ** rng.uniform(0, 2):.3g}")
    return (
        Trapezoid(speed, depth, hold=0.05)
        if rng.random() < 0.2
        else RampHold(speed, depth, hold=0.05)
    )


def answers(scene: Scene, mechanics_names: Iterable[str]) -> dict[str, dict[str, float]]:
    """Return what mechanics answer, by quantity; nothing where they are not able to."""
    found: dict[str, dict[str, float]] = {}
    for name in mechanics_names:
        found[name] = {}
        local = MECHANICS[name].local
        asked = (
            scene if local else replace(scene, ask=Ask(pressure=False, strain=False, fields=False))
        )
        mechanics = get(name)
        if any(each.about == "ability" for each in mechanics.refuse(Situation.of(asked))):
            continue
        try:
            found[name] = values(asked, mechanics.respond(asked))
        except (InputError, ConvergenceError) as error:
            print(name, error, flush=True)  # progress
    return found


def values(scene: Scene, response: Response) -> dict[str, float]:
    """Return the answer when the indenter presses most, its highest pressure and compression."""
    forced = scene.motion.by_force
    top = int(np.argmax(response.depth if forced else response.force))
    found = {"depth": response.depth[top]} if forced else {"force": response.force[top]}
    if response.contact_area is not None:
        found["area"] = response.contact_area[top]
    if response.pad is not None and response.pressure is not None:
        found["pressure"] = highest(response.pad, response.pressure)[0]
    if response.strain is not None and response.sites is not None:
        for strain, kind in zip(response.strain[top], response.sites.types, strict=True):
            found[strain_of(kind)] = -np.linalg.eigvalsh(strain)[0]
    return dict(zip(found, short(found.values()), strict=True))


def stated(scene: Scene) -> dict[str, dict[str, float]]:
    """Return the stated errors of every mechanics, by quantity."""
    return {rung.mechanics: {"force": rung.error, **rung.errors} for rung in rungs(scene)}


def interval(value: float, error: float) -> tuple[float, float]:
    """Return the ends between which a true value lies that was answered within an error."""
    return value / (1 + error), value / (1 - error) if error < 1 else math.inf


def apart(
    answered: Mapping[str, Mapping[str, float]], errors: Mapping[str, Mapping[str, float]]
) -> tuple[Counter[str], dict[str, list[str]]]:
    """Return the number of pairs of stated values by quantity, and those that do not overlap."""
    pairs: Counter[str] = Counter()
    found: dict[str, list[str]] = {}
    for first, second in itertools.combinations(answered, 2):
        for what in answered[first].keys() & answered[second].keys():
            known = [errors[name].get(what, math.nan) for name in (first, second)]
            if not all(map(math.isfinite, known)):
                continue
            pairs[what] += 1
            low, high = zip(
                *(
                    interval(answered[name][what], e)
                    for name, e in zip((first, second), known, strict=True)
                ),
                strict=True,
            )
            if max(low) > min(high):
                found.setdefault(what, []).append(f"{first}, {second}")
    return pairs, found


def main(folder: Path, *chosen: str) -> None:
    """Answer what is missing, judge all and write the report after every scene."""
    path = folder / REPORT
    before, scenes = saved(path).get("scenes", {}), drawn()
    found = {key: dict(before.get(key, {}).get("answers", {})) for key in scenes}
    for key, scene in scenes.items():
        known = found[key]
        missing = [name for name in chosen or names() if name not in known]
        if missing:
            known |= answers(scene, missing)
            print(key, known, flush=True)  # progress
            save(path, {"scenes": {each: {"answers": row} for each, row in found.items()}})
    save(path, judged(found))


def judged(found: Mapping[str, Mapping[str, Mapping[str, float]]]) -> dict[str, Any]:
    """Return the report: by quantity the number of pairs and of those that do not overlap."""
    scenes, rows = drawn(), {}
    pairs: Counter[str] = Counter()
    beyond: Counter[str] = Counter()
    for key, answered in found.items():
        count, off = apart(answered, stated(scenes[key]))
        pairs += count
        beyond += Counter({what: len(each) for what, each in off.items()})
        rows[key] = {"answers": answered, "apart": off}
    return {"pairs": {what: [n, beyond[what]] for what, n in sorted(pairs.items())}, "scenes": rows}


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])

"""Thesis 3.6 and 5.2: what a population says of curvature, force, compliance and a flat side.

Units on a line across the contact, from strain of `hertz`, `layered` and `linear` to spikes.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected

from fefinger.afferents import fire
from fefinger.mechanics import get
from fefinger.neural.statistics import mean_rates
from fefinger.scene.ask import Ask, Line
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motion import Motion
from fefinger.scene.motions import RampHold
from fefinger.scene.scene import Scene
from fefinger.support.arrays import Array


FLAT, CURVATURES = 0.0, (80.6, 172.0, 340.0)
"""1/m: those of Goodwin, Macefield & Bisley (1997), J Neurophysiol 78:2881, abstract, without
694, a radius of 1.44 mm, which the depth comes near to."""

FORCES = (0.05, 0.1)
"""N: half of the 10 gf that thesis 3.6 begins with, and those; at 20 gf the most curved sphere
sinks in to its rim."""

REACH, COUNT = 5.0, 21
"""mm to either side of the first touch, and units on that line."""

LATE = 0.3
"""s of the end of the hold in which rates are counted."""

MECHANICS = ("hertz", "layered", "linear")

SOFT = 0.5
"""Factor on the moduli of a finger that stands for a compliant object on the usual finger."""

RULING = "Pawluk (1997), "


@dataclass(frozen=True)
class Profile:
    """Places (n,) mm across the finger; drive: input of the end organs in mm; rate in Hz."""

    place: Array
    drive: Array
    rate: Array

    @property
    def peak(self) -> float:
        """The largest input in mm."""
        return float(self.drive.max())

    @property
    def width(self) -> float:
        """Full width in mm at half of the largest input."""
        top = int(np.argmax(self.drive))
        half = 0.5 * self.drive[top]
        left = np.interp(half, self.drive[: top + 1], self.place[: top + 1])
        right = np.interp(half, self.drive[top:][::-1], self.place[top:][::-1])
        return float(right - left)


def indenter(curvature: float) -> Indenter:
    """Return the plate for 0, else the sphere of a curvature in 1/m."""
    return Flat() if curvature == FLAT else Sphere(radius=1e3 / curvature)


@cache
def profile(
    mechanics: str, curvature: float, force: float, kind: str = "SAI", softer: float = 1.0
) -> Profile:
    """Return the answer of units on a line across the finger to a force that is held."""
    finger = Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
    finger = replace(
        finger,
        skin=replace(finger.skin, modulus=softer * finger.skin.modulus),
        subcutaneous=replace(finger.subcutaneous, modulus=softer * finger.subcutaneous.modulus),
    )
    motion = RampHold(loading_rate=4.0, force=force, hold=0.8, corner=0.01)
    return _answer(mechanics, finger, indenter(curvature), motion, kind)


@cache
def pressed(mechanics: str, depth: float, kind: str) -> Profile:
    """Return the answer of units on a line across the finger to a plate pressed to a depth."""
    finger = Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
    return _answer(mechanics, finger, Flat(), RampHold(20.0, depth, hold=0.8, corner=0.01), kind)


def _answer(
    mechanics: str, finger: Finger, touching: Indenter, motion: Motion, kind: str
) -> Profile:
    line = Line(start=(0.0, -REACH), stop=(0.0, REACH), count=COUNT, branched=False)
    ask = Ask(pressure=False, fields=False, spikes=(kind,), population=line, afferents="thesis")
    scene = Scene(finger=finger, indenter=touching, motion=motion, ask=ask)
    trains = fire(scene.ask, get(mechanics).respond(scene))
    end = trains.t_stop
    assert trains.positions is not None
    order = np.argsort(trains.positions[:, 1], kind="stable")
    rate = mean_rates(trains, end - LATE, end)[order]
    return Profile(trains.positions[order, 1], trains.x_in[-1][order], rate)


def steps(mechanics: str, what: str, force: float) -> float:
    """Return the smallest relative change of a number from one curvature to the next larger."""
    values = [getattr(profile(mechanics, c, force), what) for c in (FLAT, *CURVATURES)]
    return float(np.min(np.diff(values) / values[:-1]))


def fan(mechanics: str) -> float:
    """Return by how much more the peak rises with curvature at the larger force than at the less.

    Peak input under the most curved sphere less that under the plate; over the ratio of forces.
    """
    rises = [
        profile(mechanics, CURVATURES[-1], f).peak - profile(mechanics, FLAT, f).peak
        for f in FORCES
    ]
    return rises[1] / rises[0]


def compliance(mechanics: str, what: str) -> float:
    """Return a number on a finger of half the moduli, over that on the usual one, at one force."""
    soft = profile(mechanics, CURVATURES[1], FORCES[1], softer=SOFT)
    usual = profile(mechanics, CURVATURES[1], FORCES[1])
    return float(getattr(soft, what) / getattr(usual, what))


def symmetry(mechanics: str) -> float:
    """Return the largest difference of input between mirrored places, over the largest input."""
    drive = pressed(mechanics, 1.0, "SAI").drive
    return float(np.abs(drive - drive[::-1]).max() / drive.max())


def plateau(mechanics: str) -> float:
    """Return the span of SAI rates under the middle 3 mm of a plate, over their mean."""
    profile_ = pressed(mechanics, 1.0, "SAI")
    middle = profile_.rate[np.abs(profile_.place) <= 1.5]
    return float(np.ptp(middle) / middle.mean())


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the claims; `linear` takes minutes and is left out when quick."""
    for mechanics in MECHANICS[:1] if quick else MECHANICS:
        yield from _curvature(mechanics, FORCES[1:] if quick else FORCES)
        yield from _box(mechanics)


def _curvature(mechanics: str, forces: tuple[float, ...]) -> Iterator[Case]:
    goodwin = "Goodwin, Macefield & Bisley (1997), J Neurophysiol 78:2881, abstract: "
    for force in forces:
        yield Case(
            f"3.6: {mechanics}, {force:g} N: least rise of the peak SAI input from one to the next",
            partial(steps, mechanics, "peak", force),
            Expected.between(0.01, 3.0),
            f"{RULING}3.6; {goodwin}the SAI response increases with curvature",
            reason="one percent or more at each step from the plate to 340 1/m",
        )
        yield Case(
            f"3.6: {mechanics}, {force:g} N: width of the SAI profile, 340 1/m over the plate",
            partial(
                lambda f: (
                    profile(mechanics, CURVATURES[-1], f).width / profile(mechanics, FLAT, f).width
                ),
                force,
            ),
            Expected.between(0.1, 0.9),
            f"{RULING}3.6; {goodwin}the profile becomes higher and narrower",
            reason="narrower by a tenth or more",
        )
    if forces == FORCES:
        yield Case(
            f"3.6: {mechanics}: rise of the peak with curvature at 0.1 N, over that at 0.05 N",
            partial(fan, mechanics),
            Expected.between(1.05, 2.0),
            f"{RULING}3.6, Figs. 3-7 and 3-8: curves fan out with force",
            reason="more than at the smaller force, less than twice",
        )
    yield Case(
        f"5.2: {mechanics}: peak SAI input on tissue of half the modulus, 172 1/m, 0.1 N",
        partial(compliance, mechanics, "peak"),
        Expected.between(1.05, 3.0),
        f"{RULING}5.2: compliance is a property that the population tells",
        reason="at one force a softer contact strains more",
    )
    name = f"5.2: {mechanics}: width of the SAI profile on tissue of half the modulus"
    measure = partial(compliance, mechanics, "width")
    source = f"{RULING}5.2; Hertz: the contact radius goes with the modulus to -1/3"
    yield Case(name, measure, Expected.between(1.0, 2.0), source, reason="not narrower")


def _box(mechanics: str) -> Iterator[Case]:
    yield Case(
        f"5.2: {mechanics}: flat side, 1 mm: difference of SAI input left and right, over the peak",
        partial(symmetry, mechanics),
        Expected.between(0.0, 0.02),
        "the finger and the plate are their own mirror images",
        reason="mesh",
    )
    yield Case(
        f"5.2: {mechanics}: flat side, 1 mm: span of SAI rates in the middle 3 mm, over their mean",
        partial(plateau, mechanics),
        Expected.between(0.0, 0.35),
        f"{RULING}5.2: contact with the flat side of a box; a plate presses the middle evenly",
        reason="a third of the mean",
    )

"""Presses of one finger for a calibration, with their cost by stage."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from fefinger.calibration.outcome import stiffening
from fefinger.calibration.record import Stage
from fefinger.calibration.slow_press import (
    LATER,
    PLATE,
    SPARE,
    SlowPress,
    press,
    shapable,
    small,
)
from fefinger.results.candidate import MECHANICS
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.support.progress import Progress


class Work:
    """Presses of one finger, with their progress and their cost by stage."""

    def __init__(self, finger: Finger, progress: Progress | None) -> None:
        self.finger, self.progress = finger, progress
        self.stages: list[Stage] = []
        self._presses: dict[tuple[Finger, str, Indenter], SlowPress] = {}
        self._early: dict[tuple[float, str], None] = {}
        self._buckling = set[str]()  # meshes on which a press ended early

    @contextmanager
    def stage(self, name: str) -> Iterator[Callable[[float], None]]:
        """Measure a stage; yields a function that takes its misfit."""
        started, misfits = time.process_time(), list[float]()
        self._presses = {}
        if self.progress is not None:
            self.progress(name, 0.0)
        yield misfits.append
        spent = time.process_time() - started
        presses = sum(each.seconds for each in self._presses.values())
        misfit = misfits[-1] if misfits else None
        self.stages.append(Stage(name, spent, len(self._presses), presses, misfit))
        if self.progress is not None:
            self.progress(name, 1.0)

    def press(
        self,
        mechanics: str,
        resolution: str,
        radius: float,
        exponent: float | None = None,
        ratio: float = 1.0,
        part: float | None = None,
        indenter: Indenter = PLATE,
    ) -> SlowPress:
        """Press the finger with another radius, exponent and skin; `part` as in `slow_press`."""
        finger = stiffening(self.finger, exponent)
        finger = replace(
            finger,
            resolution=resolution,
            pad_radius=radius,
            skin=replace(finger.skin, modulus=ratio * finger.skin.modulus),
        )
        wanted = finger, mechanics, indenter
        if wanted not in self._presses:
            finite = MECHANICS[mechanics].finite
            spare = LATER if finger.resolution in self._buckling else SPARE
            self._presses[wanted] = (
                press(finger, mechanics, part, spare, indenter)
                if finite
                else small(finger, indenter)
            )
            self._note(finger, self._presses[wanted])
        return self._presses[wanted]

    def ended(self, depth: float) -> tuple[str, ...]:
        """Reasons of presses that ended early at `depth` mm, which limits the fit."""
        return tuple(text for at, text in self._early if math.isclose(at, depth, rel_tol=1e-9))

    def _note(self, finger: Finger, press: SlowPress) -> None:
        """Record a press that ended before its depth."""
        if press.halt:
            at = float(press.depth[-1])
            text = (
                f"the press on the {finger.resolution} mesh at a pad radius of "
                f"{finger.pad_radius:g} mm ended early, at {at:.3g} mm and "
                f"{press.force[-1]:.3g} N: {press.halt}"
            )
            self._early[at, text] = None
            self._buckling.add(finger.resolution)

    def reachable(self, radius: float) -> float:
        """Limit a pad radius in mm to one that is feasible for the finger's size."""
        start = self.finger.pad_radius
        # Largest number of halvings of the change from a feasible pad radius to an infeasible one.
        halvings = 6
        for _ in range(halvings):
            if shapable(replace(self.finger, pad_radius=radius)):
                return radius
            radius = math.sqrt(radius * start)
        return start

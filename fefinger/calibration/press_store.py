"""Presses of one finger for a calibration, by stage, with what they cost."""

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

from fefinger.calibration.outcome import layer
from fefinger.calibration.record import Stage
from fefinger.calibration.slow_press import LATER, SPARE, Press, press, shapable, small
from fefinger.results.candidate import MECHANICS
from fefinger.scene.finger import Finger
from fefinger.support.progress import Progress


HALVINGS = 6
"""Steps, each half of the one before, from a pad that is too flat for the finger's size."""


class Work:
    """Presses of one finger, with their progress and their cost by stage."""

    def __init__(self, finger: Finger, progress: Progress | None) -> None:
        self.finger, self.progress = finger, progress
        self.stages: list[Stage] = []
        self._presses: dict[tuple[Finger, str], Press] = {}
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
        kept = sum(each.seconds for each in self._presses.values())
        misfit = misfits[-1] if misfits else None
        self.stages.append(Stage(name, spent, len(self._presses), kept, misfit))
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
    ) -> Press:
        """Return a press of the finger with another radius, exponent and skin; `part` as there."""
        finger = replace(
            self.finger,
            resolution=resolution,
            pad_radius=radius,
            skin=layer(self.finger.skin, exponent, ratio),
            subcutaneous=layer(self.finger.subcutaneous, exponent),
        )
        wanted = finger, mechanics
        if wanted not in self._presses:
            finite = MECHANICS[mechanics].finite
            spare = LATER if finger.resolution in self._buckling else SPARE
            self._presses[wanted] = (
                press(finger, mechanics, part, spare) if finite else small(finger)
            )
            self._note(finger, self._presses[wanted])
        return self._presses[wanted]

    def ended(self, depth: float) -> tuple[str, ...]:
        """Return why presses ended early at `depth` mm, which is as far as a fit then knows."""
        return tuple(said for at, said in self._early if math.isclose(at, depth, rel_tol=1e-9))

    def _note(self, finger: Finger, found: Press) -> None:
        """Note a press that ended before its depth."""
        if found.halt:
            at = float(found.depth[-1])
            said = (
                f"the press on the {finger.resolution} mesh at a pad radius of "
                f"{finger.pad_radius:g} mm ended early, at {at:.3g} mm and "
                f"{found.force[-1]:.3g} N: {found.halt}"
            )
            self._early[at, said] = None
            self._buckling.add(finger.resolution)

    def reachable(self, radius: float) -> float:
        """Return a pad radius in mm, or the nearest one on the way to it that the size allows."""
        start = self.finger.pad_radius
        for _ in range(HALVINGS):
            if shapable(replace(self.finger, pad_radius=radius)):
                return radius
            radius = math.sqrt(radius * start)
        return start

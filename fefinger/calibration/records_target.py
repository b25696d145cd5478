"""Several presses of one finger by one rig as a target, with one tissue."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Unknown, Values
from fefinger.calibration.record_target import RecordTarget
from fefinger.calibration.slow_press import PLATE
from fefinger.calibration.targets import LumpedLaw
from fefinger.scene.indenter import Indenter
from fefinger.support.arrays import Array


@dataclass(frozen=True)
class RecordsTarget:
    """Presses of one finger, at several speeds, depths or objects, with one tissue and one rig.

    Touch, offset and drift are a press's own: the finger moves between presses. The first press has
    the names without a number.
    """

    records: tuple[RecordTarget, ...]

    @property
    def name(self) -> str:
        """Names of the files."""
        return ", ".join(each.name for each in self.records)

    @property
    def shows_ratio(self) -> bool:
        """Always: a record has the depth."""
        return True

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Touches, and what is loose of the rig, once where the presses share it."""
        named = {each.name: each for record in self.records[::-1] for each in record.unknowns}
        order = [each.name for record in self.records for each in record.unknowns]
        return tuple(named[name] for name in dict.fromkeys(order))

    @property
    def lumped_law(self) -> LumpedLaw:
        """The lumped model of the first press."""
        return self.records[0].lumped_law

    @property
    def advice(self) -> str:
        """Causes of misfit that lie in the records."""
        return self.records[0].advice

    def residual(self, law: ForceLaw, values: Values) -> Array:
        """Whitened residuals (n,) of all presses, in standard deviations."""
        return np.concatenate([each.residual(law, values) for each in self.records])

    def weighed(
        self, law: Callable[[Values], ForceLaw], unknowns: Sequence[Unknown], values: Values
    ) -> Self:
        """Return the presses with the covariance of their data about a fit, each with its own."""
        return replace(
            self, records=tuple(each.weighed(law, unknowns, values) for each in self.records)
        )

    def reach(self, law: ForceLaw, values: Values) -> float:
        """Largest depth in mm of the presses by the object of the first."""
        first = self.records[0].indenter
        return max(each.reach(law, values) for each in self.records if each.indenter == first)

    def misfits(self, law: ForceLaw, values: Values) -> dict[str, float]:
        """Errors of every press; the first press has no number."""
        return {
            name: size for each in self.records for name, size in each.misfits(law, values).items()
        }

    def checks(self, law: ForceLaw) -> dict[str, dict[str, float]]:
        """Return none: a check is another record."""
        return {}

    def quality(self, residuals: dict[str, float]) -> str:
        """Say how close the fit of each press is."""
        parts = (f"{100 * residuals['mse' + each.press]:.2g}" for each in self.records)
        return f"squared errors {', '.join(parts)} % of the variances"

    def remarks(self, values: Values, *, finite: bool, with_frames: bool) -> tuple[str, ...]:
        """Sentences on what the first press does not identify, which others may."""
        return self.records[0].remarks(values, finite=finite, with_frames=with_frames)


def together(records: Sequence[RecordTarget]) -> RecordTarget | RecordsTarget:
    """Return presses as one target; a single one as it is."""
    return records[0] if len(records) == 1 else RecordsTarget(tuple(records))


def presses(target: object) -> tuple[RecordTarget, ...]:
    """Return the records of a target, none of one without."""
    if isinstance(target, RecordsTarget):
        return target.records
    return (target,) if isinstance(target, RecordTarget) else ()


def indenters(target: object) -> tuple[Indenter, ...]:
    """Return the objects that press in the records of a target, each once, the first one first."""
    return tuple(dict.fromkeys(each.indenter for each in presses(target))) or (PLATE,)

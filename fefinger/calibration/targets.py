"""Targets of a calibration: what a target offers, and the finger from which a fit starts."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Unknown, Values
from fefinger.scene import library, pawluk1997
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array
from fefinger.theory.lumped.spring import Spring
from fefinger.theory.relaxation import Prony


TOUCH = "x0"
"""Name of the position of first touch in a record."""


class LumpedLaw(NamedTuple):
    """The lumped model of a target, which starts its fit; top: its largest elastic force in N."""

    spring: Spring
    prony: Prony
    top: float


class Target(Protocol):
    """Data that a finger is fitted to: a record, or curves of force and relaxation."""

    @property
    def name(self) -> str:
        """Name of the data in messages."""

    @property
    def shows_ratio(self) -> bool:
        """Whether the data have the depth, which tells the modulus of the skin from the pulp's."""

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Unknowns of the data, besides those of the finger."""

    @property
    def lumped_law(self) -> LumpedLaw:
        """The lumped model of the same data."""

    def residual(self, law: ForceLaw, values: Values) -> Array:
        """Residuals (n,) of a force law, in standard deviations of the data."""

    def weighed(
        self, law: Callable[[Values], ForceLaw], unknowns: Sequence[Unknown], values: Values
    ) -> Self:
        """Return the target with the covariance of its data about the values of a fit."""

    def reach(self, law: ForceLaw, values: Values) -> float:
        """Largest depth in mm of the data."""

    def misfits(self, law: ForceLaw, values: Values) -> dict[str, float]:
        """Misfits by name."""

    def remarks(self, values: Values, *, finite: bool, with_frames: bool) -> tuple[str, ...]:
        """Sentences on parameters that the data do not identify."""

    def checks(self, law: ForceLaw) -> dict[str, dict[str, float]]:
        """Errors of predictions of data that were not fitted, by name."""

    def quality(self, residuals: dict[str, float]) -> str:
        """Say in a clause how close the fit is; `residuals` as of a Calibration."""

    @property
    def advice(self) -> str:
        """What to check where the misfit exceeds the scatter of the data, as a clause, or ""."""


def errors(measured: Array, model: Array) -> dict[str, float]:
    """Compute the squared error of Eq. 2.5 and the error at the peaks, both as fractions.

    The error at the peaks is the mean over the largest quarter of the forces.
    """
    about = float(np.sum((measured - measured.mean()) ** 2))
    high = measured >= np.quantile(measured, 0.75)
    peak = np.abs(model[high] - measured[high]).mean() / measured[high].mean()
    return {"mse": float(np.sum((model - measured) ** 2)) / about, "peak": float(peak)}


def finger_of(name: str | None, **values: Any) -> Finger:
    """Finger from which a fit starts: of a subject of Table 2.1, of its means, or of a size alone.

    Its shape is taken from the calibrated finger of the subject, or in proportion from the
    means. Its pulp is Maeno's (1998) and does not stiffen; its skin keeps its ratios to it.
    """
    row = pawluk1997.lumped().get(name or "")
    size = {} if row is None else {"width": row.width, "thickness": row.thickness}
    tissue = library.calibrated_name(name if name and row else pawluk1997.MEANS)
    pulp = library.tissue_set(library.PUBLISHED).subcutaneous
    layers = {"skin": library.prior_skin(pulp), "subcutaneous": pulp}
    given = {"tissue": tissue} | layers | size | values
    if name in (None, pawluk1997.MEANS):
        return Finger(**given)
    return Finger.subject(name, **given)

"""Targets of a calibration: the record of a user, frames of an array; what a target offers."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from scipy.linalg import solve_triangular

from fefinger.calibration import lumped_fit
from fefinger.calibration.curve import ForceLaw
from fefinger.calibration.inverse import Unknown, Values
from fefinger.scene import library, pawluk1997
from fefinger.scene.finger import Finger
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.theory.lumped import confidence
from fefinger.theory.lumped.identify import TERMS, Identification, joint
from fefinger.theory.lumped.ramp_hold import RampHold, averages, deviation_of, split
from fefinger.theory.lumped.spring import Spring, force
from fefinger.theory.relaxation import Prony


LIVELY = 1e-3
"""Smallest relative fall of the force in a hold that counts as relaxation."""

STIFFNESS = (0.02, 100.0)
"""Range in N/mm of a fingertip's stiffness at half of its largest force, with a wide margin."""

RETURN = 0.1
"""Smallest return of the indenter over its travel for a record to count as unloading."""

FEWEST = 4
"""Fewest samples of a motion to predict."""

ONE_G = 1e-3
"""Least standard deviation of a sample, over the largest force of a record.

A law with one G misses a finger whose stress relaxes at finite strain by about as much: 0.7e-3 in a
noise-free press by `solid`. Without it a record that is nearly free of noise, as a simulated one,
would be fitted in the hold alone, where all samples share one error of the mesh.
"""


TOUCH = "x0"
"""Name of the position of first touch in a record."""

BIAS = (
    "one G relaxes the force, where the stress relaxes and strain is finite: weights of a twin "
    "come back 2 to 3 % off, its exponent 4 %, its fastest rate 5 %, which their deviations do not "
    "count"
)
"""Bias of fits by `solid` (suite `calibration`, twin of solid)."""

RADIUS_KNOWN = (
    "modulus, exponent: their deviations take the pad radius as known; the record of a twin whose "
    "radius was 8 % smaller than that of the fit gave 0.85 of its modulus and 0.8 of its exponent"
)
"""Effect of a pad radius that no frames determine: `solid` on the coarse mesh, a finger 15 mm wide
and 11 mm thick, 1.6 mm deep, fitted with and without its own radius. Subjects scatter by 13 %."""

APART = 0.1
"""Difference in mm of two estimates of the touch above which it is reported."""


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
    def unknowns(self) -> tuple[Unknown, ...]:
        """Unknowns of the data, besides those of the finger."""

    @property
    def lumped_law(self) -> LumpedLaw:
        """The lumped model of the same data."""

    def residual(self, law: ForceLaw, values: Values) -> Array:
        """Residuals (n,) of a force law, in standard deviations of the data."""

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


@dataclass(frozen=True)
class RecordTarget:
    """Target of a user: averaged ramp and hold, with time s, position mm, force N and its sd N.

    All (n,). The standard deviation is the noise's, at least ONE_G; mesh: the
    resolution of the fitted model.
    """

    name: str
    record: RampHold
    lumped: Identification
    time: Array
    position: Array
    force: Array
    force_sd: Array
    mesh: str

    def residuals(self, force: Array) -> Array:
        """Whitened residuals (n,) of a model's force (n,) N, in standard deviations.

        The covariance holds noise and mesh error; whitening makes the residuals
        independent.
        """
        return np.asarray(solve_triangular(self._scatter, force - self.force, lower=True))

    @cached_property
    def _scatter(self) -> Array:
        """The Cholesky factor (n, n) N of the covariance of noise and of the mesh's error."""
        between = np.abs(np.subtract.outer(self.position, self.position))
        smooth = self._lumped_force()  # scaling by the noisy measured force would bias the fit
        alike = np.exp(-between / LENGTH) * np.multiply.outer(smooth, smooth)
        covariance = np.diag(self.force_sd**2) + MESH[self.mesh] ** 2 * alike
        return np.asarray(np.linalg.cholesky(covariance))

    @property
    def lumped_misfit(self) -> float:
        """Misfit of the lumped model, defined as in a `Stage`."""
        residuals = (self._lumped_force() - self.force) / self.force_sd
        # The weights of G sum to 1, so one of the parameters is not free.
        freedom = max(1, len(residuals) - len(self.lumped.parameters) + 1)
        return float(residuals @ residuals) / freedom

    @property
    def advice(self) -> str:
        """Causes of misfit that lie in the record."""
        return "; tare the force, and check for drift or a lag of the force"

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """The touch."""
        x0 = self.lumped.spring.x0
        touch = "bounds about the touch of the lumped fit"
        return (Unknown(TOUCH, x0 - 0.2, x0 - 2.0, x0 + 0.5, "mm", touch, log=False),)

    @property
    def lumped_law(self) -> LumpedLaw:
        """The lumped model of the record."""
        spring = self.lumped.spring
        return LumpedLaw(spring, self.lumped.prony, float(spring.force(self.position).max()))

    def residual(self, law: ForceLaw, values: Values) -> Array:
        """Whitened residuals (n,) of a force law, in standard deviations."""
        return self.residuals(self._loaded(law, values))

    def reach(self, law: ForceLaw, values: Values) -> float:
        """Largest depth in mm of the record."""
        return float(self.position.max() - values[TOUCH])

    def misfits(self, law: ForceLaw, values: Values) -> dict[str, float]:
        """Errors of the force, in N and as fractions."""
        model = self._loaded(law, values)
        rms = float(np.sqrt(np.mean((model - self.force) ** 2)))
        return {"force rms in N": rms} | errors(self.force, model)

    def checks(self, law: ForceLaw) -> dict[str, dict[str, float]]:
        """Return none: a check is another record."""
        return {}

    def quality(self, residuals: dict[str, float]) -> str:
        """Say how close the fit is."""
        return f"squared error {100 * residuals['mse']:.2g} % of the variance"

    def remarks(self, values: Values, *, finite: bool, with_frames: bool) -> tuple[str, ...]:
        """Sentences on parameters that the record does not identify."""
        lumped, sentences = self.lumped, list[str]()
        if len(lumped.prony.v) < TERMS:
            sentences.append(
                f"relaxation: the lumped fit of the record converges with {len(lumped.prony.v)} "
                f"of {TERMS} terms only, the priors determine the rest; ramp faster or hold longer"
            )
        sentences += [
            f"relaxation, in the lumped fit of the record: {each}"
            for each in confidence.terms(
                self.record, lumped.prony, lumped.uncertainty, "here the priors determine it"
            )
        ]
        x0 = lumped.spring.x0
        sentences += confidence.bias(self.record, lumped.prony, x0, lumped.uncertainty)
        if abs(values[TOUCH] - x0) >= APART:
            sentences.append(
                f"x0: this finger touches at {values[TOUCH]:.2g} mm, the lumped law of the same "
                f"record at {x0:.2g} mm: the touch depends on the model, which the deviation of x0 "
                "does not include"
            )
        if finite:
            sentences.append(f"exponent, c0, c1, v1 ...: {BIAS}")
            if not with_frames:
                sentences.append(RADIUS_KNOWN)
        return tuple(sentences)

    def _loaded(self, law: ForceLaw, values: Values) -> Array:
        return law.loading(self.time, self.position - values[TOUCH])

    def _lumped_force(self) -> Array:
        return force(self.lumped.spring, self.lumped.prony, self.time, self.position)


MESH = {"coarse": 4.3e-3, "standard": 3e-3, "fine": 3e-3}
"""Relative standard deviation of a force due to the model's mesh, by resolution.

For coarse meshes from `reports/mesh-curves.json`, by presses on meshes that were generated again.
For standard ones it is 1e-3 there, but new presses of calibrated fingers by `solid` differ from
the fitted curves by 0.5e-3 to 3.5e-3 (suite `calibration`). Another set of meshes gave 4.5e-3 and
1.3e-3, and 0.3 and 0.44 mm for LENGTH. Two of 31 earlier coarse meshes were 2 % stiffer, which is
not explained.
"""

LENGTH = 0.3
"""Correlation length in mm of depth of the mesh error: exp(-distance / LENGTH).

0.36 mm on coarse meshes, 0.22 mm on standard ones, in that report. All samples of a hold share one
error, so that it does not affect the relaxation.
"""


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


def record(file: str | Path, mesh: str, columns: Mapping[str, str] | None = None) -> RecordTarget:
    """Read and check the target in a file of time, position and force.

    `mesh` is the resolution of the model to be fitted; `columns` as of `lumped_fit.read`.

    Raises InputError if the file has no usable ramp and hold, other units, or a response unlike a
    finger's.
    """
    return made(str(file), *lumped_fit.read(file, columns=columns), mesh)


def made(name: str, time: Array, position: Array, force: Array, mesh: str) -> RecordTarget:
    """Make the target of a record (n_t,) s, mm, N, called `name` in messages."""
    try:
        parts = split(time, position, force)
        lumped = _lumped(time, position, force)
    except ValueError as error:
        raise InputError(f"{name}: {error}") from None
    except RuntimeError:
        raise InputError(
            f"{name}: expected a force that rises on the ramp and falls in the hold, received one "
            "for which the fit of the lumped law of the thesis does not converge; check that this "
            f"is a finger, and that its hold of {parts.hold_seconds:.3g} s is long enough to relax"
        ) from None
    _check_finger(name, parts, lumped)
    t, x, f, size = averages(parts)
    least = ONE_G * float(f.max()) / np.sqrt(size)
    sd = np.maximum(deviation_of(parts, lumped.spring, lumped.prony), least)
    return RecordTarget(name, parts, lumped, t, x, f, sd, mesh)


def _lumped(time: Array, position: Array, force: Array) -> Identification:
    """Fit the lumped law to a record, with fewer terms where a slow ramp does not show them all."""
    for terms in range(TERMS, 1, -1):
        with suppress(RuntimeError):
            return joint(time, position, force, terms=terms)
    return joint(time, position, force, terms=1)


def check_depth(wanted: RecordTarget, finger: Finger) -> None:
    """Raise InputError for a record that is deeper than the soft tissue of the finger."""
    deep = float(wanted.position.max()) - wanted.lumped.spring.x0
    if deep >= finger.pulp:
        raise InputError(
            f"{wanted.name}: position: expected a press of less than {finger.pulp:.3g} mm, the "
            f"tissue under the pad (half of the thickness, {finger.thickness:g} mm), received one "
            f"that goes {deep:.3g} mm beyond touch; check the size of the finger and the unit"
        )


def unloading(
    file: str | Path, columns: Mapping[str, str] | None = None
) -> tuple[Array, Array, Array]:
    """Read time s, position mm and force N, each (n,), of a record with unloading, for prediction.

    Raises InputError as `lumped_fit.read`, or if the indenter does not return.
    """
    time, position, force = lumped_fit.read(
        file, fewest=FEWEST, of="a motion to predict", columns=columns
    )
    top = int(np.argmax(position))
    way = float(position[top] - position[0])
    back = float(position[top] - position[top:].min())
    if back < RETURN * way:
        raise InputError(
            f"{file}: expected a record with unloading, such as a sinusoid or a retraction, as "
            f"loading was fitted, received one that returns {back:.3g} of {way:.3g} mm"
        )
    return time, position, force


def _check_finger(name: str, parts: RampHold, lumped: Identification) -> None:
    """Raise InputError for a response unlike a finger's: no relaxation, or another stiffness.

    The stiffness comes from the fit `lumped`.
    """
    hold = parts.force[parts.hold :]
    early = float(hold[: max(5, len(hold) // 50)].mean())
    late = float(hold[-len(hold) // 5 :].mean())
    if late > (1 - LIVELY) * early:
        raise InputError(
            f"{name}: expected a force that falls in the hold, because a finger relaxes, received "
            f"{early:.4g} N at its start and {late:.4g} N at its end; check that this is a finger "
            "and that the force is the right column"
        )
    half = float(lumped.spring.stiffness(0.5 * parts.force.max()))
    low, high = STIFFNESS
    if not low <= half <= high:
        raise InputError(
            f"{name}: expected a stiffness of {low:g} to {high:g} N/mm at half of the largest "
            f"force, received {half:.3g} N/mm, which no fingertip has; check what was pressed, and "
            "the units"
        )

"""Targets of a calibration, the finger from which a fit starts, and the residuals of its force."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Protocol, Self

import numpy as np

from fefinger.calibration.curve import Curve, Family, ForceLaw
from fefinger.calibration.inverse import Unknown, Values
from fefinger.scene import library
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
        """Unknowns of the data, besides the unknowns of the finger."""

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
    row = library.lumped().get(name or "")
    size = {} if row is None else {"width": row.width, "thickness": row.thickness}
    tissue = library.calibrated_name(name if name and row else library.MEANS)
    pulp = library.tissue_set(library.PUBLISHED).subcutaneous
    layers = {"skin": library.prior_skin(pulp), "subcutaneous": pulp}
    given = {"tissue": tissue} | layers | size | values
    if name in (None, library.MEANS):
        return Finger(**given)
    return Finger.subject(name, **given)


MODULUS, SHAPE, RATIO, RADIUS = "modulus", "exponent", "skin_ratio", "pad_radius"
GAIN, GROWTH = "t_b", "t_m"

SHARE_SD, RATE_SD = 0.35, 1.0
"""Standard deviations of the logarithms of ci / c0 and vi: the scatter of Table 3.1, widened."""

MODULUS_SD = math.log(4.0)
"""Standard deviation of the logarithm of a modulus at first touch: published moduli are of layers
that do not stiffen, at strains where a law with the fitted exponents is 2 to 4 times stiffer."""

RATIO_SD = 0.6  # of the logarithm of the ratio of the moduli: a factor 1.8

PULP = "18 kPa (Dandekar 2003) to 50 kPa (Saal 2017), about 34 kPa (Maeno 1998): a factor 4"
SKIN = "3 (Maeno 1998) to 10 (Dandekar 2003): a factor 1.8 about the latter"
GIVEN = "the tissue of the finger that was given"
"""Sources of the priors of the moduli: published tissue, or another that a fit starts from."""

RADII = (5.0, 40.0)
"""Pad radii in mm that a finger may have."""

FRAMES = "the frames of the array, by the thesis's fit; its scatter and the mesh are the prior"


def relaxation_unknowns(name: str) -> tuple[Unknown, ...]:
    """Unknowns of G, with priors from Table 3.1, of a subject or of the means."""
    table = library.relaxation()
    prony = table.get(name, table["means"])
    weights = prony.weights
    source = "Table 3.1 of Pawluk (1997), with the scatter of its five subjects"
    unknowns = [
        Unknown(
            f"c{i}/c0", c / weights[0], 1e-3, 1e2, "1", source, prior=(c / weights[0], SHARE_SD)
        )
        for i, c in enumerate(weights[1:], start=1)
    ]
    unknowns += [
        Unknown(f"v{i}", v, 1e-2, 1e4, "1/s", source, prior=(v, RATE_SD))
        for i, v in enumerate(prony.v, start=1)
    ]
    return tuple(unknowns)


def prony_of(values: Values) -> Prony:
    """Make G from the values of `relaxation_unknowns`, fastest term first."""
    count = sum(name.endswith("/c0") for name in values)
    shares = np.array([1.0, *(values[f"c{i}/c0"] for i in range(1, count + 1))])
    rates = [values[f"v{i}"] for i in range(1, count + 1)]
    order = np.argsort(rates)[::-1]
    weights = shares / shares.sum()
    return Prony(
        (weights[0], *(float(weights[1 + i]) for i in order)), tuple(rates[i] for i in order)
    )


@dataclass(frozen=True)
class Forces:
    """The residual of a target for the curves of a family at one pad radius.

    modulus kPa and ratio: subcutaneous modulus of the presses, and the skin's over it;
    radius mm, and its standard deviation where frames gave it, which adds to all others.
    """

    target: Target
    family: Family
    modulus: float
    ratio: float
    radius: float
    radius_sd: float | None = None

    @property
    def unknowns(self) -> tuple[Unknown, ...]:
        """Unknowns of finger and target."""
        unknowns = self._elastic_unknowns + self.target.unknowns
        if self.radius_sd is not None:
            prior = (self.radius, self.radius_sd / self.radius)
            radius = Unknown(RADIUS, self.radius, *RADII, "mm", FRAMES, prior=prior)
            unknowns += (replace(radius, held=True, elsewhere=True),)
        return unknowns + relaxation_unknowns(self.target.name)

    @property
    def _elastic_unknowns(self) -> tuple[Unknown, ...]:
        """Unknowns of the relaxed curve: moduli and exponent, or the t(u) of the thesis."""
        shapes = self.family.shapes
        if len(shapes) == 1:
            return (
                Unknown(GAIN, 1.0, 1e-3, 1e3, "1/mm", "bounds alone"),
                Unknown(GROWTH, 1.0, 0.0, 10.0, "1/mm", "bounds alone", log=False),
            )
        published = library.tissue_set(library.PUBLISHED).subcutaneous.modulus
        soft = PULP if math.isclose(self.modulus, published) else f"{GIVEN}: a factor 4"
        solved = "bounds alone, those of the presses that were solved"
        stiff = SKIN if math.isclose(self.ratio, library.SKIN_RATIO) else f"{GIVEN}: a factor 1.8"
        modulus, ratio = (self.modulus, MODULUS_SD), (self.ratio, RATIO_SD)
        held = not self.target.shows_ratio
        return (
            Unknown(MODULUS, self.modulus, 0.3, 2e3, "kPa", soft, prior=modulus),
            Unknown(SHAPE, 3.0, max(shapes[0], 0.02), shapes[-1], "1", solved, log=False),
            Unknown(RATIO, self.ratio, 1.0, 60.0, "1", stiff, prior=ratio, held=held),
        )

    def starts(self) -> list[Values]:
        """Make starts at several shapes of the law, with moduli that match the target's force.

        They have the G of the target's lumped model; one has the G of the priors too.
        """
        if len(self.family.shapes) == 1:
            shapes: Sequence[float] = (0.3, 1.5)
        else:
            low, high = self.family.shapes[0], self.family.shapes[-1]
            shapes = np.linspace(low, high, 5)[1:4].tolist()
        begun = [self._start(shape) for shape in shapes]
        return [each | self._relaxing for each in begun] + begun[1:2]

    @property
    def _relaxing(self) -> Values:
        """G of the target's lumped model; {} where it has fewer terms, or a term beyond bounds."""
        prony = self.target.lumped_law.prony
        asked = relaxation_unknowns(self.target.name)
        if len(prony.v) + len(prony.weights[1:]) != len(asked):
            return {}
        shares = np.array(prony.weights[1:]) / prony.weights[0]
        found = [*shares.tolist(), *prony.v]
        if not all(e.low < x < e.high for e, x in zip(asked, found, strict=True)):
            return {}
        return {each.name: value for each, value in zip(asked, found, strict=True)}

    def law(self, values: Values) -> ForceLaw:
        """Evaluate the force law of the values."""
        curve, factor = self._curve(self.family, values)
        others = {
            indenter: self._curve(each, values)[0] for indenter, each in self.family.others.items()
        }
        return ForceLaw(curve, prony_of(values), factor, others)

    def residual(self, values: Values) -> Array:
        """Compute the residuals (n_residuals,) in standard deviations of the data."""
        return self.target.residual(self.law(values), values)

    def weighed(self, values: Values) -> Self:
        """Return the residual with the covariance of the data about the values of a fit."""
        return replace(self, target=self.target.weighed(self.law, self.unknowns, values))

    def _curve(self, family: Family, values: Values) -> tuple[Curve, float]:
        """Evaluate the relaxed curve of the values in a family, and the factor on its force."""
        radius = values.get(RADIUS, self.radius)
        if len(family.shapes) == 1:
            return family.at(values[GROWTH], radius), values[GAIN]
        ratio = values.get(RATIO, self.ratio) / self.ratio
        return family.at(values[SHAPE], radius, ratio), values[MODULUS] / self.modulus

    def _start(self, shape: float) -> Values:
        """Make the start at a shape of the law, with a modulus from the target's largest force."""
        solid = len(self.family.shapes) > 1
        values = {SHAPE: shape, MODULUS: self.modulus} if solid else {GROWTH: shape, GAIN: 1.0}
        curve, _ = self._curve(self.family, values)
        spring, prony, top = self.target.lumped_law
        depth = min(float(spring.position(top)) - spring.x0 + 0.2, 0.8 * curve.deepest)
        factor = prony.long_time * top / float(curve.force(depth))
        if solid:
            return {SHAPE: shape, MODULUS: float(np.clip(factor * self.modulus, 0.5, 1e3))}
        return {GROWTH: shape, GAIN: float(np.clip(factor, 2e-3, 5e2))}

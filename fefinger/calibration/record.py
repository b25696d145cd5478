"""Record of a calibration: parameters with uncertainty and prior, misfits, and its files."""

import json
import math
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import UnionType
from typing import Any, Self, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import ArrayLike

from fefinger.calibration.curve import Curve, ForceLaw
from fefinger.calibration.inverse import Solution
from fefinger.results.candidate import MECHANICS
from fefinger.scene.tissue import Tissue
from fefinger.support import atomic_write
from fefinger.support.arrays import Array
from fefinger.support.atomic_write import keep
from fefinger.support.checks import InputError, shown
from fefinger.support.inputs import read_json
from fefinger.support.text import table
from fefinger.theory.relaxation import Prony


LIMIT = 1.96
"""Standard deviations of a normal distribution to the limits that hold 95 % of it."""

FILE, TISSUE_FILE, PAGE_FILE = "calibration.json", "tissue.toml", "calibration.html"

LENGTHS = ("width", "thickness", "pad_radius", "tip_radius", "tip_tissue")
"""Lengths in mm of the finger that a tissue file keeps, where they are given."""


@dataclass(frozen=True)
class Parameter:
    """A calibrated parameter with its uncertainty, prior and bounds.

    value and standard deviation in `unit`; prior: center, and its standard deviation (see
    `Unknown`), with the source; bounds; how: "fitted", or "held" where the data do not determine
    it; scale: "linear", "log" or "logit", on which its error is nearly normal.
    """

    name: str
    value: float
    sd: float
    unit: str
    prior: tuple[float, float] | None
    source: str
    bounds: tuple[float, float]
    how: str
    scale: str = "linear"

    @property
    def interval(self) -> tuple[float, float]:
        """Limits that hold the parameter with a probability of 95 %."""
        middle, sd = self._scaled(self.value), self._scaled_sd
        low, high = middle - LIMIT * sd, middle + LIMIT * sd
        if self.scale == "log":
            return math.exp(low), math.exp(high)
        if self.scale == "logit":
            return 1 / (1 + math.exp(-low)), 1 / (1 + math.exp(-high))
        return low, high

    def score(self, value: float) -> float:
        """Return by how many standard deviations the parameter is above another value."""
        return (self._scaled(self.value) - self._scaled(value)) / self._scaled_sd

    @property
    def _scaled_sd(self) -> float:
        if self.scale == "log":
            return self.sd / self.value
        if self.scale == "logit":
            return self.sd / (self.value * (1 - self.value))
        return self.sd

    def _scaled(self, value: float) -> float:
        if self.scale == "log":
            return math.log(value)
        if self.scale == "logit":
            return math.log(value / (1 - value))
        return value


@dataclass(frozen=True)
class Stage:
    """One stage of a calibration: its cost and its misfit.

    cpu: seconds in this run; presses: number of presses used, from the cache or solved, and
    presses_cpu the seconds that they took when they were solved; misfit: sum of squares over the
    degrees of freedom, 1 where noise explains it, None where nothing is fitted.
    """

    name: str
    cpu: float
    presses: int
    presses_cpu: float
    misfit: float | None


@dataclass(frozen=True)
class PressFit:
    """A press and what the calibration makes of it, by averages (n,) of its samples, for a page.

    time s; depth mm; force and model N; noise N: standard deviations of the averages by the noise
    of both channels, () where it is not known; spread N: with errors of the model; marks: times s
    of faults of the record, with a name; held_out: predicted, not fitted.
    """

    name: str
    time: tuple[float, ...]
    depth: tuple[float, ...]
    force: tuple[float, ...]
    model: tuple[float, ...]
    noise: tuple[float, ...] = ()
    spread: tuple[float, ...] = ()
    marks: tuple[tuple[float, str], ...] = ()
    held_out: bool = False


@dataclass(frozen=True)
class Calibration:
    """A finger fitted to a subject or a record.

    target and mechanics: names; finger: LENGTHS mm, resolution;
    parameters; correlations (n, n) of them, in their order; residuals: misfits by name;
    unidentified: sentences; stages; status: one sentence; skin, subcutaneous: the layers; prony: G;
    deepest mm, q, shares and growth: the relaxed curve (see `Curve`); checks: predictions of what
    was not fitted, by name; findings: sentences on the record and its rig; presses: those
    that were fitted, and one that was held out.
    """

    target: str
    mechanics: str
    finger: dict[str, Any]
    parameters: tuple[Parameter, ...]
    correlations: tuple[tuple[float, ...], ...]
    residuals: dict[str, float]
    unidentified: tuple[str, ...]
    stages: tuple[Stage, ...]
    status: str
    skin: dict[str, Any]
    subcutaneous: dict[str, Any]
    prony: Prony
    deepest: float
    q: tuple[float, ...]
    shares: tuple[tuple[float, ...], ...]
    growth: float | None
    checks: dict[str, dict[str, float]] = field(default_factory=dict)
    findings: tuple[str, ...] = ()
    presses: tuple[PressFit, ...] = ()

    def __repr__(self) -> str:
        """Show parameters, misfits, stages and what is not identified, not the curve."""
        rows = [
            [
                each.name,
                f"{each.value:.4g} +- {each.sd:.2g}",
                each.unit,
                "-" if each.prior is None else f"{each.prior[0]:.4g}",
                each.how,
            ]
            for each in self.parameters
        ]
        stages = [
            [
                each.name,
                f"{each.cpu:.1f}",
                f"{each.presses} of {each.presses_cpu:.1f}" if each.presses else "-",
                "-" if each.misfit is None else f"{each.misfit:.3g}",
            ]
            for each in self.stages
        ]
        misfits = [[name, f"{value:.4g}"] for name, value in self.residuals.items()]
        misfits += [
            [
                name if "not fitted" in name else f"{name}, not fitted",
                f"mse {100 * errors['mse']:.2g} %, peaks {100 * errors['peak']:.2g} %",
            ]
            for name, errors in self.checks.items()
        ]
        parts = [
            self.status,
            table(rows, ("", "value +- one sd", "unit", "prior", "")),
            table(misfits, ("", "")),
            table(stages, ("stage", "CPU s", "presses, CPU s", "misfit")),
        ]
        parts += [f"record: {each}" for each in self.findings]
        return "\n".join([*parts, *(f"not identified: {each}" for each in self.unidentified)])

    def __getitem__(self, name: str) -> Parameter:
        """Return the parameter called `name`; KeyError lists the names that exist."""
        named = {each.name: each for each in self.parameters}
        if name not in named:
            raise KeyError(f"{name!r}: expected one of the parameters {', '.join(named)}")
        return named[name]

    @property
    def curve(self) -> Curve:
        """The relaxed force in N against the depth in mm."""
        return Curve(np.array(self.q), self.deepest, np.array(self.shares), self.growth)

    @property
    def law(self) -> ForceLaw:
        """The force at any rate."""
        return ForceLaw(self.curve, self.prony)

    def predict(self, time: ArrayLike, depth: ArrayLike) -> Array:
        """Predict the force (n_t,) N of any motion with depths (n_t,) mm from first touch.

        Unloading, detachment and renewed contact are included.
        """
        return self.law.predicted(np.asarray(time, float), np.asarray(depth, float))

    def record(self) -> dict[str, object]:
        """Convert the calibration to plain values."""
        return asdict(self)

    def tissue_set(self) -> dict[str, object]:
        """Make the tables of a tissue file, as read by `[finger] tissue = "tissue.toml"`."""
        values: dict[str, Any] = {
            "source": f"fefinger calibrate: {self.target}, through {self.mechanics}; a fit of a "
            "model, not a measurement of tissue",
            "confidence": "low",
            **{name: value for name, value in self.finger.items() if name in LENGTHS and value},
            "prony": {"c": list(self.prony.c), "v": list(self.prony.v)},
        }
        return values | {"skin": self.skin, "subcutaneous": self.subcutaneous}

    def save(self, folder: str | Path) -> list[str]:
        """Write `calibration.json` and, for `solid`, `tissue.toml` into an existing folder.

        InputError where they cannot be written, or where files of these names are not those of a
        calibration.
        """
        import tomli_w

        keep_others(Path(folder))
        texts = {FILE: json.dumps(self.record(), indent=1) + "\n"}
        if MECHANICS[self.mechanics].finite:
            texts[TISSUE_FILE] = tomli_w.dumps(self.tissue_set())
        atomic_write.write(folder, texts)
        return [str(Path(folder) / name) for name in texts]

    @classmethod
    def load(cls, file: str | Path) -> Self:
        """Read a `calibration.json`, or the one in a folder.

        Raises
        ------
        InputError
            A file that is none.
        """
        path = Path(file)
        path = path / FILE if os.path.isdir(path) else path
        try:
            return cls.from_record(read_json(path))
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            msg = f"{path}: expected a {FILE} that `fefinger calibrate -o` wrote ({error})"
            raise InputError(msg) from None

    @classmethod
    def from_record(cls, values: dict[str, object]) -> Self:
        """Make a calibration from the plain values of `record`."""
        fields = {name: _tuples(value) for name, value in values.items()}
        fields["parameters"] = tuple(
            Parameter(**{name: _tuples(value) for name, value in each.items()})
            for each in fields["parameters"]
        )
        fields["stages"] = tuple(Stage(**each) for each in fields["stages"])
        fields["presses"] = tuple(
            PressFit(**{name: _tuples(value) for name, value in each.items()})
            for each in fields.get("presses", ())
        )
        fields["prony"] = Prony(**fields["prony"])
        found = cls(**fields)
        for record in (found, *found.parameters, *found.stages, *found.presses):
            for name, hint in get_type_hints(type(record)).items():
                if not _is_of_type(getattr(record, name), hint):
                    message = f"{name}: {shown(getattr(record, name))} where {hint} belongs"
                    raise TypeError(message)
        return found


def keep_others(folder: Path) -> None:
    """Raise InputError where files of a calibration's names in a folder come from elsewhere."""
    present = [name for name in (FILE, TISSUE_FILE, PAGE_FILE) if (folder / name).exists()]
    if FILE in present:
        with suppress(InputError):
            Calibration.load(folder)
            present = []
    keep(present, folder, "calibration")


def _is_of_type(value: object, hint: Any) -> bool:
    """Say whether a value read from JSON is of a type; whole numbers are floats too."""
    origin, parts = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (UnionType, Union):
        return any(_is_of_type(value, part) for part in parts)
    if hint is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if origin is dict:
        return isinstance(value, dict) and all(_is_of_type(x, parts[1]) for x in value.values())
    if origin is tuple:
        if not isinstance(value, tuple):
            return False
        expected = parts[:1] * len(value) if parts[-1] is Ellipsis else parts
        return len(value) == len(expected) and all(map(_is_of_type, value, expected))
    return isinstance(value, hint)


def _tuples(value: object) -> Any:
    """Convert nested lists to tuples."""
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def parameters_of(
    solution: Solution,
) -> tuple[tuple[Parameter, ...], tuple[tuple[float, ...], ...]]:
    """Return the parameters of a solution, and their correlations (n, n).

    They have the weights of G, after all others, instead of their ratios to c0.
    """
    unchanged = [i for i, each in enumerate(solution.unknowns) if not each.name.endswith("/c0")]
    parameters = [
        Parameter(
            each.name,
            solution.values[each.name],
            solution.deviations[each.name],
            each.unit,
            each.prior,
            each.source,
            (each.low, each.high),
            "held" if each.held else "fitted",
            "log" if each.log else "linear",
        )
        for each in (solution.unknowns[i] for i in unchanged)
    ]
    weights, by_unknowns = _weights(solution)
    jacobian = np.concatenate([np.eye(len(solution.unknowns))[unchanged], by_unknowns])
    covariance = jacobian @ solution.covariance @ jacobian.T
    deviation = np.sqrt(np.diag(covariance))
    source = "the weights sum to 1; priors of their ratios from Table 3.1 of Pawluk (1997)"
    of_weights = zip(weights.tolist(), deviation[len(unchanged) :].tolist(), strict=True)
    parameters += [
        Parameter(f"c{i}", c, sd, "1", None, source, (0.0, 1.0), "fitted", "logit")
        for i, (c, sd) in enumerate(of_weights)
    ]
    correlations = (covariance / np.outer(deviation, deviation)).tolist()
    return tuple(parameters), tuple(map(tuple, correlations))


def _weights(solution: Solution) -> tuple[Array, Array]:
    """Compute c0, c1, ... and their derivatives (n, n_unknowns) by the fitted numbers."""
    at = [i for i, each in enumerate(solution.unknowns) if each.name.endswith("/c0")]
    shares = np.array([1.0, *(solution.values[solution.unknowns[i].name] for i in at)])
    weights = shares / shares.sum()
    jacobian = np.zeros((len(weights), len(solution.unknowns)))
    jacobian[:, at] = -np.outer(weights, weights[1:])
    jacobian[1:, at] += np.diag(weights[1:])
    return weights, jacobian


def plain(values: Array) -> tuple[float, ...]:
    """Convert values (n,) to numbers of six digits."""
    return tuple(float(f"{value:.6g}") for value in values.tolist())


def tissue(law: Tissue) -> dict[str, object]:
    """Convert a layer to plain values, without fields that are None and empty tables."""
    return {
        name: dict(value) if isinstance(value, Mapping) else value
        for name, value in asdict(law).items()
        if value is not None and value != {}
    }

"""What a calibration found: parameters with their uncertainty and prior, misfits, and its files."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fefinger.calibration.curve import Curve
from fefinger.calibration.force import predicted
from fefinger.calibration.inverse import Solution
from fefinger.results.candidate import MECHANICS
from fefinger.scene.tissue import Tissue
from fefinger.support import atomic_write
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


Array = NDArray[np.float64]

FILE, TISSUE_FILE = "calibration.json", "tissue.toml"


@dataclass(frozen=True)
class Parameter:
    """One parameter.

    value and standard deviation in `unit`; prior: center, and its standard deviation (see
    `Unknown`), with the source; bounds; how: "fitted", or "held" where the curves do not decide it.
    """

    name: str
    value: float
    sd: float
    unit: str
    prior: tuple[float, float] | None
    source: str
    bounds: tuple[float, float]
    how: str


@dataclass(frozen=True)
class Stage:
    """One rung: what it needed and how well it met the target.

    cpu seconds in this run; solved: presses solved and kept, whose cpu seconds, whenever they were
    spent, are `presses_cpu`; misfit: what is missed over what the data allow, 1 where all is noise,
    None where nothing is fitted.
    """

    name: str
    cpu: float
    presses: int
    presses_cpu: float
    misfit: float | None


@dataclass(frozen=True)
class Calibration:
    """A finger that was fitted to a subject or a record.

    target and mechanics: names; finger: width and thickness mm, pad_radius mm, resolution;
    parameters; correlations (n, n) of them, in their order; residuals: misfits by name;
    unidentified: sentences; stages; status: one sentence; skin, subcutaneous: the layers; prony: G;
    deepest mm, q, shares and growth: the relaxed curve (see `Curve`); checks: predictions of what
    was not fitted, by name.
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

    def __getitem__(self, name: str) -> Parameter:
        """Return the parameter called `name`; KeyError names those that there are."""
        named = {each.name: each for each in self.parameters}
        if name not in named:
            msg = f"{name!r}: expected one of the parameters {', '.join(named)}"
            raise KeyError(msg)
        return named[name]

    @property
    def curve(self) -> Curve:
        """The relaxed force in N against the depth in mm."""
        return Curve(np.array(self.q), self.deepest, np.array(self.shares), self.growth)

    def predict(self, time: ArrayLike, depth: ArrayLike) -> Array:
        """Return the force (n_t,) N through any motion, with depths (n_t,) mm from first touch.

        Unloading, detachment and touching again included.
        """
        return predicted(
            self.curve, 1.0, self.prony, np.asarray(time, float), np.asarray(depth, float)
        )

    def record(self) -> dict[str, Any]:
        """Return all of it as plain values."""
        return asdict(self)

    def tissue_set(self) -> dict[str, Any]:
        """Return the tables of a tissue file, as `[finger] tissue = "tissue.toml"` reads it."""
        values: dict[str, Any] = {
            "source": f"fefinger calibrate: {self.target}, through {self.mechanics}; a fit of a "
            "model, not a measurement of tissue",
            "confidence": "low",
            "pad_radius": self.finger["pad_radius"],
            "prony": {"c": list(self.prony.c), "v": list(self.prony.v)},
        }
        return values | {"skin": self.skin, "subcutaneous": self.subcutaneous}

    def save(self, folder: str | Path) -> list[str]:
        """Write `calibration.json` and, for `solid`, `tissue.toml` into an existing folder."""
        import tomli_w

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
        path = path / FILE if path.is_dir() else path
        try:
            return cls.from_record(json.loads(path.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError, KeyError) as error:
            msg = f"{path}: expected a {FILE} that `fefinger calibrate -o` wrote ({error})"
            raise InputError(msg) from None

    @classmethod
    def from_record(cls, values: dict[str, Any]) -> Self:
        """Return the calibration of what `record` gave."""
        own = dict(values)
        own["parameters"] = tuple(
            Parameter(
                **each
                | {
                    "bounds": tuple(each["bounds"]),
                    "prior": None if each["prior"] is None else tuple(each["prior"]),
                }
            )
            for each in own["parameters"]
        )
        own["stages"] = tuple(Stage(**each) for each in own["stages"])
        for name in ("correlations", "shares"):
            own[name] = tuple(tuple(row) for row in own[name])
        own["prony"] = Prony(own["prony"]["c"], own["prony"]["v"])
        for name in ("unidentified", "q"):
            own[name] = tuple(own[name])
        return cls(**own)


def parameters_of(found: Solution) -> tuple[Parameter, ...]:
    """Return the parameters of a solution, with the weights of G instead of their ratios to c0."""
    out = [
        Parameter(
            each.name,
            found.values[each.name],
            found.deviations[each.name],
            each.unit,
            each.prior,
            each.source,
            (each.low, each.high),
            "held" if each.held else "fitted",
        )
        for each in found.unknowns
        if not each.name.endswith("/c0")
    ]
    weights, deviations = weights_of(found)
    source = "the weights sum to 1; priors of their ratios from Table 3.1 of Pawluk (1997)"
    out += [
        Parameter(f"c{i}", c, sd, "1", None, source, (0.0, 1.0), "fitted")
        for i, (c, sd) in enumerate(zip(weights, deviations, strict=True))
    ]
    return tuple(out)


def weights_of(found: Solution) -> tuple[list[float], list[float]]:
    """Return c0, c1, ... and their standard deviations, from the ratios to c0."""
    weights, jacobian = _weights(found)
    deviations = np.sqrt(np.diag(jacobian @ found.covariance @ jacobian.T))
    return weights.tolist(), deviations.tolist()


def correlations_of(found: Solution) -> tuple[tuple[float, ...], ...]:
    """Return the correlations (n, n) of `parameters_of`, in its order."""
    kept = [i for i, each in enumerate(found.unknowns) if not each.name.endswith("/c0")]
    jacobian = np.concatenate([np.eye(len(found.unknowns))[kept], _weights(found)[1]])
    covariance = jacobian @ found.covariance @ jacobian.T
    deviation = np.sqrt(np.diag(covariance))
    return tuple(tuple(row) for row in (covariance / np.outer(deviation, deviation)).tolist())


def _weights(found: Solution) -> tuple[Array, Array]:
    """Return c0, c1, ... and their derivatives (n, n_unknowns) by what was searched for."""
    at = [i for i, each in enumerate(found.unknowns) if each.name.endswith("/c0")]
    shares = np.array([1.0, *(found.values[found.unknowns[i].name] for i in at)])
    weights = shares / shares.sum()
    jacobian = np.zeros((len(weights), len(found.unknowns)))
    jacobian[:, at] = -np.outer(weights, weights[1:])
    jacobian[1:, at] += np.diag(weights[1:])
    return weights, jacobian


def tissue(law: Tissue) -> dict[str, Any]:
    """Return a layer as plain values, without what it has not."""
    return {name: value for name, value in asdict(law).items() if value is not None}

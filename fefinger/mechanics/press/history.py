"""The solved contact of a press, and the frames at which its fields are kept."""

from dataclasses import dataclass

import numpy as np

from fefinger.fem.body import Reduced
from fefinger.fem.contact.deformed_gap import ContactSurface
from fefinger.fem.contact.viscoelastic import History
from fefinger.mechanics.press.load_steps import LoadSteps
from fefinger.neural.reference import Reference
from fefinger.support.arrays import Array, Integers


TANGENT_SOLVER = "single"
"""The solver of tangents; in double precision where that fails, which a note says."""

FRAMES_MOVING, FRAMES_RESTING = 20, 6


@dataclass(frozen=True)
class SmallStrainHistory:
    """A press solved at small strain, at all times of the answer.

    reduced: the body under unit loads on the candidate vertices; contact: their pressure through
    time; reference: the press that scales strain for the afferents.
    """

    reduced: Reduced
    contact: History
    reference: Reference | None


@dataclass(frozen=True)
class FiniteStrainHistory:
    """A press solved at finite strain, at load steps.

    contact: the candidates and their gaps; steps: the n load steps that were solved, among the
    times of the answer; depth (n,) mm; pressure kPa (n, n_candidates); gap and moved mm (n,
    n_seen), the latter in three components; moment (n, 3) mN mm of the meshed part; strain (n,
    n_sites, 3, 3); frames: whole states by number of the step; reference: the press that scales
    strain for the afferents; iterations, descents, factors: the work; halt: why it ended before the
    motion, or nothing.
    """

    contact: ContactSurface
    steps: LoadSteps
    depth: Array
    pressure: Array
    gap: Array
    moved: Array
    moment: Array
    strain: Array
    frames: dict[int, Array]
    reference: Reference | None
    iterations: int
    descents: int
    factors: int
    halt: str


def frames_of(depth: Array, peak: int) -> Integers:
    """Choose frames that share the path of the indenter, a few of its rests, and the peak."""
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(depth)))])
    moving = np.searchsorted(path, np.linspace(0, path[-1], FRAMES_MOVING))
    evenly = np.linspace(0, len(depth) - 1, FRAMES_RESTING).round()
    return np.unique(np.concatenate([moving, evenly, [peak]]).astype(np.int64))

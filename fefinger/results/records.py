"""Records of the candidates for a scene and of a response: Refusal, Rung, Response and its parts.

All are frozen.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.results.harmonic import Harmonic
from fefinger.support.arrays import Array, Integers
from fefinger.support.text import outline


if TYPE_CHECKING:
    from fefinger.neural.drives import Reference


@dataclass(frozen=True)
class Refusal:
    """Reason against a mechanics for a scene.

    `about` is "ability" (it cannot answer at all), "accuracy" (it can, but worse than requested) or
    "time" (it can, but takes longer than requested); `reason` quotes the number that broke, as in
    "contact radius / thickness = 0.9 > 0.1". `field` is the field or part of the scene to change,
    such as "ask.rel_error", "indenter.radius" or "finger"; "" where there is none, and in results
    of earlier versions.
    """

    mechanics: str
    about: str
    reason: str
    field: str = ""


@dataclass(frozen=True)
class Rung:
    """One mechanics on the ladder, on one mesh where it has one.

    `seconds`: expected CPU time on this machine, by which candidates are ranked; `wall`: expected
    wall time on its cores (the CPU time where they do not share the work); `error`: expected
    relative error of the force, the largest through time, over its peak; all nan where it cannot
    answer or was not considered; `evidence`: the report that measured the error; `errors`: of the
    highest "pressure" over 1 mm², the contact "area" and the "strain" at the end organs, where the
    force is largest; an error that is not there is unknown. Where the force is prescribed, `error`
    is stated at the depth of the answer, and `errors` at the prescribed force, with the error of
    the largest "depth"; on the way back the depth may err more.
    """

    mechanics: str
    seconds: float
    error: float
    evidence: str
    refusals: tuple[Refusal, ...] = ()
    resolution: str | None = None
    errors: Mapping[str, float] = field(default_factory=dict, hash=False)
    wall: float = math.nan

    def __post_init__(self) -> None:
        """Expect one core to do all the work by default."""
        if math.isnan(self.wall):
            object.__setattr__(self, "wall", self.seconds)

    @property
    def candidate(self) -> Candidate:
        """Mechanics and mesh."""
        return Candidate(self.mechanics, self.resolution)


@dataclass(frozen=True)
class Pad:
    """Points of the pad where pressure is reported: points (n_pad, 3) mm, areas (n_pad,) mm².

    `triangles` (n_tri, 3) connect the points for pictures; `normals` (n_pad, 3) point outward.
    """

    points: Array
    areas: Array
    normals: Array
    triangles: Integers

    __repr__ = outline


@dataclass(frozen=True)
class Sites:
    """End-organ sites: material points under the undeformed pad.

    points (n_sites, 3) mm, normals (n_sites, 3) unit outward normals of the skin above them,
    depths (n_sites,) mm below the skin, types: the afferent type that each one serves, unit
    (n_sites,): the afferent unit that each belongs to; None: one each. number (n_sites,): of that
    unit (`neural.variation.numbered`) among all requested ones, some of which may lie off the
    skin; None: not of a population.
    """

    points: Array
    normals: Array
    depths: Array
    types: tuple[str, ...]
    unit: Integers | None = None
    number: Integers | None = None

    __repr__ = outline


@dataclass(frozen=True)
class Lateral:
    """Tangential part of a response: sliding of the indenter and friction.

    Vectors (2,) are along the plane of the indenter: distal, and radial. shift (n_t, 2) mm of the
    indenter; force (n_t, 2) N on the finger: of friction, and of pressure on inclined heights. With
    friction: torque (n_t,) N mm on the finger about the indenter's normal through the center of
    pressure; stick_area (n_t,) mm², the summed area of vertices that stick; traction (n_t, n_pad,
    2) kPa on the skin; slip (n_t, n_pad, 2) mm of the skin over the indenter since first contact;
    work (n_t,) mJ that friction has lost; outcome: whether the contact stuck, slipped in part or
    slid, and since when, in words.
    """

    shift: Array
    force: Array
    torque: Array | None = None
    stick_area: Array | None = None
    traction: Array | None = None
    slip: Array | None = None
    work: Array | None = None
    outcome: str = ""

    __repr__ = outline


@dataclass(frozen=True)
class Fields:
    """Displacement, strain and pressure on the mesh at some of the times.

    points (n_points, 3) mm, cells (n_cells, 4), region (n_cells,) 1 skin, 2 subcutaneous tissue,
    3 bone, times (n_frames,) s, displacement (n_frames, n_points, 3) mm, strain (n_frames,
    n_points, 6) with the components xx yy zz xy yz xz of the tensor, pressure (n_frames, n_points)
    kPa on the pad and zero elsewhere. energy (n_frames, n_points, 2) kJ/m³: the strain-energy
    density of soft tissue with the relaxed and with the instantaneous moduli, the mean of its cells
    around a point, so that its integral is the integral over the elements; None in results of
    earlier versions.
    """

    points: Array
    cells: Integers
    region: NDArray[np.int8]
    times: Array
    displacement: Array
    strain: Array
    pressure: Array
    energy: Array | None = None

    __repr__ = outline


@dataclass(frozen=True, kw_only=True)
class Response:
    """Response of a mechanics to a scene; quantities that the scene does not request are None.

    time (n_t,) s; depth (n_t,) mm; force (n_t,) N on the whole finger along the indenter's
    normal; contact_area (n_t,) mm²; centroid (n_t, 2) mm in x and y, nan without contact; pressure
    (n_t, n_pad) kPa; gap (n_t, n_pad) mm, the distance of the pad from the indenter along the
    indenter's normal; moment (n_t, 3) N mm of the pressure on the finger about the origin; lateral:
    of an indenter that slides or grips; strain (n_t, n_sites, 3, 3), positive in tension;
    reference: where spikes are requested, the reference press that scales their strain.
    `seconds`: wall time of each stage; `notes`: simplifications that a reader of the result must
    know; `status`: one sentence on the convergence of the solution; `numbers`: sizes of the
    problem and, on a mesh, the largest penetration of a vertex at the solved times
    (`penetration_mm`); `sources`: inputs such as the mesh and its hash; `harmonic`: the answer
    about the preload to small oscillations, where the motion is a sweep.
    """

    mechanics: str
    time: Array
    depth: Array
    force: Array
    contact_area: Array | None = None
    centroid: Array | None = None
    pad: Pad | None = None
    pressure: Array | None = None
    sites: Sites | None = None
    strain: Array | None = None
    reference: "Reference | None" = None
    fields: Fields | None = None
    status: str
    seconds: dict[str, float]
    notes: tuple[str, ...]
    numbers: dict[str, float] = field(default_factory=dict)
    sources: dict[str, str] = field(default_factory=dict)
    gap: Array | None = None
    moment: Array | None = None
    harmonic: Harmonic | None = None
    lateral: Lateral | None = None

    __repr__ = outline

    @property
    def inertia(self) -> bool:
        """Whether inertia is part of the answer."""
        return MECHANICS[self.mechanics].inertia

    @property
    def finite(self) -> bool:
        """Whether the strain is finite (logarithmic) instead of small strain.

        A mechanics that has both says which in its `numbers`.
        """
        return bool(self.numbers.get("finite_strain", MECHANICS[self.mechanics].finite))

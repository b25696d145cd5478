"""Records of the candidates for a scene, of a response, also to oscillations, and of a loop."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fefinger.results.candidate import MECHANICS, Candidate
from fefinger.results.labels import LAYOUT, labeled
from fefinger.results.labels import coordinates as names_along
from fefinger.support.arrays import Array, Floats, Integers
from fefinger.support.text import outline


if TYPE_CHECKING:
    import xarray as xr

    from fefinger.neural.drives import Reference


Complex = NDArray[np.complex128]

PER_METER = 1e3  # mm per m


@dataclass(frozen=True)
class Harmonic:
    """Response to oscillations of the indenter along its normal that leave the contact as it is.

    frequency (n_f,) Hz. Complex, as real and imaginary parts along the last axis: stiffness_parts
    (n_f, 2) N/mm of the whole finger; strain_parts (n_f, n_sites, 3, 3, 2) 1/mm at the sites;
    skin_parts (n_f, n_skin, 3, 2) mm per mm at skin_points (n_skin, 3) mm, vertices of the skin in
    the medial plane, from proximal to distal. error (n_f,): relative error of the stiffness from
    modes that are left out, by the first and second static term; modes (n,) Hz: the lowest of the
    finger held by the indenter. preload_depth mm and preload_force N. Modes and preload are of
    relaxed tissue. contact_area mm² of the vertices in contact; notes: what is assumed.
    """

    frequency: Array
    stiffness_parts: Array
    strain_parts: Array
    skin_points: Array
    skin_parts: Array
    error: Array
    modes: Array
    preload_depth: float
    preload_force: float
    contact_area: float
    notes: tuple[str, ...] = field(default=())

    def __repr__(self) -> str:
        """Show range and preload, not the arrays."""
        low, high = self.frequency[[0, -1]]
        about = f"{self.preload_force:.3g} N at {self.preload_depth:.3g} mm"
        return f"<Harmonic: {len(self.frequency)} from {low:.4g} to {high:.4g} Hz, about {about}>"

    @property
    def stiffness(self) -> Complex:
        """Dynamic stiffness (n_f,) in N/mm: force over displacement."""
        return together(self.stiffness_parts)

    @property
    def impedance(self) -> Complex:
        """Mechanical impedance (n_f,) in N s/m: force over velocity."""
        return np.asarray(PER_METER * self.stiffness / (2j * np.pi * self.frequency))

    @property
    def phase(self) -> Array:
        """Phase (n_f,) in degrees by which the force leads the displacement."""
        return np.degrees(np.angle(self.stiffness))

    @property
    def strain(self) -> Complex:
        """Strain (n_f, n_sites, 3, 3) per mm of oscillation."""
        return together(self.strain_parts)

    @property
    def skin(self) -> Complex:
        """Displacement (n_f, n_skin, 3) of the skin per mm of oscillation."""
        return together(self.skin_parts)

    def dissipated_energy(self, amplitude: float) -> Array:
        """Energy (n_f,) in µJ lost in each cycle of an oscillation of `amplitude` mm."""
        microjoule = 1e3  # per N mm
        return np.asarray(microjoule * np.pi * self.stiffness.imag * amplitude**2)

    def to_xarray(self) -> "xr.Dataset":
        """Return the arrays as a Dataset with units, as `result.nc` of a sweep holds them."""
        import xarray as xr

        keys = [key for each in fields(self) if (key := ("Harmonic", each.name)) in LAYOUT]
        variables = {LAYOUT[key].name: labeled(key, getattr(self, key[1])) for key in keys}
        about = {"preload_depth_mm": self.preload_depth, "preload_force_N": self.preload_force}
        more = {"contact_area_mm2": self.contact_area, "notes": " ".join(self.notes)}
        return xr.Dataset(variables, names_along(variables), about | more)

    def site_delay(self) -> Array:
        """Phase delay (n_f, n_sites) in s of the largest component of the strain at each site.

        The phase is unwrapped from the lowest frequency on, where it is within half a cycle.
        """
        return self._delay(self.strain.reshape(*self.strain.shape[:2], 9))

    def skin_delay(self) -> Array:
        """Phase delay (n_f, n_skin) in s of the skin's displacement along its largest component."""
        return self._delay(self.skin)

    def _delay(self, components: Complex) -> Array:
        """Phase delay (n_f, n) in s of the largest of the components (n_f, n, k)."""
        rising = np.argsort(self.frequency)
        largest = np.abs(components).sum(axis=0).argmax(axis=1)
        transfer = np.take_along_axis(components, largest[None, :, None], axis=2)[rising, :, 0]
        phase = np.unwrap(np.angle(transfer * np.where(transfer[0].real < 0, -1.0, 1.0)), axis=0)
        delay = np.empty_like(phase)
        delay[rising] = -phase / (2 * np.pi * self.frequency[rising, None])
        return delay


def together(parts: Array) -> Complex:
    """Complex values of real and imaginary parts (..., 2)."""
    return np.asarray(parts[..., 0] + 1j * parts[..., 1])


def apart(values: Complex) -> Array:
    """Real and imaginary parts (..., 2) of complex values."""
    return np.stack([values.real, values.imag], axis=-1)


@dataclass(frozen=True)
class Refusal:
    """Reason against a mechanics for a scene.

    `about` is "ability" (it cannot answer), "accuracy" (its error is larger than requested) or
    "time" (it takes longer than requested); `reason` quotes the number that is beyond its limit, as
    in "contact radius / thickness = 0.9 > 0.1". `field` is what to change in the scene, such as
    "ask.rel_error", "indenter.radius" or "finger"; "" where there is none, and in results of
    earlier versions.
    """

    mechanics: str
    about: str
    reason: str
    field: str = ""


@dataclass(frozen=True)
class Rung:
    """One mechanics on the ladder, on one of its meshes.

    seconds: expected CPU time on this machine, by which candidates are ranked; wall: expected wall
    time on its cores; error: expected error of the force, the largest through time, over its peak;
    all nan where the mechanics cannot answer. evidence: the report that measured the error; errors:
    expected relative errors of the highest "pressure" over 1 mm², the contact "area" and the
    "strain" at the end organs, at the largest force; one that is missing is not known. Where the
    motion prescribes the force, `error` is of the force at the depth of the answer, and `errors`
    are at the prescribed force, with the error of the largest "depth"; on the way back the depth
    may err more.
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
        """Take the CPU time for a wall time that is not given."""
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
    depths (n_sites,) mm below the skin, types: afferent types, unit (n_sites,): the afferent unit
    of each site, None for one unit each. number (n_sites,): number of the unit among all requested
    units (`neural.variation.numbered`), of which some may lie off the skin; None without a
    population.
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

    Vectors (2,) are distal and radial, in the plane of the indenter. shift (n_t, 2) mm of the
    indenter; force (n_t, 2) N on the finger, by friction and by pressure on inclined heights. With
    friction: torque (n_t,) N mm on the finger about the indenter's normal through the center of
    pressure; stick_area (n_t,) mm² of vertices that stick; traction (n_t, n_pad, 2) kPa on the
    skin; slip (n_t, n_pad, 2) mm of the skin over the indenter since first contact; work (n_t,) mJ
    of friction; outcome: whether and since when the contact stuck, slipped in part or slid.
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
    kPa on the pad and zero elsewhere. energy (n_frames, n_points, 2) kJ/m³: strain-energy density
    of soft tissue with the relaxed and the instantaneous moduli, averaged over the cells around a
    point, so that its integral over the mesh is kept; None in results of earlier versions.
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
    seconds: wall time of each stage; notes: simplifications that a reader of the result must know;
    status: one sentence on the convergence of the solution; numbers: sizes of the problem and, on a
    mesh, the largest penetration of a vertex at the solved times (`penetration_mm`); sources:
    inputs such as the mesh and its hash; harmonic: the response to small oscillations about the
    preload, where the motion is a sweep.
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
        """Whether the strain is logarithmic (finite) instead of small strain.

        `numbers` says so where a mechanics has both.
        """
        return bool(self.numbers.get("finite_strain", MECHANICS[self.mechanics].finite))


@dataclass(slots=True, repr=False)
class Step:
    """Result of a step of a loop in real time; the next step overwrites its arrays.

    depth mm, force N; touching: whether there is contact; x and y mm: center of pressure, without
    contact the last one, at the start the first touch; pressure (n,) kPa at the vertices that may
    touch; strain (n_sites, 6), positive in tension, with the components xx yy zz xy yz xz of the
    tensor. contact_area mm²: at small strain the area of the vertices under pressure, which jumps
    with each vertex; `Result.contact_area` follows the rim within an element.

    Of an object that moves sideways: shift (2,) mm, and lateral_force (2,) N on the finger, distal
    and radial; with friction, torque N mm on the finger about the normal through the center of
    pressure, stick_area mm² of the vertices that do not slip, and work mJ of friction so far.
    """

    pressure: Array
    strain: Floats
    shift: Array
    lateral_force: Array
    depth: float = 0.0
    force: float = 0.0
    contact_area: float = 0.0
    x: float = 0.0
    y: float = 0.0
    touching: bool = False
    torque: float = 0.0
    stick_area: float = 0.0
    work: float = 0.0

    def __repr__(self) -> str:
        """Show the numbers with their units, not the arrays."""
        x, y = (round(each, 4) + 0.0 for each in (self.x, self.y))
        where = f"about x {x:g}, y {y:g} mm" if self.touching else "no contact"
        force = f"{self.force:.4g} N at {self.depth:.4g} mm"
        return f"<{type(self).__name__}: {force}, {self.contact_area:.4g} mm², {where}>"


@dataclass(frozen=True)
class LoopState:
    """State of a loop between two steps: its contact, center of pressure mm, and angles degrees."""

    contact: tuple[object, ...]
    center: tuple[float, float]
    angles: tuple[float, float]

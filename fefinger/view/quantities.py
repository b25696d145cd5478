"""Fields that pictures are colored by: names, units, values, and the ranges of their colors.

Strain is in the directions of the undeformed finger: small strain, or logarithmic strain of
mechanics at finite strain. Color maps are even to the eye, also of people who are color-blind.
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from fefinger.geometry.finger_mesh import SKIN, SUBCUTANEOUS, volumes
from fefinger.laws import LAWS
from fefinger.results.candidate import meshed
from fefinger.results.records import Fields
from fefinger.results.result_record import ResultRecord
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Tissue
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, choice, number
from fefinger.support.tensors import tensor_from_voigt


if TYPE_CHECKING:
    from matplotlib.colors import ListedColormap

DEFAULT = "compressive strain"
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "xz")
PRINCIPAL = ("principal strain 1", "principal strain 2", "principal strain 3")
ENERGIES = ("relaxed strain energy", "elastic strain energy")
ABOUT = {
    "compressive strain": "size of the most compressive principal strain",
    "tensile strain": "the most tensile principal strain, 0 where there is none",
    "von Mises strain": "sqrt(2/3 e:e) of the deviator e",
    **{name: f"principal strain, {which}" for name, which in zip(
        PRINCIPAL, ("most tensile", "middle", "most compressive"), strict=True)},
    **{f"strain {component}": "component of the strain tensor (x distal, y radial, z dorsal)"
       for component in COMPONENTS},
    "relaxed strain energy": "strain-energy density with the moduli of long times, mean of cells",
    "elastic strain energy": "strain-energy density with the instantaneous moduli, mean of cells",
    "displacement": "length of the displacement",
    "pressure": "contact pressure on the pad",
}  # fmt: skip
FIELDS = tuple(ABOUT)
SYNONYMS = {
    **dict.fromkeys(("sed", "strain energy", "energy", "strain energy density"), ENERGIES[::-1]),
    **dict.fromkeys(("mises", "equivalent strain", "von mises"), ("von Mises strain",)),
    **dict.fromkeys(("strain", "compression"), ("compressive strain",)),
    **dict.fromkeys(("tension", "stretch"), ("tensile strain",)),
    **dict.fromkeys(("max principal strain", "maximum principal strain"), PRINCIPAL[:1]),
    **dict.fromkeys(("min principal strain", "minimum principal strain"), PRINCIPAL[2:]),
    **{f"{prefix}{each}": (f"strain {each}",) for prefix in ("e", "") for each in COMPONENTS},
    "u": ("displacement",),
    "p": ("pressure",),
}
"""Other names of fields, for suggestions in messages."""
EVEN, DIVERGING, SKIN_DEEP = "viridis", "coolwarm", "OrRd"
"""Color maps: of fields from 0, of fields of both signs, of the pressure on the skin."""
RATES: Final = "plasma"
"""Color map of spike rates."""
STEPS = (1.0, 1.2, 1.6, 2.0, 2.4, 2.8, 3.2, 3.6, 4.0, 4.8, 5.6, 6.4, 7.2, 8.0, 10.0)
"""Ends of color bars, of two digits, as are their quarters."""
SHADES = 256  # of a color bar


class Span(NamedTuple):
    """Range of a color bar, its color map, and beyond which ends values lie: min, max, both."""

    low: float
    high: float
    colors: str
    extend: str

    def beyond(self, unit: str) -> str:
        """Return the meaning of the colors at the ends of the bar, if values lie beyond them."""
        low = f"first color: {self.low:.3g} {unit} and less"
        high = f"last color: {self.high:.3g} {unit} and more"
        return {"neither": "", "min": low, "max": high, "both": f"{low}, {high}"}[self.extend]

    @property
    def part(self) -> tuple[float, float]:
        """Return ends from 0 to 1 of the part of the color map in use; zero is its middle."""
        if self.colors != DIVERGING:
            return 0.0, 1.0
        most = 2 * max(abs(self.low), abs(self.high))
        return 0.5 + self.low / most, 0.5 + self.high / most

    def map(self) -> "ListedColormap":
        """Return the colors of the bar as a color map."""
        from matplotlib import colormaps
        from matplotlib.colors import ListedColormap

        return ListedColormap(colormaps[self.colors](np.linspace(*self.part, SHADES)))


def named(name: str, field: str) -> str:
    """Return the field if it is known, or raise InputError of `name` that suggests one."""
    if field in FIELDS:
        return field
    meant = SYNONYMS.get(str(field).strip().lower().replace("_", " "))
    if meant is None:
        return choice(name, field, FIELDS)
    options, nearest = ", ".join(map(repr, FIELDS)), " or ".join(map(repr, meant))
    message = f"{name}: expected one of {options}, received {field!r}. Did you mean {nearest}?"
    raise InputError(message)


def unit(field: str) -> str:
    """Return the unit in which pictures show a field; strains are shown in percent."""
    units = dict.fromkeys(ENERGIES, "kJ/m³") | {"pressure": "kPa", "displacement": "mm"}
    return units.get(field, "%")


def label(field: str) -> str:
    """Return the name of a field with its unit, for a color bar."""
    return f"{field} / {unit(field)}"


def signed(field: str) -> bool:
    """Return whether a field can have both signs."""
    return field in PRINCIPAL or field.removeprefix("strain ") in COMPONENTS


def measure(result: ResultRecord) -> str:
    """Return the measure of strain in the fields of a result."""
    return "logarithmic strain" if result.response.finite else "small strain"


def fields_of(result: ResultRecord) -> Fields:
    """Return the fields of a result, or raise InputError where there are none."""
    if result.fields is None:
        raise InputError(
            f"fields: expected a result with fields on the mesh, received one of "
            f"{result.plan.mechanics!r} without; run the scene again with `--set ask.fields=true` "
            f"and a mechanics that has a mesh ({', '.join(meshed())})"
        )
    return result.fields


def values(result: ResultRecord, field: str, frame: int) -> Array:
    """Return a field at the mesh points (n_points,) in `unit(field)`, at a stored time `frame`.

    Raises InputError if the field is unknown or the result has no fields.
    """
    named("field", field)
    fields = fields_of(result)
    if field == "pressure":
        return fields.pressure[frame]
    if field == "displacement":
        return np.asarray(np.linalg.norm(fields.displacement[frame], axis=1))
    if field in ENERGIES:
        elastic = field == "elastic strain energy"
        finger = result.scene.finger
        return density(fields, frame, finger, elastic=elastic, finite=result.response.finite)
    strain = 100.0 * fields.strain[frame]
    if field.removeprefix("strain ") in COMPONENTS:
        return np.asarray(strain[:, COMPONENTS.index(field.removeprefix("strain "))])
    principal = np.asarray(np.linalg.eigvalsh(tensor_from_voigt(strain)), np.float64)  # ascending
    if field in PRINCIPAL:
        return np.asarray(principal[:, 2 - PRINCIPAL.index(field)])
    if field == "compressive strain":
        return np.asarray(np.maximum(0.0, -principal[:, 0]))
    if field == "tensile strain":
        return np.asarray(np.maximum(0.0, principal[:, 2]))
    deviator = principal - principal.mean(axis=1, keepdims=True)
    return np.asarray(np.sqrt(2 / 3 * np.sum(deviator**2, axis=1)))


def span(shown: Iterable[Array], field: str, limits: tuple[float, float] | None = None) -> Span:
    """Return one range of colors for several arrays: up to a round number, or within `limits`.

    The highest half percent of an array may lie beyond; of pressure nothing does. A field of both
    signs has the diverging map, unless its limits are on one side of zero.
    """
    colors = DIVERGING if signed(field) else SKIN_DEEP if field == "pressure" else EVEN
    if limits and signed(field) and limits[0] * limits[1] > 0:
        colors = EVEN
    lowest, highest, top = 0.0, 0.0, 1e-9
    for each in shown:
        if not each.size:
            continue
        part = np.abs(each) if signed(field) else each
        lowest, highest = min(lowest, float(each.min())), max(highest, float(each.max()))
        # The highest half percent sits at sharp edges.
        size = part.max() if field == "pressure" else np.percentile(part, 99.5)
        top = max(top, float(size))
    top = round_up(top)
    low, high = limits or (-top if signed(field) else 0.0, top)
    below, above = lowest < low * (1 + 1e-9) - 1e-12, highest > high * (1 + 1e-9)
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max"}
    return Span(low, high, colors, ends.get((below, above), "both"))


def round_up(value: float) -> float:
    """Return the next of STEPS times a power of ten."""
    scale = 10.0 ** np.floor(np.log10(value))
    return float(min(step * scale for step in STEPS if step * scale >= value * (1 - 1e-9)))


def limits(text: str) -> tuple[float, float]:
    """Return the limits of a color bar from a text LOW:HIGH, or raise InputError."""
    low, colon, high = text.partition(":")
    try:
        pair = (float(low), float(high))
    except ValueError:
        colon = ""
    if not colon:
        raise InputError(f"--limits: expected LOW:HIGH, such as 0:30, received {text!r}")
    number("--limits LOW", pair[0])
    number("--limits HIGH", pair[1], above=pair[0])
    return pair


INCOMPRESSIBLE = 0.49
"""Poisson's ratio above which the energy of a change of volume is left out: it is small, and the
error of the elements' volume strain, times the bulk modulus, is not."""


def density(fields: Fields, frame: int, finger: Finger, *, elastic: bool, finite: bool) -> Array:
    """Return the strain-energy density (n_points,) in kJ/m³ (which is kPa) at the mesh points.

    `elastic`: with the instantaneous moduli, otherwise the relaxed ones. `finite`: the strain is
    logarithmic, with the energy of the tissue's law; otherwise it is small, with Hooke's law. A
    point in two tissues gets the mean, weighted by the volumes of its cells; bone has none.
    """
    # The elements' own: its integral over the mesh is the work of the indenter on elastic tissue.
    # Fields of earlier versions hold the strain at the points alone: the density from it is some
    # 20 % too large on a coarse mesh, as energy grows with the square of strain.
    if fields.energy is not None:
        return np.asarray(fields.energy[frame, :, int(elastic)])
    of_skin, soft = shares(fields)
    total = np.zeros(len(fields.points))
    for tissue, part in ((finger.skin, of_skin), (finger.subcutaneous, soft - of_skin)):
        distortion, volume = split(fields.strain[frame], tissue, finite=finite)
        if elastic:
            long_time = (tissue.prony or finger.prony).long_time
            distortion = distortion / long_time
            volume = volume / long_time if finger.relaxation == "whole" else volume
        total += part * (distortion + volume)
    return total


def split(strain: Array, tissue: Tissue, *, finite: bool) -> tuple[Array, Array]:
    """Return the relaxed energy densities (n,) kPa of distortion and of the change of volume.

    Small strain e (n, 6): mu e' : e' and K / 2 (tr e)². Finite: mu W of the tissue's law at the
    principal stretches exp(e), and K / 2 (J - 1)². The second is 0 above INCOMPRESSIBLE.
    """
    shear = tissue.modulus / (2 * (1 + tissue.poisson))
    bulk = 0.0
    if tissue.poisson <= INCOMPRESSIBLE:
        bulk = tissue.modulus / (3 * (1 - 2 * tissue.poisson))
    trace = strain[:, :3].sum(axis=1)
    deviator = strain - np.where(np.arange(6) < 3, trace[:, None] / 3, 0.0)
    if not finite:
        squares = (deviator**2) @ np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])
        return shear * squares, bulk / 2 * trace**2
    logs = np.linalg.eigvalsh(tensor_from_voigt(deviator))
    first, second = (np.expm1(sign * 2 * logs).sum(axis=1) for sign in (1, -1))
    distortion = shear * LAWS[tissue.law].at(first, second, tissue.law_values).w
    return distortion, bulk / 2 * np.expm1(trace) ** 2


def shares(fields: Fields) -> tuple[Array, Array]:
    """Return the skin's share (n_points,) of the soft volume at a point, and 1 where it has any."""
    volume = np.repeat(np.abs(volumes(fields.points, fields.cells))[:, None], 4, axis=1)
    skin, subcutaneous = (
        np.bincount(fields.cells[part].ravel(), volume[part].ravel(), len(fields.points))
        for part in (fields.region == SKIN, fields.region == SUBCUTANEOUS)
    )
    total = skin + subcutaneous
    return skin / np.where(total > 0, total, 1.0), (total > 0).astype(float)

"""Exact layers on a periodic grid: their compliance by wavenumber, and the strain below.

The body of a pad whose skin is touched by any heights (`contact/gridded.py`). Amplitudes at every
depth are those of `theory/contact/stack.py`.

A grid repeats the contact at every period. What the images add to the displacement is nearly the
same all over the contact, so the compliance of the mean takes its average away; `images` measures
what is left.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import fft, sparse, special
from scipy.interpolate import CubicSpline

from fefinger.contact.grid_coulomb import Flexibility
from fefinger.support.arrays import Array, Flags
from fefinger.theory.contact.stack import PRESSURE, SHEAR, Stack


UNIFORM = 1e-3
"""Wavenumber in 1/mm whose kernels serve the mean, far below one over the thickness."""

Waves = NDArray[np.complex128]


@dataclass(frozen=True)
class LayerGrid:
    """Layers under a periodic square grid of `points` a side, `spacing` mm apart.

    width: standard deviation in mm of the Gaussian pressure for which the images are taken away.
    beyond: displacement in mm per mN of the body that bears the layers (`beyond_layers.py`).
    """

    layers: Stack
    points: int
    spacing: float
    width: float = 1.0
    beyond: float = 0.0

    @property
    def period(self) -> float:
        """Length of a side in mm."""
        return self.points * self.spacing

    @cached_property
    def lines(self) -> Array:
        """Grid lines (n,) in mm about the middle."""
        return np.asarray(self.spacing * (np.arange(self.points) - self.points // 2), np.float64)

    @cached_property
    def places(self) -> Array:
        """Places (n, n, 2) in mm of the grid."""
        return np.stack(np.meshgrid(self.lines, self.lines, indexing="ij"), axis=-1)

    @cached_property
    def compliance(self) -> Array:
        """Displacement in mm of the surface per kPa of every wave (n, n // 2 + 1)."""
        _, sink, _, _ = amplitudes(self.layers, wavenumbers(self.points, self.spacing), 0.0)
        sink[0, 0] += (self.beyond - self.of_images(0.0).sink) * self.period**2
        return sink

    @cached_property
    def flexibility(self) -> Flexibility:
        """Displacements of the surface under pressure and traction of every wave."""
        first, second = along_axes(self.points, self.spacing)
        xi = np.maximum(np.hypot(first, second), UNIFORM)
        c, s = first / xi, second / xi
        slide = amplitudes(self.layers, xi, 0.0)[0] / xi
        along = -amplitudes(self.layers, xi, 0.0, SHEAR)[0] / xi
        aside = asides(self.layers, xi, 0.0)[0] / xi
        one, two = (c**2 * along + s**2 * aside, s**2 * along + c**2 * aside)
        # The mean has no direction.
        one[0, 0] = two[0, 0] = aside[0, 0] - self.of_images(0.0).slide * self.period**2
        # Waves of two points have no other side: what is odd in them has none.
        c[self.points // 2], s[:, -1] = 0.0, 0.0
        coupled, tangential = [c * slide, s * slide], [one, two, c * s * (along - aside)]
        return Flexibility(self.compliance, np.stack(coupled), np.stack(tangential))

    def of_images(self, z: float) -> "Means":
        """Return the mean fields of the periodic images of a load of 1 mN, at the depth z mm."""
        free = 6  # side of a grid without images, in periods of the one whose images are estimated
        both = zip(self._seen(z, 1), self._seen(z, free), strict=True)
        return Means(*(here - away for here, away in both))

    def _seen(self, z: float, periods: int) -> "Means":
        """Return the mean fields under Gaussian loads of 1 mN, so many `periods` apart."""
        side = periods * self.period
        smooth = 6.5  # wavenumber times width of a Gaussian load beyond which it has no waves
        points = 2 * math.ceil(smooth / self.width * side / (2 * np.pi)) + 2
        xi = wavenumbers(points, side / points)
        slide, sink, stretch, _ = amplitudes(self.layers, xi, z)
        along, _, _, shear = amplitudes(self.layers, xi, z, SHEAR)
        aside, bend = asides(self.layers, xi, z)
        plane = np.where(xi > 0, slide, 0.0)
        across = (aside - along) / 2 / np.maximum(xi, UNIFORM)
        # Columns of waves that are not stored are those of the others, but of the ends.
        load = np.exp(-((xi * self.width) ** 2)) / side**2
        load[:, 1:-1] *= 2
        fields = (sink, plane, stretch, across, (bend - shear) / 4)
        return Means(*(float((load * each).sum()) for each in fields))

    def images(self, pressure: Array, displacement: Array) -> float:
        """Return the largest displacement in mm that periodic images add in a contact.

        pressure (n, n) kPa and its displacement (n, n) mm: against a grid of twice the period.
        """
        n = self.points
        wide = np.zeros((2 * n, 2 * n))
        wide[:n, :n] = pressure
        alone = fft.irfft2(fft.rfft2(wide) * self._wider.compliance, wide.shape)[:n, :n]
        loaded = pressure > 0.0
        return float(np.abs(alone - displacement)[loaded].max(initial=0.0))

    @cached_property
    def _wider(self) -> "LayerGrid":
        return replace(self, points=2 * self.points)

    def waves(self, stress: Array) -> Waves:
        """Return the Fourier transforms (k, n, n // 2 + 1) of stresses, k times (n, n) or (n²,)."""
        return np.asarray(fft.rfft2(np.reshape(stress, (-1, self.points, self.points))))


def object_compliance(body: Stack, grid: LayerGrid) -> Array:
    """Return the displacement in mm of the surface of a soft object per kPa of every wave.

    Of a half-space the kernel 1 / r is cut off at half a period, so that nothing comes from the
    images of a contact that is no wider than that (after Vico, Greengard and Ferrando, J. Comput.
    Phys. 323:191, 2016); its transform is an integral of the Bessel function J0.
    """
    if body.thickness < math.inf:
        return LayerGrid(body, grid.points, grid.spacing, grid.width).compliance
    modulus, poisson = body.surface
    reach = grid.period / 2
    xi = wavenumbers(grid.points, grid.spacing)
    xi[0, 0] = UNIFORM
    return np.asarray(2 * (1 - poisson**2) / modulus * special.itj0y0(xi * reach)[0] / xi)


def wavenumbers(points: int, spacing: float) -> Array:
    """Return the wavenumbers (n, n // 2 + 1) in 1/mm of a square grid, as of `scipy.fft.rfft2`."""
    return np.asarray(np.hypot(*along_axes(points, spacing)), np.float64)


def along_axes(points: int, spacing: float) -> tuple[Array, Array]:
    """Return the wavenumbers (n, n // 2 + 1) in 1/mm along both axes."""
    first, second = np.meshgrid(
        2 * np.pi * fft.fftfreq(points, spacing),
        2 * np.pi * fft.rfftfreq(points, spacing),
        indexing="ij",
    )
    return first, second


class Means(NamedTuple):
    """Mean fields of a load: of a pressure, then of a traction.

    sink: displacement in mm into the body; plane: strain in the plane, the sum of both; stretch:
    strain across it; slide: displacement along the traction; shear: shear strain along it.
    """

    sink: float
    plane: float
    stretch: float
    slide: float
    shear: float


def amplitudes(layers: Stack, xi: Array, z: float, load: tuple[float, float] = PRESSURE) -> Array:
    """Return fields (4, ...) at the depth z mm per kPa of waves with wavenumbers of any shape.

    Strain along the wave, displacement in mm into the body, strain across the plane, and twice the
    shear strain; of the first and the last the amplitude a quarter of a wave aside. load: that of
    the waves, as of `Stack.depths`.
    """
    slide, sink, axial, shear = _tabulated(lambda at: layers.depths(at, [z], load)[0], xi)
    xi = np.maximum(xi, UNIFORM)
    layer = layers.layers[layers.locate(z)[0]]
    nu, twice = layer.poisson, 2 * layer.shear
    stretch = ((1 - 2 * nu) * axial / twice - nu * slide) / (1 - nu)
    return np.stack([slide, sink / xi, stretch, 2 * shear / twice])


def asides(layers: Stack, xi: Array, z: float) -> Array:
    """Return `Stack.aside` (2, ...) at wavenumbers of any shape."""
    return _tabulated(lambda at: layers.aside(at, z), xi)


def _tabulated(kernel: Callable[[Array], Array], xi: Array) -> Array:
    """Return a kernel (k, ...) at wavenumbers of any shape, from a table of it."""
    xi = np.maximum(xi, UNIFORM)
    # Wavenumbers, of even logarithms, at which kernels are exact; a cubic spline between them errs
    # by 1e-7, and a grid has ten times as many.
    tabulated = 3000
    lines = np.linspace(np.log(UNIFORM), np.log(float(xi.max())), tabulated)
    table = kernel(np.maximum(np.exp(lines), UNIFORM))
    return np.asarray(CubicSpline(lines, table, axis=1)(np.log(xi)))


class _Level(NamedTuple):
    """End organs at one depth: which, a coarser grid, its transfer functions, and interpolation.

    chosen (n_sites,); points of the coarser grid; transfer (k, 6, m, m // 2 + 1): of strain xx, yy,
    zz, xy, yz, xz per kPa of each stress; at (n, m²): the spline at the sites.
    """

    chosen: Flags
    points: int
    transfer: Waves
    at: sparse.csr_matrix


COMPONENTS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
"""Indices of the components of a strain."""


class StrainProbe:
    """Strain at sites below a grid, linear in the pressure.

    Waves decay with the depth, so that each depth has a grid as coarse as what is left of them;
    between its points a cubic spline is read, whose coefficients are part of the transfer.

    Parameters
    ----------
    grid
        The layers.
    places
        (n_sites, 2) mm below the grid.
    depths
        (n_sites,) mm, above 0.
    friction
        Whether there is traction beside the pressure.
    """

    def __init__(
        self, grid: LayerGrid, places: Array, depths: Array, *, friction: bool = False
    ) -> None:
        self.grid, self.count = grid, len(places)
        at = np.round(np.asarray(depths), 9)
        self._levels = [
            _level(grid, places, at == z, float(z), friction=friction) for z in np.unique(at)
        ]

    def strain(self, stress: Array) -> Array:
        """Return the strain (n_sites, 3, 3) of a pressure in kPa, with friction and traction.

        stress: (n, n) or (n²,), with friction (3, n, n) or (3n²,). In the frame of the grid, z into
        the body; positive in tension.
        """
        waves, out = self.grid.waves(stress), np.empty((self.count, 3, 3))
        for level in self._levels:
            kept = [cropped(each, self.grid.points, level.points) for each in waves]
            shape = (level.points, level.points)
            moved = sum(each * to for each, to in zip(kept, level.transfer, strict=True))
            fields = fft.irfft2(moved, shape, axes=(1, 2))
            values = level.at @ fields.reshape(6, -1).T
            for (i, j), value in zip(COMPONENTS, values.T, strict=True):
                out[level.chosen, i, j] = out[level.chosen, j, i] = value
        return out


def cropped(waves: Waves, points: int, fewer: int) -> Waves:
    """Return the waves (m, m // 2 + 1) of a coarser grid, scaled to its number of points."""
    if fewer == points:
        return waves
    half = fewer // 2
    kept = np.concatenate([waves[:half, : half + 1], waves[-half:, : half + 1]])
    kept[half] = 0.0
    kept[:, half] = 0.0
    return np.asarray(kept * (fewer / points) ** 2)


def _level(grid: LayerGrid, places: Array, chosen: Flags, z: float, *, friction: bool) -> _Level:
    """Prepare the strain at one depth."""
    # Wavenumber times depth beyond which nothing of a wave is left: exp(-22) is 3e-10.
    decayed = 22.0
    needed = 2 * math.ceil(decayed / z * grid.period / (2 * np.pi)) + 2
    fewest = 24  # least number of grid points for the strain at a depth
    points = min(grid.points, max(fewest, fft.next_fast_len(needed + needed % 2)))
    points = grid.points if points % 2 else points
    step = grid.period / points
    first, second = along_axes(points, step)
    mean, area = grid.of_images(z), grid.period**2
    transfer = [of_pressure(grid.layers, first, second, z)]
    transfer[0][:3, 0, 0] -= np.array([mean.plane / 2, mean.plane / 2, mean.stretch]) * area
    if friction:
        transfer += of_tractions(grid.layers, first, second, z)
        for each, component in zip(transfer[1:], (5, 4), strict=True):
            each[component, 0, 0] -= mean.shear * area
    # The coefficients of the cubic spline through the points of a wave are it over this.
    spline = np.multiply(*((2 + np.cos(k * step)) / 3 for k in (first, second)))
    first_line = float(grid.lines[0])
    return _Level(
        chosen,
        points,
        np.asarray(np.stack(transfer) / spline, np.complex128),
        splines((places[chosen] - first_line) / step, points),
    )


def of_pressure(layers: Stack, first: Array, second: Array, z: float) -> Waves:
    """Return the strain (6, ...) at the depth z mm per kPa of waves of pressure."""
    xi = np.maximum(np.hypot(first, second), UNIFORM)
    c, s = first / xi, second / xi
    slide, _, stretch, shear = amplitudes(layers, xi, z)
    slanted = -0.5j * shear
    return np.stack([c**2 * slide, s**2 * slide, stretch, c * s * slide, s * slanted, c * slanted])


def of_tractions(layers: Stack, first: Array, second: Array, z: float) -> list[Waves]:
    """Return the strains (6, ...) as `of_pressure`, of tractions along each axis.

    A traction is the sum of one along the wave and one across it.
    """
    xi = np.maximum(np.hypot(first, second), UNIFORM)
    c, s = first / xi, second / xi
    c[0, 0], s[0, 0] = 1.0, 0.0  # the mean has no direction
    slide, _, stretch, shear = amplitudes(layers, xi, z, SHEAR)
    aside, bend = asides(layers, xi, z)
    aside[0, 0] = slide[0, 0] = stretch[0, 0] = 0.0
    out = []
    for along, across in ((c, -s), (s, c)):
        one, turn = -1j * along * slide, 0.5j * across * aside
        slanted, beside = -0.5 * along * shear, 0.5 * across * bend
        strain = [
            c**2 * one - 2 * c * s * turn,
            s**2 * one + 2 * c * s * turn,
            -1j * along * stretch,
            c * s * one + (c**2 - s**2) * turn,
            s * slanted + c * beside,
            c * slanted - s * beside,
        ]
        out.append(np.stack(strain))
    return out


def splines(at: Array, points: int) -> sparse.csr_matrix:
    """Return the matrix (k, m²) of periodic uniform cubic B-splines at places (k, 2) in points."""
    cell = np.floor(at)
    t = (at - cell)[..., None]
    weights = np.concatenate(
        [(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, 1 + 3 * t + 3 * t**2 - 3 * t**3, t**3], axis=-1
    )
    index = (cell[..., None].astype(np.int64) + np.arange(-1, 3)) % points
    both = weights[:, 0, :, None] * weights[:, 1, None, :] / 36
    number = index[:, 0, :, None] * points + index[:, 1, None, :]
    rows = np.repeat(np.arange(len(at)), 16)
    shape = (len(at), points**2)
    return sparse.csr_matrix((both.ravel(), (rows, number.ravel())), shape)

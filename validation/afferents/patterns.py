"""Contact of rigid patterns with the flat stack of `layered`, finer than a mesh of the finger.

Bars, pins and arrays of probes have edges that the elements of the finger (0.6 mm) do not resolve.
Here the pad is a paraboloid on the exact layers over bone (`theory/contact/stack.py`), periodic on
a square grid. The pressure solves the complementarity problem by projected conjugate gradients
(Polonsky & Keer 1999, Wear 231:206), with the compliance of every wavenumber by Fourier transform.
Elastic: under a prescribed depth strain does not relax, under a force it is that at once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from fefinger.validation.afferents import experiments
from scipy.ndimage import map_coordinates

from fefinger.geometry.profiles import Profile
from fefinger.mechanics.layered import stack
from fefinger.neural.drives import DRIVE_BY_NAME
from fefinger.support.arrays import Array
from fefinger.support.checks import ConvergenceError
from fefinger.theory.contact.stack import Stack


Shape = Callable[[Array], Array]
"""Heights (...,) mm of an object above its lowest point, at places (..., 2) mm."""

POINTS, SPACING = 192, 0.08
"""Grid points on a side, and the distance in mm between them: a period of 15 mm, whose neighbors
raise the force of a plate 0.4 mm deep by 2 %, its highest pressure by 0.5 %."""

ITERATIONS, TOLERANCE = 2000, 1e-6
"""Most iterations, and the residual gap over the depth at which they end."""

LOADED = 1e-5
"""Residual gap in mm at which they end under a given force."""

UNIFORM = 1e-3
"""1/mm: wavenumber whose kernels serve the mean pressure, far below one over the thickness."""


@dataclass(frozen=True)
class Pad:
    """Paraboloid of `radius` mm on a stack of layers, on a periodic grid."""

    layers: Stack
    radius: float
    points: int = POINTS
    spacing: float = SPACING

    @cached_property
    def lines(self) -> Array:
        """Grid lines (n,) in mm about the middle."""
        return np.asarray(self.spacing * (np.arange(self.points) - self.points // 2), np.float64)

    @cached_property
    def places(self) -> Array:
        """Places (n, n, 2) in mm of the grid."""
        return np.stack(np.meshgrid(self.lines, self.lines, indexing="ij"), axis=-1)

    @cached_property
    def _waves(self) -> tuple[Array, Array]:
        """Wavenumbers (n, n / 2 + 1) in 1/mm along both axes."""
        full = 2 * np.pi * np.fft.fftfreq(self.points, self.spacing)
        half = 2 * np.pi * np.fft.rfftfreq(self.points, self.spacing)
        first, second = np.meshgrid(full, half, indexing="ij")
        return first, second

    @cached_property
    def wavenumbers(self) -> Array:
        """Wavenumbers (n, n / 2 + 1) in 1/mm."""
        return np.maximum(np.hypot(*self._waves), UNIFORM)

    @cached_property
    def _compliance(self) -> Array:
        """Displacement in mm of the surface per kPa of every wave."""
        return kernels(self, 0.0)[1] / self.wavenumbers

    def sink(self, pressure: Array) -> Array:
        """Displacement (n, n) in mm of the surface into the body under a pressure in kPa."""
        return np.fft.irfft2(np.fft.rfft2(pressure) * self._compliance, pressure.shape)

    def gap(self, shape: Shape) -> Array:
        """Distance (n, n) in mm of a rigid object at first touch of its lowest point."""
        return np.sum(self.places**2, axis=-1) / (2 * self.radius) + shape(self.places)

    def pressure(self, shape: Shape, depth: float) -> Array:
        """Pressure (n, n) in kPa under a rigid object `depth` mm deep.

        Raises ConvergenceError if the gap in contact stays above TOLERANCE of the depth.
        """
        gap = self.gap(shape) - depth
        start = np.where(gap < 0, -self.layers.surface[0] * gap, 0.0)
        return self._balanced(gap, start, None, TOLERANCE * depth)

    def pressure_by_force(self, shape: Shape, force: float, start: Array) -> Array:
        """Pressure (n, n) in kPa under a rigid object that is held with `force` mN.

        It is sought from a pressure `start` (n, n) of any size. ConvergenceError if the gap in
        contact stays above LOADED.
        """
        return self._balanced(self.gap(shape), start, force, LOADED)

    def _balanced(self, gap: Array, pressure: Array, force: float | None, limit: float) -> Array:
        """Close a gap to `limit` mm: as it is, or with a force in mN up to a common distance."""
        load = None if force is None else force / self.spacing**2

        def scaled(given: Array) -> Array:
            return given if load is None else given * (load / given.sum())

        pressure = scaled(pressure)
        way, last, restart = np.zeros_like(gap), 1.0, True
        for _ in range(ITERATIONS):
            loaded = pressure > 0
            rest = self.sink(pressure) + gap
            rest -= 0.0 if load is None else rest[loaded].mean()
            missing = np.where(loaded, rest, np.minimum(rest, 0.0))
            if np.abs(missing).max() < limit:
                return pressure
            size = float(np.sum(rest[loaded] ** 2))
            way = np.where(loaded, rest + (0.0 if restart else size / last) * way, 0.0)
            turned = self.sink(way)
            turned -= 0.0 if load is None else turned[loaded].mean()
            stride = float(np.sum(rest * way) / np.sum(turned * way))
            pressure = np.maximum(pressure - stride * way, 0.0)
            entering = (pressure == 0) & (rest < 0)
            pressure[entering] -= stride * rest[entering]
            pressure = scaled(pressure)
            last, restart = size, bool(entering.any())
        msg = (
            f"pressure: expected a gap in contact below {limit:.2g} mm in {ITERATIONS} iterations, "
            f"reached {np.abs(missing).max():.2g}; use a finer grid or a shallower press"
        )
        raise ConvergenceError(msg)

    def strain(self, pressure: Array, z: float, places: Array) -> Array:
        """Strain (n_places, 3, 3) at the depth z mm below places (n_places, 2) mm."""
        (first, second), xi = self._waves, self.wavenumbers
        slide, _, axial, shear = kernels(self, z) * np.fft.rfft2(pressure)
        layer = self.layers.layers[self.layers.locate(z)[0]]
        nu, twice = layer.poisson, 2 * layer.shear
        stretch = ((1 - 2 * nu) * axial / twice - nu * slide) / (1 - nu)
        waves = {
            (0, 0): first**2 / xi**2 * slide,
            (1, 1): second**2 / xi**2 * slide,
            (0, 1): first * second / xi**2 * slide,
            (2, 2): stretch,
            (0, 2): -1j * first / xi * shear / twice,
            (1, 2): -1j * second / xi * shear / twice,
        }
        out = np.empty((len(places), 3, 3))
        at = np.transpose(places) / self.spacing + self.points // 2
        for (i, j), wave in waves.items():
            field = np.fft.irfft2(wave, pressure.shape)
            out[:, i, j] = out[:, j, i] = map_coordinates(field, at, order=3, mode="grid-wrap")
        return out


@cache
def kernels(body: Pad, z: float) -> Array:
    """Kernels (4, n, n / 2 + 1) of a pad's stack at the depth z mm."""
    single, place = np.unique(np.round(body.wavenumbers, 9), return_inverse=True)
    return body.layers.kernels(single, z)[:, place.reshape(body.wavenumbers.shape)]


@cache
def pad() -> Pad:
    """Return the pad of the experiments."""
    return Pad(stack(experiments.MACAQUE), experiments.MACAQUE.pad_radius)


def driven(shape: Shape, depth: float, places: Array, *, drive: str, organ: float) -> Array:
    """Drives (n,) of end organs `organ` mm below places (n, 2) mm, `depth` mm under an object."""
    strain = pad().strain(pad().pressure(shape, depth), organ, np.asarray(places, float))
    return DRIVE_BY_NAME[drive](strain, np.tile([0.0, 0.0, 1.0], (len(strain), 1)))


def heights(profile: Profile) -> Shape:
    """Return the shape of the profile of an indenter."""
    return lambda places: profile.height(places)[0]

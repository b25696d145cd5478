"""Bonded elastic layers on a rigid base or a half-space: exact Hankel kernels, and a point load.

Each wavenumber obeys an ordinary differential equation for the amplitudes of u_r, u_z, sigma_z and
tau_rz over the depth. Every layer is solved in waves that decay away from its two faces, and the
layers are joined from the bottom up by their reflections (a Riccati recursion). No exponential
grows, so that the accuracy is the same for layers of any thickness and contrast. Contact, and
the field below it: `indentation.py`.

Lengths in mm, moduli and stresses in kPa; z points into the body, wavenumbers xi in 1/mm. Source:
Thomson 1950, Haskell 1953 for layers in series.

A load of 1 mN moves the surface at a distance r by K(r) mm: (1 - nu²) / (pi E r) on a half-space
(Boussinesq 1885), and on layers less the integral of (1 - L(xi)) J0(xi r) d xi in place of 1 / r,
with L of the layers. What integrals of K over facets need is its first moment about the load, the
integral of K(s) s ds from 0 to r, which has no singularity.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from fefinger.theory.contact import elastic
from fefinger.theory.contact.elastic import Array


Base = Literal["bonded", "sliding"]

PRESSURE, SHEAR = (-1.0, 0.0), (0.0, 1.0)
"""Stresses sigma_z and tau_rz of unit loads on the surface."""


@dataclass(frozen=True)
class Layer:
    """An elastic layer: thickness in mm (math.inf: a half-space, last), E in kPa, nu 0 to 0.5."""

    thickness: float
    modulus: float
    poisson: float

    def __post_init__(self) -> None:
        if self.thickness != math.inf:
            elastic.require_positive("Layer", thickness=self.thickness)
        elastic.require_elastic("Layer", self.modulus, self.poisson)

    @property
    def shear(self) -> float:
        """Shear modulus in kPa."""
        return elastic.shear_modulus(self.modulus, self.poisson)


@dataclass(frozen=True)
class Stack:
    """Layers from the skin down, bonded to each other.

    Parameters
    ----------
    layers
        At least one, the top one first. Only the last may be infinitely thick.
    base
        Condition below a last layer of finite thickness: "bonded" to a rigid base (bone), or
        "sliding" on it without friction and without separation.

    Raises
    ------
    ValueError
        No layer, an infinite layer above another, or an unknown base.
    """

    layers: tuple[Layer, ...]
    base: Base = "bonded"

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", tuple(self.layers))
        if not self.layers:
            raise ValueError("Stack: expected at least one layer, received none")
        if any(layer.thickness == math.inf for layer in self.layers[:-1]):
            raise ValueError("Stack: expected only the last layer to be infinitely thick")
        if self.base not in ("bonded", "sliding"):
            msg = f"Stack: expected the base 'bonded' or 'sliding', received {self.base!r}"
            raise ValueError(msg)

    @property
    def thickness(self) -> float:
        """Depth of the rigid base in mm; math.inf on a half-space."""
        return sum(layer.thickness for layer in self.layers)

    @property
    def surface(self) -> tuple[float, float]:
        """Modulus in kPa and Poisson's ratio of the top layer."""
        return self.layers[0].modulus, self.layers[0].poisson

    @property
    def scales(self) -> tuple[float, float]:
        """Smallest and largest length in mm over which the compliance departs from the top layer's.

        Both infinite for a half-space.
        """
        finite = [layer.thickness for layer in self.layers if layer.thickness < math.inf]
        return (finite[0], sum(finite)) if finite else (math.inf, math.inf)

    def compliance(self, xi: ArrayLike) -> Array:
        """Return L (n,) at wavenumbers xi (n,) > 0: u_z of the surface over u_z of a half-space.

        The half-space is of the top layer: u_z = 2 (1 - nu²) / E * L(xi) / xi per unit pressure.
        """
        kernels = self.kernels(xi, 0.0)
        modulus, poisson = self.surface
        return kernels[1] * modulus / (2 * (1 - poisson**2))

    def kernels(self, xi: ArrayLike, z: float) -> Array:
        """Amplitudes (4, n) at the depth z mm per unit pressure at wavenumbers xi (n,).

        They are xi u_r and xi u_z in 1/kPa, and sigma_z and tau_rz (dimensionless), of J1, J0, J0
        and J1 of xi r: u_z(r) = integral of kernel * p(xi) J0(xi r) d xi with p(xi) the Hankel
        transform of the pressure. All four are continuous across an interface. ValueError for
        xi <= 0 or z outside the stack.
        """
        return self.depths(xi, [z])[0]

    def sheared(self, xi: ArrayLike, z: float) -> Array:
        """Amplitudes (4, n) as `kernels`, per unit shear stress tau_rz on the surface instead.

        A traction on the skin is -tau_rz, as z points into the body.
        """
        return self.depths(xi, [z], load=SHEAR)[0]

    def aside(self, xi: ArrayLike, z: float) -> Array:
        """Amplitudes (2, n) at the depth z mm of waves that move across their own direction.

        xi times the displacement, and its derivative in z, in 1/kPa, per unit traction on the skin
        at wavenumbers xi (n,). ValueError as `kernels`.
        """
        xi, _ = self._checked(xi, [z])
        below = np.full_like(xi, math.inf if self.base == "bonded" else 0.0)
        turned = []  # of every layer, bottom up: the wave that rises at its bottom over the other
        for layer in reversed(self.layers):
            part = below / layer.shear
            back = np.where(np.isinf(part), -1.0, (1 - part) / (1 + np.minimum(part, 1e300)))
            back = np.zeros_like(xi) if layer.thickness == math.inf else back
            turned.append(back)
            echo = back * np.exp(-2 * xi * layer.thickness)
            below = layer.shear * (1 - echo) / (1 + echo)
        moved = 1 / below
        for layer, back in zip(self.layers, reversed(turned), strict=True):
            down = moved / (1 + back * np.exp(-2 * xi * layer.thickness))
            if z <= layer.thickness or layer is self.layers[-1]:
                sink = down * np.exp(-xi * z)
                rise = down * back * np.exp(-xi * (2 * layer.thickness - z))
                return np.stack([sink + rise, rise - sink])
            moved = down * np.exp(-xi * layer.thickness) * (1 + back)
            z = z - layer.thickness
        raise AssertionError

    def depths(self, xi: ArrayLike, z: ArrayLike, load: tuple[float, float] = PRESSURE) -> Array:
        """Compute the `kernels` (n_z, 4, n) at several depths z (n_z,) mm by one recursion.

        load: sigma_z and tau_rz on the surface.
        """
        xi, z = self._checked(xi, z)
        waves = self._waves(xi, load)
        out = np.empty((len(z), 4, len(xi)))
        for i, depth in enumerate(z):
            index, local = self.locate(float(depth))
            layer = self.layers[index]
            down, up = waves[index]
            state = self._down(layer, xi * local) @ down[..., None]
            if layer.thickness < math.inf:
                rise = self._up(layer, xi * (local - layer.thickness))
                state += rise @ up[..., None]
            out[i] = state[..., 0].T
        out[:, :2] /= 2 * self.layers[0].shear
        return out

    def _checked(self, xi: ArrayLike, z: ArrayLike) -> tuple[Array, Array]:
        """Return wavenumbers and depths as arrays; ValueError as `kernels`."""
        xi, z = np.atleast_1d(np.asarray(xi, np.float64)), np.asarray(z, np.float64)
        if not (np.all(xi > 0) and np.all(np.isfinite(xi))):
            raise ValueError("Stack: expected wavenumbers above 0 1/mm")
        if not (np.all(z >= 0) and np.all(z <= self.thickness)):
            raise ValueError(f"Stack: expected depths in 0 to {self.thickness:g} mm")
        return xi, z

    def locate(self, z: float) -> tuple[int, float]:
        """Find the index of the layer at the depth z mm and the depth below its top."""
        for index, layer in enumerate(self.layers[:-1]):
            if z <= layer.thickness:
                return index, z
            z -= layer.thickness
        return len(self.layers) - 1, min(z, self.layers[-1].thickness)

    def _waves(self, xi: Array, stress: tuple[float, float]) -> list[tuple[Array, Array]]:
        """Compute the waves of each layer, top first, under a stress on the surface.

        They are the amplitudes (n, 2) of those that decay downward, and of those upward.
        """
        carried, steps = self._join(xi)
        # Rows 2 and 3 of the surface state are its stresses.
        load = np.tile(np.reshape(stress, (2, 1)), (len(xi), 1, 1))
        down = np.asarray(np.linalg.solve(carried[:, 2:], load), np.float64)
        waves = []
        for step in reversed(steps):
            both = step @ down
            waves.append((down[..., 0], both[:, :2, 0]))
            down = np.asarray(both[:, 2:], np.float64)
        if len(waves) < len(self.layers):
            waves.append((down[..., 0], np.zeros((len(xi), 2))))
        return waves

    def _join(self, xi: Array) -> tuple[Array, list[Array]]:
        """Compute the possible states (n, 4, 2) of the surface, and each layer's step, bottom up.

        A step (n, 4, 2) maps the downward waves of a layer to its upward waves and to the downward
        waves of the layer below.
        """
        rest = list(self.layers)
        if rest[-1].thickness == math.inf:
            below = self._down(rest.pop(), np.zeros_like(xi))
        else:
            free = (2, 3) if self.base == "bonded" else (0, 2)
            below = np.zeros((len(xi), 4, 2))
            below[:, free, (0, 1)] = 1.0
        steps = []
        zero = np.zeros_like(xi)
        for layer in reversed(rest):
            matrix = np.concatenate([self._up(layer, zero), -below], axis=2)
            step = np.linalg.solve(matrix, -self._down(layer, xi * layer.thickness))
            below = self._down(layer, zero) + self._up(layer, -xi * layer.thickness) @ step[:, :2]
            steps.append(step)
        return below, steps

    def _down(self, layer: Layer, s: Array) -> Array:
        """Return the two states (n, 4, 2) that decay with s = xi z; stress over 2 G of the top."""
        return self._decaying(layer, s, side=1.0)

    def _up(self, layer: Layer, s: Array) -> Array:
        """Return the two states (n, 4, 2) that decay upward from the bottom, at s = xi z <= 0."""
        return self._decaying(layer, -s, side=-1.0)

    def _decaying(self, layer: Layer, s: Array, *, side: float) -> Array:
        """Solutions (alpha + beta s) exp(-s) of the equation; side -1 mirrors u_z and tau."""
        nu, stiff = layer.poisson, layer.shear / self.layers[0].shear
        one = np.ones_like(s)
        first = [one, side * one, -stiff * one, -side * stiff * one]
        second = [
            s,
            side * (3 - 4 * nu + s),
            -stiff * (2 - 2 * nu + s),
            -side * stiff * (1 - 2 * nu + s),
        ]
        decay: Array = np.exp(-s)
        return decay[:, None, None] * np.moveaxis(np.array([first, second]), (0, 1, 2), (2, 1, 0))


FAR = 30.0
"""Distance over the thickness from which on layers on a rigid base do not move: K r has fallen by
1e-9, where nothing of the layer is compressible, and by more where it is."""


DECAY = 20.0
"""Wavenumber times the thickness of the top layer from which on 1 - L is below 1e-14."""

PANELS, POINTS = 144, 16
"""Panels and points in each of the integrals over wavenumbers, whose phase is DECAY FAR at most."""


class Moment(NamedTuple):
    """Samples of the first moment of K, and of its derivative K(r) r, at equal steps from r = 0.

    step mm; value (n,) mm²/mN and slope (n,) mm/mN.
    """

    step: float
    value: Array
    slope: Array


@lru_cache(maxsize=16)
def moment(stack: Stack) -> Moment:
    """Return the first moment of the displacement around a point load of 1 mN.

    ValueError for layers on an elastic half-space: one layer on a rigid base, or a half-space.
    """
    from scipy.special import j0, j1

    modulus, poisson = stack.surface
    unit = (1 - poisson**2) / (math.pi * modulus)
    fine, thick = stack.scales
    if thick == math.inf:
        wide = 1e4  # distance in mm to which a half-space is tabulated, more than any finger has
        return Moment(wide, unit * np.array([0.0, wide]), unit * np.ones(2))
    if stack.thickness == math.inf:
        raise ValueError("moment: expected a half-space or layers on a rigid base")
    # With 1920 intervals the moment is interpolated to 1e-9 of its largest.
    r = np.linspace(0.0, FAR * thick, 1921)
    xi, weights = _nodes(DECAY / fine)
    left = weights * (1 - stack.compliance(xi))
    value, slope = r.copy(), np.ones_like(r)
    for at in np.array_split(np.arange(len(r)), 32):
        phase = np.multiply.outer(r[at], xi)
        value[at] -= r[at] * (j1(phase) @ (left / xi))
        slope[at] -= r[at] * (j0(phase) @ left)
    slope[-1] = 0.0
    return Moment(float(r[1]), unit * value, unit * slope)


def _nodes(largest: float) -> tuple[Array, Array]:
    """Return nodes and weights (n,) of integrals from 0 to a wavenumber."""
    nodes, weights = np.polynomial.legendre.leggauss(POINTS)
    edges = np.linspace(0.0, largest, PANELS + 1)
    half = np.diff(edges)[:, None] / 2
    return ((edges[:-1, None] + half) + half * nodes).ravel(), (half * weights).ravel()

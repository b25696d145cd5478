"""Response of a finger to small oscillations about a preload: impedance, strain, waves."""

from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fefinger.results.labels import LAYOUT, labeled
from fefinger.results.labels import coordinates as names_along
from fefinger.support.arrays import Array


if TYPE_CHECKING:
    import xarray as xr

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

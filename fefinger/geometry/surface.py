"""Shape of an obstacle from a function of its heights, with derivatives by differences.

The function is a user's own, so it is looked at before it is used: on a grid as wide as a pad, and
between its lines wherever the slope changes much.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fefinger.geometry.profiles import Heights, Profile
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError


REACH, PITCH = 15.0, 0.1
"""Half side and pitch in mm of the grid; a pad reaches no farther from its first touch."""

LINES = np.linspace(-REACH, REACH, round(2 * REACH / PITCH) + 1)
"""Lines of the grid in mm, along x and along y."""

STEP = 2e-4
"""Step in mm of the differences: they err by some 1e-8 where a surface bends within 0.1 mm."""

BEND = 0.05
"""Angle by which a smooth section turns at most in a short interval; a kink of twice that is found
wherever it lies."""

ROUNDING = 1e-9
"""Difference in mm below which two heights are the same."""


Function = Callable[[Array, Array], Array]


@dataclass(frozen=True, eq=False)
class Surface(Profile):
    """A surface of `function`, heights (...,) mm toward the finger at places x, y (...,) mm.

    h counts from the highest place of the grid. `gradient`, if given, returns the derivatives
    (...,) of the height along x and y.

    Raises InputError for heights that are not finite, or no array; a surface with a kink, or that
    rises away from the middle; a gradient of another function.
    """

    function: Function
    gradient: Callable[[Array, Array], tuple[Array, Array]] | None = None

    def _heights(self, x: Array, y: Array) -> Array:
        """Return heights, all of them finite."""
        with np.errstate(all="ignore"):
            try:
                heights = _as_places(self.function(x, y), x)
            except Exception as error:
                raise InputError(
                    "indenter.surface: expected a function of arrays x and y that returns a height "
                    f"for each place, received {type(error).__name__}: {error}; write it with "
                    "functions of NumPy, as np.sqrt and np.where"
                ) from error
        bad = ~np.isfinite(heights)
        if bad.any():
            raise InputError(
                f"indenter.surface: expected finite heights in mm, received {heights[bad][0]} at "
                f"x = {x[bad][0]:.4g}, y = {y[bad][0]:.4g} mm; where the object ends let it fall "
                "steeply, as by 75 degrees"
            )
        return heights

    @cached_property
    def grid(self) -> Array:
        """Heights (n, n) mm on the grid."""
        return self._heights(*np.meshgrid(LINES, LINES, indexing="ij"))

    @cached_property
    def top(self) -> float:
        """Largest height in mm."""
        return float(self.grid.max())

    def rise(self, across: Array) -> Array:
        """Return h alone."""
        return self.top - self._heights(across[..., 0], across[..., 1])

    def incline(self, across: Array) -> Array:
        """Return the slope of h alone."""
        x, y = across[..., 0], across[..., 1]
        if self.gradient is not None:
            along, aside = self.gradient(x, y)
            return -np.stack([_as_places(along, x), _as_places(aside, x)], axis=-1)
        along = self._heights(x + STEP, y) - self._heights(x - STEP, y)
        aside = self._heights(x, y + STEP) - self._heights(x, y - STEP)
        return -np.stack([along, aside], axis=-1) / (2 * STEP)

    def height(self, across: Array) -> Heights:
        """Return h, its slope and its curvature."""
        bend = np.stack(
            [
                (self.incline(across + step) - self.incline(across - step)) / (2 * STEP)
                for step in STEP * np.eye(2)
            ],
            axis=-1,
        )
        return self.rise(across), self.incline(across), (bend + np.swapaxes(bend, -1, -2)) / 2

    def mirrored(self, axis: int) -> bool:
        """Whether it is its own mirror image in the plane in which x (axis 0) or y (1) is 0."""
        return bool(np.abs(self.grid - np.flip(self.grid, axis)).max() <= ROUNDING)

    def check(self) -> None:
        """Raise InputError for a surface that a finger cannot be pressed by, see the class."""
        x, y = np.meshgrid(LINES, LINES, indexing="ij")
        # Distance in mm within which a finger meets the highest place of an object first.
        middle = 10.0
        if self.grid[np.hypot(x, y) <= middle].max() < self.top - ROUNDING:
            at = np.unravel_index(int(np.argmax(self.grid)), x.shape)
            raise InputError(
                f"indenter.surface: expected its largest value within {middle:g} mm of the middle, "
                f"where the finger is, received {self.top:.4g} mm at x = {x[at]:.4g}, "
                f"y = {y[at]:.4g} mm; heights are in mm toward the finger: change their sign if "
                "they are depths"
            )
        _ = self.least_radius
        if self.gradient is not None:
            places = np.stack([x, y], axis=-1)
            differences = Surface(self.function).incline(places)
            off = np.abs(self.incline(places) - differences).max(axis=-1)
            # More is no rounding of differences of the heights.
            if (worst := float(off.max())) > 1e-3 * (1 + float(np.abs(differences).max())):
                at = np.unravel_index(int(np.argmax(off)), x.shape)
                raise InputError(
                    "indenter.gradient: expected the derivatives of the height along x and y, "
                    f"received some that differ from its differences by {worst:.3g} at "
                    f"x = {x[at]:.4g}, y = {y[at]:.4g} mm"
                )

    @cached_property
    def least_radius(self) -> float:
        """Smallest radius in mm of a crest, infinite for a plane; InputError for a kink."""
        grid = np.stack(np.meshgrid(LINES[::2], LINES[::2], indexing="ij"), axis=-1).reshape(-1, 2)
        _, slope, bend = self.height(np.concatenate([grid, self._bent(0), self._bent(1)]))
        # The larger eigenvalue of the shape operator: that of the Hessian, but on steep sides.
        steep = 1 + np.sum(slope**2, axis=1)
        along = np.einsum("ni, nij, nj -> n", slope, bend, slope)
        mean = (np.trace(bend, axis1=1, axis2=2) - along / steep) / (2 * np.sqrt(steep))
        product = np.linalg.det(bend) / steep**2
        curvature = float((mean + np.sqrt(np.maximum(mean**2 - product, 0.0))).max())
        flat = 1e-6  # curvature in 1/mm that is rounding of the differences
        return 1 / curvature if curvature > flat else float("inf")

    def _bent(self, axis: int) -> Array:
        """Return places (n, 2) mm where sections along x (axis 0) or y bend; InputError for a kink.

        Intervals in which a section turns by more than BEND are halved until none does.
        """
        middle, fixed = (x.ravel() for x in np.meshgrid(LINES[1:-1], LINES[::2], indexing="ij"))
        half, turn, found = PITCH, self._turns(middle, fixed, PITCH, axis), np.empty((0, 2))
        # Half length in mm of an interval in which a turn by more than BEND is a kink.
        shortest = 1e-5
        while (bent := turn > BEND).any():
            middle, fixed, turn = middle[bent], fixed[bent], turn[bent]
            order = [0, 1] if axis == 0 else [1, 0]
            found = np.stack([middle, fixed], axis=-1)[:, order]
            if half < shortest:
                at = np.argmin(np.abs(fixed))
                x, y = found[at]
                raise InputError(
                    "indenter.surface: expected a smooth surface, received one that turns by some "
                    f"{np.degrees(turn[at]):.0f} degrees at once at x = {x:.4g}, y = {y:.4g} mm; "
                    "round its edges"
                )
            half /= 2
            # A kink lies in one half of the interval, or between both.
            near = middle[:, None] + half * np.array([-1.0, 0.0, 1.0])
            turns = self._turns(near, fixed[:, None] + np.zeros(3), half, axis)
            most = np.arange(len(near)), np.argmax(turns, axis=1)
            middle, turn = near[most], turns[most]
        return found

    def _turns(self, middle: Array, fixed: Array, half: float, axis: int) -> Array:
        """Return the angles in which sections turn over intervals around `middle`."""

        def at(moved: Array) -> Array:
            return self._heights(*((moved, fixed) if axis == 0 else (fixed, moved)))

        before, here, after = at(middle - half), at(middle), at(middle + half)
        return np.abs(np.arctan((here - before) / half) - np.arctan((after - here) / half))


def _as_places(given: object, x: Array) -> Array:
    """Return real numbers at the places of x (...,); TypeError for complex ones and objects."""
    return np.broadcast_to(np.asarray(given).astype(np.float64, casting="same_kind"), x.shape)

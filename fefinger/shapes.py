"""Objects for `ff.TactileFinger`, by their signed distance; in mm, each in its own frame.

    ff.shapes.Sphere(10)
    ff.shapes.Box(20, 20, 20, edge=0.5)
    ff.shapes.mesh("mug.stl", pitch=0.25)
    ff.shapes.Soft(ff.shapes.Sphere(10), modulus=50)

They are rigid unless they are `Soft`. The origin of a frame is the center of the object, and its
axis is z. `Plane` fills z < 0.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from fefinger.contact import signed_distance
from fefinger.contact.signed_distance import Shapes
from fefinger.geometry.surface_repair import grid, sampled_surface
from fefinger.support.arrays import Array
from fefinger.support.checks import InputError, number, set_number
from fefinger.theory.contact.stack import Layer, Stack


__all__ = [
    "Box",
    "Capsule",
    "Cylinder",
    "Ellipsoid",
    "Plane",
    "Sampled",
    "Shape",
    "Soft",
    "Sphere",
    "function",
    "mesh",
    "sampled",
]


SLOPE = 0.5, 1.5
"""Range of the length of the gradient of a signed distance; between grid points an edge lessens
it."""

DISTANCE = (
    "{}: expected signed distances in mm, negative inside, whose gradient has length 1, received "
    "{}; give the distance to the surface"
)


class Shape(ABC):
    """An object that is known by its signed distance."""

    @property
    @abstractmethod
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes, as of `contact.signed_distance.Shapes`."""

    @property
    def grid(self) -> "Sampled | None":
        """The object itself where its distances are samples."""
        return None

    @property
    def soft_body(self) -> Stack | None:
        """The elastic body of a soft object; None where it is rigid."""
        return None

    def distance(self, points: ArrayLike) -> Array:
        """Return the signed distance (n,) mm of points (n, 3) in the frame of the object."""
        places = np.array(points, float).reshape(-1, 3)
        return np.asarray(signed_distance.distances(packed([self]), 0, places)[:, 0])


@dataclass(frozen=True)
class Plane(Shape):
    """The half-space z < 0: its outward normal is z."""

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.PLANE, ()


@dataclass(frozen=True)
class Sphere(Shape):
    """A ball of a radius in mm."""

    radius: float

    def __post_init__(self) -> None:
        set_number(self, "radius", above=0, unit="mm")

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.SPHERE, (self.radius,)


@dataclass(frozen=True)
class Box(Shape):
    """A box of whole sides in mm along x, y and z; edge: radius in mm of its edges."""

    x: float
    y: float
    z: float
    edge: float = 0.1

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            set_number(self, name, above=0, unit="mm")
        most = min(self.x, self.y, self.z) / 2
        set_number(self, "edge", at_least=0, at_most=most, unit="mm")

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.BOX, (self.x / 2, self.y / 2, self.z / 2, self.edge)


@dataclass(frozen=True)
class Capsule(Shape):
    """A cylinder of a radius and a length in mm along z, with a half ball at either end."""

    radius: float
    length: float

    def __post_init__(self) -> None:
        set_number(self, "radius", above=0, unit="mm")
        set_number(self, "length", at_least=0, unit="mm")

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.CAPSULE, (self.radius, self.length / 2)


@dataclass(frozen=True)
class Cylinder(Shape):
    """A cylinder of a radius and a length in mm along z; edge: radius in mm of its rims."""

    radius: float
    length: float
    edge: float = 0.1

    def __post_init__(self) -> None:
        set_number(self, "radius", above=0, unit="mm")
        set_number(self, "length", above=0, unit="mm")
        most = min(self.radius, self.length / 2)
        set_number(self, "edge", at_least=0, at_most=most, unit="mm")

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.CYLINDER, (self.radius, self.length / 2, self.edge)


@dataclass(frozen=True)
class Ellipsoid(Shape):
    """An ellipsoid of semi-axes in mm along x, y and z."""

    x: float
    y: float
    z: float

    def __post_init__(self) -> None:
        for name in ("x", "y", "z"):
            set_number(self, name, above=0, unit="mm")

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.ELLIPSOID, (self.x, self.y, self.z)


@dataclass(frozen=True)
class Soft(Shape):
    """An object that is elastic, of a modulus in kPa: as `modulus` of an indenter of a scene.

    Its surface gives way as that of a flat half-space, or of a layer of a thickness in mm on a
    rigid base: an approximation in the sense of Hertz, which leaves out edges.

    Raises
    ------
    InputError
        A number out of its limits; an object known by samples, whose edges may be anywhere.
    """

    shape: Shape
    modulus: float
    poisson: float = 0.5
    thickness: float | None = None

    def __post_init__(self) -> None:
        samples = isinstance(self.shape, Shape) and self.shape.grid is not None
        if not isinstance(self.shape, Shape) or samples or isinstance(self.shape, Soft):
            raise InputError(
                "shape: expected a plane, sphere, box, capsule, cylinder or ellipsoid that is "
                f"soft, received {self.shape!r}"
            )
        set_number(self, "modulus", above=0, unit="kPa")
        set_number(self, "poisson", above=0, at_most=0.5)
        if self.thickness is not None:
            set_number(self, "thickness", above=0, unit="mm")

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes of the shape."""
        return self.shape.row

    @property
    def soft_body(self) -> Stack:
        """The elastic body."""
        return Stack((Layer(self.thickness or math.inf, self.modulus, self.poisson),))


@dataclass(frozen=True, eq=False)
class Sampled(Shape):
    """An object by distances on a grid, between which they are linear: see `sampled`."""

    samples: Array = field(repr=False)
    low: tuple[float, float, float]
    pitch: float

    @property
    def grid(self) -> "Sampled":
        """The object itself."""
        return self

    @property
    def row(self) -> tuple[int, tuple[float, ...]]:
        """Kind and sizes."""
        return signed_distance.SAMPLED, ()


def sampled(samples: ArrayLike, low: Sequence[float], pitch: float) -> Sampled:
    """Return the object of signed distances (nx, ny, nz) mm on a grid.

    low (3,) mm: the first point of the grid; pitch mm: the distance of its points. Against a
    sphere of 10 mm the force is .9 % off at a pitch of .5 mm and .2 % at .25 mm.

    Raises
    ------
    InputError
        If the distances are not finite, have no surface among them or are no distances.
    """
    pitch = number("pitch", pitch, above=0, unit="mm")
    values = np.asarray(samples, float)
    if values.ndim != 3 or min(values.shape) < 2:
        raise InputError(
            "samples: expected distances (nx, ny, nz) with two or more along each axis, received "
            f"an array of shape {values.shape}"
        )
    if not np.isfinite(values).all():
        raise InputError("samples: expected finite distances in mm, received nan or inf")
    if not (values.min() < 0.0 < values.max()):
        received = f"{values.min():.3g} to {values.max():.3g} mm, none of them a surface"
        raise InputError(DISTANCE.format("samples", received))
    slopes = np.linalg.norm(np.stack(np.gradient(values, pitch)), axis=0)
    near = np.abs(values) < 2 * pitch
    typical = float(np.median(slopes[near])) if near.any() else 0.0
    if not SLOPE[0] < typical < SLOPE[1]:
        raise InputError(DISTANCE.format("samples", f"{typical:.3g} near the surface"))
    x, y, z = (number("low", each, unit="mm") for each in low)
    return Sampled(values.astype(np.float32), (x, y, z), pitch)


def function(
    f: Callable[[Array], ArrayLike], low: ArrayLike, high: ArrayLike, *, pitch: float = 0.25
) -> Sampled:
    """Return the object whose signed distance in mm is f(points (n, 3)), sampled within a box.

    low, high (3,) mm: corners of the box, some 0.8 mm beyond the surface. InputError as `sampled`,
    or for values of another shape.
    """
    pitch = number("pitch", pitch, above=0, unit="mm")
    corner, opposite = np.asarray(low, float), np.asarray(high, float)
    if not (corner.shape == opposite.shape == (3,) and (corner < opposite).all()):
        raise InputError(f"low, high: expected corners (3,) of a box, received {low!r}, {high!r}")
    points, shape = grid(corner, opposite, pitch)
    values = np.asarray(f(points), float)
    if values.shape != (len(points),):
        raise InputError(
            f"f: expected a distance of each of {len(points)} points, received an array of shape "
            f"{values.shape}"
        )
    return sampled(values.reshape(shape), corner.tolist(), pitch)


def mesh(path: str | PathLike[str], *, pitch: float = 0.25) -> Sampled:
    """Return the object within a closed surface in mm, from a file such as an STL.

    Its distance is sampled at a pitch in mm. InputError if the file holds no surface, or one that
    is open or inside out.
    """
    pitch = number("pitch", pitch, above=0, unit="mm")
    # The grid goes 0.8 mm beyond the surface, farther than skin feels an object.
    values, low = sampled_surface(str(path), pitch, 0.8)
    return sampled(values, low.tolist(), pitch)


def packed(shapes: Sequence[Shape]) -> Shapes:
    """Return some objects as compiled code reads them."""
    count = len(shapes)
    grids = [each.grid for each in shapes]
    sizes = np.zeros((count, 4))
    for row, each in zip(sizes, shapes, strict=True):
        row[: len(each.row[1])] = each.row[1]
    lengths = [0 if each is None else each.samples.size for each in grids]
    flat = [np.zeros(1)] + [each.samples.ravel() for each in grids if each is not None]
    return Shapes(
        kind=np.array([each.row[0] for each in shapes], dtype=np.int64),
        size=sizes,
        samples=np.concatenate(flat).astype(np.float64),
        start=1 + np.concatenate([[0], np.cumsum(lengths)[:-1]]).astype(np.int64)[:count],
        counts=np.array(
            [(2, 2, 2) if each is None else each.samples.shape for each in grids], dtype=np.int64
        ).reshape(-1, 3),
        low=np.array([(0.0,) * 3 if each is None else each.low for each in grids]).reshape(-1, 3),
        pitch=np.array([1.0 if each is None else each.pitch for each in grids]),
    )

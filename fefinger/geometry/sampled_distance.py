"""Signed distance of a closed surface from a file, sampled on a grid."""

from pathlib import Path

import numpy as np

from fefinger.support.arrays import Array
from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


def grid(low: Array, high: Array, pitch: float) -> tuple[Array, tuple[int, int, int]]:
    """Return the points (n, 3) mm of a grid from one corner to beyond the other, and its shape.

    InputError for more points than fit.
    """
    count = np.maximum(np.ceil((high - low) / pitch).astype(int) + 1, 2)
    most = 20_000_000  # points of a grid, some 80 MB of distances
    if np.prod(count.astype(float)) > most:
        raise InputError(
            f"pitch: expected at most {most:,} points of a grid, received "
            f"{' x '.join(map(str, count.tolist()))} at {pitch:g} mm; take a coarser pitch",
            field="pitch",
        )
    axes = [corner + pitch * np.arange(n) for corner, n in zip(low, count, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return points, tuple(count.tolist())


def sampled_surface(path: str | Path, pitch: float, margin: float) -> tuple[Array, Array]:
    """Sample the signed distance of a closed surface, on a grid that goes `margin` mm beyond it.

    Returns the distances (nx, ny, nz) mm, negative inside, and the first point (3,) mm.

    Raises InputError if there is no such file, it holds no surface, or the surface is open or
    inside out.
    """
    import pyvista as pv
    import trimesh

    check_input("mesh", path, "a closed surface in mm, such as an STL file")
    file = Path(path)
    try:
        mesh = trimesh.load_mesh(file)
        corners, triangles = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    except Exception as error:  # each format fails in its own way
        message = f"mesh: expected a surface such as an STL, received {file.name}: {error}"
        raise InputError(message, field="mesh") from error
    if not len(triangles) or not np.isfinite(corners).all():
        message = f"mesh: expected triangles with finite corners, received none in {file.name}"
        raise InputError(message, field="mesh")
    if not mesh.is_watertight:
        raise InputError(
            f"mesh: expected a closed surface, received one with holes in {file.name}; fill them",
            field="mesh",
        )
    if mesh.volume <= 0.0:
        raise InputError(
            f"mesh: expected triangles whose normals point outward, received {file.name}, which "
            "is inside out; turn its triangles",
            field="mesh",
        )
    low, high = mesh.bounds[0] - margin, mesh.bounds[1] + margin
    points, shape = grid(low, high, pitch)
    faces = np.column_stack([np.full(len(triangles), 3), triangles]).ravel()
    cloud = pv.PolyData(points).compute_implicit_distance(pv.PolyData(corners, faces))
    return np.asarray(cloud["implicit_distance"], float).reshape(shape), np.asarray(low)

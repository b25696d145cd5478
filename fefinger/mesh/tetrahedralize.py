"""pytetwild with a sizing field: conforming tetrahedra around the surfaces of a finger."""

import itertools
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fefinger.mesh import tetwild_process
from fefinger.mesh.shell_triangles import Triangles
from fefinger.support import processes
from fefinger.support.atomic_write import temporary_folder
from fefinger.support.checks import ConvergenceError


Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Settings:
    """Edge lengths in mm and how closely the mesher follows the surfaces.

    Attributes
    ----------
    pad : edge length on the contact patch and in the skin below it.
    deep, far : growth of the edge length per mm below the skin and beyond the patch.
    largest : largest edge length.
    envelope : how far a vertex may leave its surface, over the diagonal of the finger.
    facet : edge length of the input surfaces' triangles.

    """

    pad: float
    deep: float = 0.3
    far: float = 0.5
    largest: float = 3.0
    envelope: float = 3e-3
    facet: float = 0.7


def tetrahedra(
    surfaces: list[Triangles],
    size: Callable[[Array], Array],
    settings: Settings,
) -> tuple[Array, Index]:
    """Return vertices (n, 3) mm and positive cells (m, 4) that fill a box around the surfaces.

    The surfaces, open or closed, appear as faces within the envelope; nothing is removed outside.
    Raises ConvergenceError where the mesher fails.
    """
    points, triangles = _joined(surfaces)
    box = np.array([points.min(axis=0) - 1.0, points.max(axis=0) + 1.0])
    nodes, cells = _grid(box, max(settings.pad, 0.6))
    vertices, found = _apart(
        vertices=points,
        faces=triangles.astype(np.int32),
        edge_length_abs=settings.largest,
        epsilon=settings.envelope,
        bg_vertices=nodes,
        bg_tets=cells.astype(np.int32),
        bg_values=size(nodes),
    )
    # fTetWild lists the corners of a cell the other way round.
    return np.asarray(vertices, dtype=float), found.astype(np.int64)[:, [0, 2, 1, 3]]


def _apart(**given: Any) -> tuple[Array, Index]:
    """Return the vertices and cells of what is `given` to `tetwild`, run beside this process."""
    with temporary_folder() as folder:
        np.savez(folder / tetwild_process.GIVEN, **given)
        with processes.running(
            processes.command("-m", tetwild_process.__name__, str(folder)),
            cwd=folder,  # fTetWild writes __tracked_surface.stl into its working folder
            env=processes.environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        ) as mesher:
            _, text = mesher.communicate()
        if mesher.returncode:
            said = (text.strip().splitlines() or ["nothing"])[-1]
            message = f"mesher: it ended with status {mesher.returncode} and said: {said}"
            raise ConvergenceError(message)
        with np.load(folder / tetwild_process.FOUND) as found:
            return found["vertices"], found["cells"]


def _joined(surfaces: list[Triangles]) -> Triangles:
    """Return the surfaces as one list of triangles."""
    starts = np.cumsum([0, *(len(points) for points, _ in surfaces)])[:-1]
    faces = [part + start for (_, part), start in zip(surfaces, starts, strict=True)]
    return np.concatenate([points for points, _ in surfaces]), np.concatenate(faces)


def _grid(box: Array, step: float) -> tuple[Array, Index]:
    """Return a grid of cubes cut in six tetrahedra each, which carries the sizes."""
    axes = [np.linspace(a, b, int(np.ceil((b - a) / step)) + 1) for a, b in box.T]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    index = np.arange(nodes[..., 0].size).reshape(nodes.shape[:3])
    counts = [len(axis) - 1 for axis in axes]
    parts = []
    for order in itertools.permutations(range(3)):
        corner = np.zeros(3, dtype=int)
        path = [corner.copy()]
        for axis in order:
            corner[axis] = 1
            path.append(corner.copy())
        cell = [index[a : a + counts[0], b : b + counts[1], c : c + counts[2]] for a, b, c in path]
        flip = np.linalg.det(np.diff(path, axis=0)) < 0
        cell = [cell[i].ravel() for i in ([0, 1, 3, 2] if flip else [0, 1, 2, 3])]
        parts.append(np.stack(cell, axis=1))
    return nodes.reshape(-1, 3), np.concatenate(parts)

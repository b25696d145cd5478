"""Tetrahedral meshing with pytetwild and a sizing field, in a process of its own.

In the caller's process pytetwild would hold the interpreter lock, catch Ctrl-C, print, and on
failure end the process: `python -m fefinger.mesh.tetrahedralize FOLDER` runs it.
"""

import itertools
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fefinger.mesh.shell import Triangles
from fefinger.support import processes
from fefinger.support.arrays import Array, Integers
from fefinger.support.atomic_write import temporary_folder
from fefinger.support.checks import ConvergenceError


LIMIT = 900.0
"""Seconds after which the mesher is ended, and after which no other meshing begins; a fine mesh of
a finger takes some 40, four times that on a busy machine."""

ARGUMENTS, MESH = "arguments.npz", "mesh.npz"
"""Files of the folder: the arguments of `pytetwild.tetrahedralize`, and its result."""


@dataclass(frozen=True)
class MesherSettings:
    """Settings of the mesher: edge lengths in mm, and the tolerance of the surfaces.

    Attributes
    ----------
    pad : edge length on the contact patch and in the skin below it.
    deep, far : growth of the edge length per mm below the skin and beyond the patch.
    largest : largest edge length.
    envelope : largest distance of a vertex from its surface, over the diagonal of the finger.
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
    settings: MesherSettings,
) -> tuple[Array, Integers]:
    """Mesh a box around the surfaces: vertices (n, 3) mm and positively oriented cells (m, 4).

    The surfaces, open or closed, appear as faces within the envelope; cells outside them are kept.
    Raises ConvergenceError if the mesher fails or is not done after LIMIT.
    """
    starts = np.cumsum([0, *(len(part) for part, _ in surfaces)])
    points = np.concatenate([part for part, _ in surfaces])
    triangles = np.concatenate([part + at for (_, part), at in zip(surfaces, starts, strict=False)])
    box = np.array([points.min(axis=0) - 1.0, points.max(axis=0) + 1.0])
    nodes, cells = _grid(box, max(settings.pad, 0.6))
    vertices, tetrahedra_of_box = _in_process(
        vertices=points,
        faces=triangles.astype(np.int32),
        edge_length_abs=settings.largest,
        epsilon=settings.envelope,
        bg_vertices=nodes,
        bg_tets=cells.astype(np.int32),
        bg_values=size(nodes),
    )
    # fTetWild orients cells negatively.
    return np.asarray(vertices, dtype=float), tetrahedra_of_box.astype(np.int64)[:, [0, 2, 1, 3]]


def _in_process(**arguments: Any) -> tuple[Array, Integers]:
    """Run the mesher with `arguments` in a process of its own; return its vertices and cells."""
    with temporary_folder() as folder:
        np.savez(folder / ARGUMENTS, **arguments)
        with processes.running(
            processes.command("-m", "fefinger.mesh.tetrahedralize", str(folder)),
            cwd=folder,  # fTetWild writes __tracked_surface.stl into its working folder
            env=processes.environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        ) as mesher:
            try:
                _, text = mesher.communicate(timeout=LIMIT)
            except subprocess.TimeoutExpired:
                message = (
                    "mesher: sharp edges or creases of a scan may keep it busy, which the program "
                    f"that made it can smooth; it was not done after {LIMIT:g} s"
                )
                raise ConvergenceError(message) from None
        if mesher.returncode:
            last = (text.strip().splitlines() or ["none"])[-1]
            message = f"mesher: it ended with status {mesher.returncode}; its last message: {last}"
            raise ConvergenceError(message)
        with np.load(folder / MESH) as mesh:
            return mesh["vertices"], mesh["cells"]


def _grid(box: Array, step: float) -> tuple[Array, Integers]:
    """Build the background grid of the sizing field: cubes of six tetrahedra each."""
    axes = [np.linspace(a, b, int(np.ceil((b - a) / step)) + 1) for a, b in box.T]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    index = np.arange(nodes[..., 0].size).reshape(nodes.shape[:3])
    counts = [len(axis) - 1 for axis in axes]
    parts = []
    for order in itertools.permutations(range(3)):  # of the axes, on the way to the far corner
        steps = np.eye(3, dtype=int)[list(order)]
        path = [np.zeros(3, dtype=int), *np.cumsum(steps, axis=0)]
        if np.linalg.det(steps) < 0:
            path[2:] = path[:1:-1]
        corners = (tuple(slice(a, a + n) for a, n in zip(at, counts, strict=True)) for at in path)
        parts.append(np.stack([index[corner].ravel() for corner in corners], axis=1))
    return nodes.reshape(-1, 3), np.concatenate(parts)


def main(folder: Path) -> None:
    """Mesh the surfaces in a folder; write the mesh there."""
    import pytetwild

    with np.load(folder / ARGUMENTS) as arrays:
        arguments = {key: arrays[key] if arrays[key].ndim else arrays[key].item() for key in arrays}
    vertices, cells = pytetwild.tetrahedralize(
        **arguments, coarsen=True, disable_filtering=True, num_threads=1
    )
    np.savez(folder / MESH, vertices=vertices, cells=cells)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

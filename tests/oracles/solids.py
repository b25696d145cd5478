"""What a mesh and a shell enclose: closed boundaries, and volumes by other ways than cells."""

import numpy as np

from fefinger.geometry.finger_mesh import FACETS, FingerMesh, faces
from fefinger.mesh.shell import Shell


def assert_closed(mesh: FingerMesh, *inside: str) -> None:
    """Assert that the facets but those `inside` are the faces of one cell, and close the mesh."""
    every = np.sort(faces(mesh.cells).reshape(-1, 3), axis=1)
    unique, count = np.unique(every, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    named = np.concatenate([mesh.facets[name] for name in FACETS if name not in inside])
    assert np.array_equal(np.unique(np.sort(named, axis=1), axis=0), unique[count == 1])
    assert len(named) == np.sum(count == 1)
    sides = np.sort(named[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert set(np.unique(sides, axis=0, return_counts=True)[1]) == {2}


def enclosed(mesh: FingerMesh, *names: str) -> float:
    """Return the volume in mm^3 inside facets, by the divergence theorem."""
    return sum(float(np.linalg.det(mesh.points[mesh.facets[name]]).sum()) / 6 for name in names)


def section_volume(shell: Shell) -> float:
    """Return the volume in mm^3 of half a shell: its sections, integrated along it."""
    x = np.linspace(shell.cut, shell.tip, 4001)
    wide, low, high = shell.heights(x)
    return float(np.trapezoid(np.pi / 4 * wide * (low + high), x))

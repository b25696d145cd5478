"""Finger meshes on disk: a .vtu file that opens in ParaView and a sidecar .json beside it.

The .vtu holds two cell blocks: the tetrahedra with their region, and the triangles of the named
facets with a tag; a tetrahedron has facet tag 0 and a triangle region 0. The sidecar names the
tags and records recipe, versions, quality and the hash of the .vtu.
"""

import hashlib
import json
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.geometry.finger_mesh import FACETS, FingerMesh
from fefinger.support import VERSION
from fefinger.support.atomic_write import moved
from fefinger.support.checks import InputError


if TYPE_CHECKING:
    from meshio import Mesh


LAYOUT = 1
"""Version of the file layout; a reader refuses another."""

TAGS = {name: number for number, name in enumerate(FACETS, start=1)}
"""Numbers of the facet sets in a file."""

NEEDED = ("name", "half", "facet_tags", "sha256", "recipe", "quality")
"""Fields that a sidecar must have."""

TOOLS = ("pytetwild", "numpy", "scipy")
"""Libraries whose version affects the mesh, besides fefinger's own."""


def write(mesh: FingerMesh, path: str | Path) -> Path:
    """Write a mesh to `path` (.vtu) and its sidecar; each appears whole or not at all."""
    import meshio

    path = _checked(path)
    sets = {name: mesh.facets.get(name, np.empty((0, 3), dtype=np.int64)) for name in TAGS}
    tags = np.repeat(list(TAGS.values()), [len(part) for part in sets.values()])
    triangles = np.concatenate(list(sets.values()))
    region = [mesh.region.astype(np.int8), np.zeros(len(triangles), dtype=np.int8)]
    facet = [np.zeros(len(mesh.cells), dtype=np.int8), tags.astype(np.int8)]
    content = meshio.Mesh(
        mesh.points,
        [("tetra", mesh.cells.astype(np.int32)), ("triangle", triangles.astype(np.int32))],
        point_data={"pad_normal": mesh.pad_normals},
        cell_data={"region": region, "facet": facet},
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with moved(path) as new:
        meshio.write(str(new), content, file_format="vtu")
    sidecar = {
        "layout": LAYOUT,
        "name": mesh.name,
        "half": mesh.half,
        "frame": "x distal, y radial, z dorsal, mm; origin at first touch of a 30-degree plate",
        "facet_tags": TAGS,
        "sha256": _hash(path),
        "recipe": mesh.recipe,
        "versions": {"fefinger": VERSION, **{tool: version(tool) for tool in TOOLS}},
        "quality": mesh.quality,
    }
    text = json.dumps(sidecar, indent=1) + "\n"
    with moved(sidecar_path(path)) as new:
        new.write_text(text, encoding="utf-8")
    return path


def read(path: str | Path) -> FingerMesh:
    """Read a mesh from a .vtu file and its sidecar.

    Raises InputError if either is missing or the .vtu is not the one the sidecar was written for.
    """
    import meshio

    path = _checked(path)
    for part in (path, sidecar_path(path)):
        if not part.is_file():
            message = f"mesh: expected the file {part}, which does not exist; build the mesh again"
            raise InputError(message)
    sidecar = _sidecar(sidecar_path(path))
    sha256 = _hash(path)
    if sha256 != sidecar["sha256"]:
        raise InputError(
            f"mesh: expected {path} to have the hash {sidecar['sha256'][:12]}... of its sidecar, "
            f"received {sha256[:12]}...; one of the two was changed, build the mesh again"
        )
    return _mesh(meshio.read(path, file_format="vtu"), sidecar)


def sidecar_path(path: Path) -> Path:
    """Return the path of the sidecar of a mesh file."""
    return path.with_suffix(".json")


def _sidecar(path: Path) -> dict[str, Any]:
    """Read a sidecar; raise InputError if it has another layout or lacks a field."""
    try:
        sidecar = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(f"mesh: expected JSON in {path}, received {error}") from error
    layout = sidecar.get("layout") if isinstance(sidecar, dict) else None
    if layout != LAYOUT:
        raise InputError(
            f"mesh: expected layout {LAYOUT} in {path}, received {layout!r}; build the mesh again"
        )
    missing = [name for name in NEEDED if name not in sidecar]
    if missing:
        message = f"mesh: expected {missing[0]!r} in {path}, received none; build the mesh again"
        raise InputError(message)
    return dict(sidecar)


def _mesh(content: "Mesh", sidecar: dict[str, Any]) -> FingerMesh:
    """Make the mesh record from a meshio mesh and its sidecar."""
    cells = np.asarray(content.cells_dict["tetra"], dtype=np.int64)
    triangles = np.asarray(content.cells_dict["triangle"], dtype=np.int64)
    tags = content.cell_data_dict["facet"]["triangle"]
    facets = {name: triangles[tags == tag] for name, tag in sidecar["facet_tags"].items()}
    return FingerMesh(
        np.asarray(content.points, dtype=np.float64),
        cells,
        np.asarray(content.cell_data_dict["region"]["tetra"], dtype=np.int8),
        {name: part for name, part in facets.items() if len(part)},
        np.asarray(content.point_data["pad_normal"], dtype=np.float64),
        half=bool(sidecar["half"]),
        name=str(sidecar["name"]),
        recipe=sidecar["recipe"],
        quality=sidecar["quality"],
        source_sha256=str(sidecar["sha256"]),
    )


def _checked(path: str | Path) -> Path:
    """Check that a path ends in .vtu."""
    path = Path(path)
    if path.suffix != ".vtu":
        raise InputError(f"mesh: expected a file name that ends in .vtu, received {path.name!r}")
    return path


def _hash(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()

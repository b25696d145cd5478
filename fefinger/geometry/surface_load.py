"""Triangles of a surface from an STL, OBJ, PLY or VTK file, as they are there."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.support.checks import InputError
from fefinger.support.inputs import check_input


if TYPE_CHECKING:
    from pyvista import DataSet
    from trimesh import Trimesh


VTK = (".vtk", ".vtp", ".vtu")
FORMATS = (".stl", ".obj", ".ply", *VTK)
"""Endings of surface files; other formats, as archives, have no bound on what they unpack to."""

FARTHEST = 1e6
"""Bound of coordinates in mm; squares of larger ones overflow in areas and volumes."""

HEADER, TRIANGLE = 84, 50
"""Bytes of a binary STL before its first triangle, and of each triangle."""


def load(path: str | Path, field: str) -> "tuple[Trimesh, tuple[str, ...]]":
    """Load the triangles (trimesh) of a file, with notes on what does not fit in it.

    Raises InputError of `field` if it has none, or others than finite ones below FARTHEST.
    """
    import trimesh

    check_input(field, path, "a surface file")
    file, notes = Path(path), tuple[str, ...]()
    try:
        if file.suffix.lower() not in FORMATS:
            raise ValueError(f"of an unknown format, {file.suffix!r}")
        if file.suffix.lower() in VTK:
            outer = _read_vtk(file).extract_surface(algorithm=None).triangulate()
            points = np.array(outer.points, dtype=float)
            mesh = trimesh.Trimesh(points, np.array(outer.regular_faces))
        else:
            source: Any = file
            if file.suffix.lower() == ".stl":
                source, notes = _stl(file, field)
            with np.errstate(over="ignore", invalid="ignore"):
                mesh = trimesh.load_mesh(source, file_type=file.suffix.lower()[1:])
        count = len(mesh.faces)
    except InputError:
        raise
    except Exception as error:
        raise InputError(
            f"{field}: expected a triangle surface (STL, OBJ, PLY or VTK), received "
            f"{str(file)!r}, which cannot be read as one; export it again"
        ) from error
    if count == 0:
        raise InputError(f"{field}: expected a surface, {file.name} has no triangles")
    if not (np.abs(mesh.vertices) < FARTHEST).all():
        raise InputError(
            f"{field}: expected finite coordinates, below {FARTHEST:g} mm, {file.name} has others"
        )
    return mesh, notes


def _stl(file: Path, field: str) -> tuple[io.BytesIO, tuple[str, ...]]:
    """Return the bytes of an STL that fit together, with a note on those that do not.

    Raises InputError for one that ends before its last triangle.
    """
    data = file.read_bytes()
    if data.lstrip()[:5].lower() == b"solid" and b"facet" in data[:1000].lower():
        return _ascii(data, file, field)
    if len(data) < HEADER:
        return io.BytesIO(data), ()
    said = int.from_bytes(data[HEADER - 4 : HEADER], "little")
    held, left = divmod(len(data) - HEADER, TRIANGLE)
    if said > held:
        raise InputError(
            f"{field}: expected {said} triangles in {file.name}, as its first {HEADER} bytes say, "
            f"received {len(data)} bytes, which hold {held}: it was cut short, or the number is "
            "wrong; copy or export it again"
        )
    if said == held and left == 0:
        return io.BytesIO(data), ()
    note = f"{len(data) - HEADER - TRIANGLE * said} bytes of {file.name} after its last triangle"
    note += " were left out."
    if said == 0 and held > 0:
        said, note = held, f"{file.name} says that it has 0 triangles; the {held} it holds count."
    body = data[HEADER : HEADER + TRIANGLE * said]
    return io.BytesIO(data[: HEADER - 4] + said.to_bytes(4, "little") + body), (note,)


def _ascii(data: bytes, file: Path, field: str) -> tuple[io.BytesIO, tuple[str, ...]]:
    """Return an STL of text with an end, and a note where it had none."""
    text = data.lower()
    if b"endsolid" in text:
        return io.BytesIO(data), ()
    begun, ended = (len(text.split(word)) - 1 for word in (b"facet normal", b"endfacet"))
    if begun != ended or begun == 0:
        raise InputError(
            f"{field}: expected as many `endfacet` as `facet normal` in {file.name}, received "
            f"{ended} and {begun}, and no `endsolid`: it was cut short; copy or export it again"
        )
    note = f"{file.name} has no line `endsolid`; its {ended} triangles are whole."
    return io.BytesIO(data.rstrip() + b"\nendsolid\n"), (note,)


def _read_vtk(file: Path) -> "DataSet":
    """Read a VTK file; what VTK prints about a bad one besides its exception is left out."""
    import pyvista as pv

    vtk = pv.PolyData()  # any object of VTK switches the messages of all
    shown = vtk.GetGlobalWarningDisplay()
    vtk.SetGlobalWarningDisplay(0)
    try:
        with pv.vtk_verbosity("off"):
            return pv.read(file)
    finally:
        vtk.SetGlobalWarningDisplay(shown)

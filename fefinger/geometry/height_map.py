"""Triangles of a surface from a file, and its heights over a plane: a relief."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fefinger.geometry.finger_mesh import barycentric
from fefinger.support.arrays import Array
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


MARGIN = 1e-9
"""Barycentric coordinate by which a place may lie outside a triangle, for those on its edge."""


MOST = 1_000_000
"""Largest number of heights: on all of the pad, a tenth of the edges of a mesh apart."""


def height_map(file: Path, pitch: float) -> tuple[Array, Array, Array]:
    """Return x (n_x,), y (n_y,) and the largest z (n_x, n_y) in mm of a surface file.

    The places are `pitch` mm apart and cover the surface from its smallest x and y on.

    Raises InputError if the file cannot be read, or its surface has a hole as seen along z.
    """
    import trimesh

    try:
        with np.errstate(over="ignore", invalid="ignore"):
            mesh = trimesh.load_mesh(file)
        corners = np.asarray(mesh.vertices, dtype=np.float64)[mesh.faces]
    except Exception as error:  # the readers raise whatever they meet
        raise InputError(f"indenter.file: cannot read the surface {str(file)!r}: {error}") from None
    if len(corners) == 0:
        raise InputError(f"indenter.file: expected triangles in {str(file)!r}, received none")
    if not (np.abs(corners) < FARTHEST).all():
        raise InputError(
            f"indenter.file: expected finite coordinates, below {FARTHEST:g} mm, in {str(file)!r}"
        )
    low, high = corners[..., :2].min(axis=(0, 1)), corners[..., :2].max(axis=(0, 1))
    counts = np.floor((high - low) / pitch * (1 + MARGIN)).astype(int) + 1
    if counts.prod(dtype=float) > MOST:
        raise InputError(
            f"indenter.pitch: expected at most {MOST} samples of {str(file)!r}, received "
            f"{counts[0]} x {counts[1]}; take a larger one"
        )
    x, y = (low[k] + pitch * np.arange(counts[k]) for k in (0, 1))
    heights = np.full(counts, -np.inf)
    _raise(heights, corners, low, pitch)
    if not np.isfinite(heights).all():
        share = float(np.isinf(heights).mean())
        raise InputError(
            f"indenter.file: expected a surface in {str(file)!r} that covers its box of "
            f"{' x '.join(f'{size:.3g}' for size in high - low)} mm as seen along z, received one "
            f"that leaves {100 * share:.0f} % of it open; cut it to a rectangle or put it on a "
            "plate, and check that it is in mm"
        )
    return x, y, heights


def _raise(heights: Array, triangles: Array, low: Array, pitch: float) -> None:
    """Raise the heights (n_x, n_y) to triangles (n, 3, 3); vertical ones have no places under them.

    low: x and y of the first place.
    """
    across = triangles[:, 1:, :2] - triangles[:, :1, :2]
    flat = np.square(across).max(axis=(1, 2), initial=0.0)
    triangles = triangles[np.abs(np.linalg.det(across)) > MARGIN * flat]
    ends = (triangles[..., :2].min(axis=1), triangles[..., :2].max(axis=1))
    first, last = ((end - low) / pitch for end in ends)
    # Part of a spacing, or of a triangle, by which a place may lie beyond a triangle that it is on.
    slack = 1e-6
    begin = np.maximum(np.ceil(first - slack).astype(int), 0)
    counts = np.minimum(np.floor(last + slack).astype(int) + 1, heights.shape) - begin
    counts = np.maximum(counts, 0)
    total = np.cumsum(counts.prod(axis=1))
    together = 500_000  # places in the boxes of triangles that are looked at together
    parts = np.searchsorted(total, np.arange(together, total[-1] if len(total) else 0, together))
    for part in np.split(np.arange(len(triangles)), np.unique(parts)):
        # Every place in the box of a triangle, one after another.
        sizes = counts[part].prod(axis=1)
        which = np.repeat(part, sizes)
        number = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        places = begin[which] + np.column_stack(np.divmod(number, counts[which, 1]))
        weights = barycentric(triangles[which, :, :2], low + pitch * places)
        inside = weights.min(axis=-1) >= -slack
        level = np.sum(weights * triangles[which, :, 2], axis=-1)[inside]
        np.maximum.at(heights, tuple(places[inside].T), level)

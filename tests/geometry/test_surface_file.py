"""Surface files of a finger: every format, repaired where that is safe, refused with what to do."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.geometry.surface_file import crossings, read_surface
from fefinger.mesh import shell as surface
from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe
from fefinger.support.checks import InputError


trimesh = pytest.importorskip("trimesh")


def egg(subdivisions: int = 3, **half_axes: float) -> Any:
    """Return a closed surface the size of a fingertip, tip ahead."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    size = {"x": 11.0, "y": 7.0, "z": 5.0} | half_axes
    mesh.vertices *= [size["x"], size["y"], size["z"]]
    mesh.vertices += [90.0, 3.0, -4.0]
    return mesh


def behind(mesh: Any) -> Any:
    """Return the surface without its proximal end, as a scanner leaves it."""
    mesh.update_faces(mesh.triangles_center[:, 0] > mesh.bounds[0, 0] + 2.0)
    mesh.remove_unreferenced_vertices()
    return mesh


def written(mesh: Any, path: Path) -> Path:
    if path.suffix in (".vtk", ".vtp"):
        pv = pytest.importorskip("pyvista")
        pv.PolyData.from_regular_faces(mesh.vertices, mesh.faces).save(path)
    else:
        mesh.export(path)
    return path


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".vtk", ".vtp"])
def test_every_format_gives_the_same_surface(tmp_path: Path, suffix: str) -> None:
    found = read_surface(written(egg(), tmp_path / f"scan{suffix}"))
    assert found.mesh.is_watertight
    assert found.mesh.volume == pytest.approx(egg().volume, rel=1e-5)
    assert (found.width, found.thickness) == pytest.approx((14.0, 10.0), rel=1e-3)
    assert "taken as mm with x distal, y radial and z dorsal" in found.notes[0]
    assert "is not checked: look at it with `fefinger mesh --picture`" in found.notes[0]
    assert len(found.notes) == 1


def test_an_open_proximal_end_is_closed_and_said(tmp_path: Path) -> None:
    found = read_surface(written(behind(egg()), tmp_path / "scan.stl"))
    assert found.mesh.is_watertight
    assert "edges near (81" in found.notes[1]


def doubled(mesh: Any) -> Any:
    faces = np.vstack([mesh.faces, mesh.faces[:7], [[0, 1, 1]]])
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def turned(mesh: Any) -> Any:
    mesh.faces[::2] = mesh.faces[::2, ::-1]
    return mesh


def holed(mesh: Any) -> Any:
    mesh.update_faces(np.arange(len(mesh.faces)) != 100)
    return mesh


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (doubled, "8 flat or double triangles"),
        (turned, "that faced inward were turned"),
        (holed, "A hole of 3 edges"),
    ],
)
def test_what_can_be_repaired_is_repaired_and_said(
    tmp_path: Path, fault: Callable[[Any], Any], said: str
) -> None:
    found = read_surface(written(fault(egg()), tmp_path / "scan.ply"))
    assert found.mesh.is_watertight
    assert found.mesh.volume == pytest.approx(egg().volume, rel=0.01)
    assert said in found.notes[1]


def test_skin_over_a_hole_is_curved_as_around_it(tmp_path: Path) -> None:
    """A flat lid of a hole in the pad took 7 % more force under a plate, with an edge around it."""
    whole = egg(5)
    pad = whole.vertices[np.argmin(whole.vertices[:, 2])]
    torn, away = whole.copy(), np.linalg.norm(whole.triangles_center - pad, axis=1)
    torn.update_faces(away > 1.2)
    torn.remove_unreferenced_vertices()
    x, y, z = (read_surface(written(torn, tmp_path / "scan.ply")).mesh.vertices - pad).T
    lid = np.hypot(x, y) < 1.0
    below = 5.0 * (1.0 - np.sqrt(1.0 - (x[lid] / 11.0) ** 2 - (y[lid] / 7.0) ** 2))
    pad_side = z[lid] < 1.0
    off = np.abs(z[lid] - below)[pad_side]
    under_the_rim = torn.vertices[:, 2].min() - pad[2]
    assert off.size > 9
    assert off.max() < 0.2 * under_the_rim


def cut_open(mesh: Any) -> Any:
    mesh.update_faces(mesh.triangles_center[:, 2] < mesh.bounds[1, 2] - 1.0)
    return mesh


def without_tip(mesh: Any) -> Any:
    mesh.update_faces(mesh.triangles_center[:, 0] < mesh.bounds[1, 0] - 0.6)
    return mesh


def two(mesh: Any) -> Any:
    other = egg()
    other.apply_translation([0.0, 30.0, 0.0])
    return trimesh.util.concatenate([mesh, other])


def pinched(mesh: Any) -> Any:
    low = mesh.vertices[:, 2] < mesh.vertices[:, 2].min() + 0.5
    mesh.vertices[low, 2] += 12.0
    return mesh


def moved(scale: float = 1.0, turn: tuple[int, ...] = (0, 1, 2)) -> Callable[[Any], Any]:
    def change(mesh: Any) -> Any:
        mesh.vertices = scale * mesh.vertices[:, list(turn)]
        return mesh

    return change


REFUSED = [
    (cut_open, r"has a hole 1\d\.?\d* mm wide near \(90"),
    (without_tip, r"has a hole \d\.\d* mm wide near \(100.*close it in the program that made it$"),
    (two, "has 2 separate ones"),
    (pinched, "crosses itself near"),
    (moved(1e-3), "seems to be in m: scale it by 1000"),
    (moved(0.1), "seems to be in cm: scale it by 10"),
    (moved(1e-6), "expected a fingertip in mm, 6 to 40 mm wide"),
    (moved(turn=(1, 0, 2)), "longest along y; expected x distal.*turn it about z by 90 or -90"),
    (moved(turn=(2, 1, 0)), "longest along z; expected x distal.*turn it about y by 90 or -90"),
    (moved(turn=(0, 2, 1)), "thicker along z than .* turn it about x by 90 or -90"),
]


@pytest.mark.parametrize(("fault", "message"), REFUSED)
def test_what_is_no_finger_is_refused_with_what_to_do(
    tmp_path: Path, fault: Callable[[Any], Any], message: str
) -> None:
    path = written(fault(egg()), tmp_path / "scan.ply")
    with pytest.raises(InputError, match=message):
        read_surface(path)


@pytest.mark.parametrize("angle", [20, -25])
def test_a_tilted_finger_is_told_with_its_tilt(tmp_path: Path, angle: int) -> None:
    mesh = egg(x=13.0, z=7.0)
    about_y = trimesh.transformations.rotation_matrix(np.radians(angle), [0, 1, 0])
    mesh.apply_transform(about_y)
    expected = rf"tilted about y by about {angle} degrees, .* turn it about y by about {-angle} deg"
    with pytest.raises(InputError, match=expected):
        read_surface(written(mesh, tmp_path / "scan.ply"))
    on_its_side = fingertip(14, 10, 14, 2.0).copy()
    on_its_side.vertices = on_its_side.vertices[:, [0, 2, 1]] * [1, -1, 1]
    with pytest.raises(InputError, match=r"thicker along z .* turn it about x by 90 or -90"):
        read_surface(written(on_its_side, tmp_path / "side.ply"))


@pytest.mark.parametrize("size", [(25, 15, 12), (60, 15, 12), (15, 15, 15)])
@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_a_box_is_refused_by_its_flat_sides(
    tmp_path: Path, size: tuple[float, float, float], noise: float
) -> None:
    """It would keep the mesher busy without end."""
    mesh = trimesh.creation.box(size).subdivide().subdivide().subdivide()
    mesh.vertices += noise * np.random.default_rng(0).normal(size=mesh.vertices.shape)
    with pytest.raises(InputError, match=r"has a flat side, as a box: 2\d% of it face \("):
        read_surface(written(mesh, tmp_path / "box.ply"))


@pytest.mark.parametrize("count", [12, 48])
def test_a_capsule_has_no_flat_side_however_coarse(tmp_path: Path, count: int) -> None:
    mesh = trimesh.creation.capsule(height=12, radius=7, count=[count, count])
    mesh.vertices = mesh.vertices[:, [2, 1, 0]] * [1, 1, -0.8]
    read_surface(written(mesh, tmp_path / "scan.ply"))
    read_surface(written(behind(mesh), tmp_path / "open.ply"))


@cache
def fingertip(width: float, thickness: float, pad_radius: float, widths: float) -> Any:
    """Return the skin of a parametric finger, open where it was cut so many widths from its tip."""
    skin = parametric(Recipe(width, thickness, pad_radius)).skin
    points, faces = surface.without_caps(surface.half(skin, 0.6))
    both = np.concatenate([faces, faces[:, ::-1] + len(points)])
    mesh = trimesh.Trimesh(np.concatenate([points, points * [1, -1, 1]]), both)
    mesh.merge_vertices()
    mesh.update_faces(mesh.triangles_center[:, 0] > mesh.bounds[1, 0] - widths * width)
    mesh.remove_unreferenced_vertices()
    return mesh


@pytest.mark.parametrize("widths", [1.1, 2.0])
@pytest.mark.parametrize("size", [(12, 9.5, 15), (14, 11.5, 12), (17, 13, 17)])
def test_the_tip_is_seen_at_the_narrower_end(
    tmp_path: Path, size: tuple[float, float, float], widths: float
) -> None:
    mesh = fingertip(*size, widths)
    found = read_surface(written(mesh, tmp_path / "scan.ply"))
    closed = found.mesh
    assert closed.is_watertight
    assert found.width == pytest.approx(size[0], rel=0.06)
    closed.vertices *= [-1, -1, 1]
    with pytest.raises(InputError, match=r"tip, at the smaller x; .* turn it about z by 180"):
        read_surface(written(closed, tmp_path / "back.ply"))


def test_a_turned_finger_that_is_open_behind_is_called_open_first(tmp_path: Path) -> None:
    mesh = fingertip(14, 10, 14, 2.0).copy()
    mesh.vertices *= [-1, -1, 1]
    with pytest.raises(InputError, match=r"has a hole 1\d\.?\d* mm wide .* or if it is the proxi"):
        read_surface(written(mesh, tmp_path / "scan.ply"))


def test_a_good_finger_with_its_triangles_inside_out_is_taken(tmp_path: Path) -> None:
    mesh = fingertip(14, 10, 14, 2.0).copy()
    mesh.faces = mesh.faces[:, ::-1]
    assert read_surface(written(mesh, tmp_path / "scan.ply")).mesh.volume > 0


def opened(mesh: Any) -> Any:
    away = np.linalg.norm(
        mesh.triangles_center - mesh.vertices[np.argmin(mesh.vertices[:, 2])], axis=1
    )
    mesh.update_faces(away > 3.0)
    return mesh


def inside_out(mesh: Any) -> Any:
    mesh.faces = mesh.faces[:, ::-1]
    return mesh


TURNED, METERS = moved(turn=(1, 0, 2)), moved(1e-3)


@pytest.mark.parametrize(
    ("faults", "message"),
    [
        ((opened, inside_out, METERS, TURNED), "has a hole"),
        ((opened, pinched), "has a hole"),
        ((pinched, inside_out, METERS, TURNED), "crosses itself"),
        ((inside_out, METERS, TURNED), "seems to be in m"),
        ((inside_out, TURNED), "longest along y"),
    ],
)
def test_of_several_faults_the_one_that_matters_is_told_first(
    tmp_path: Path, faults: tuple[Callable[[Any], Any], ...], message: str
) -> None:
    """Open, then crossing itself, then the unit, then the frame; inside out is repaired."""
    mesh = egg()
    for fault in faults:
        mesh = fault(mesh)
    with pytest.raises(InputError, match=message):
        read_surface(written(mesh, tmp_path / "scan.ply"))


@pytest.mark.parametrize(
    ("turn", "back"),
    [((-1, 0), "z by 180"), ((0, 1), "z by -90"), ((0, -1), "z by 90")],
)
def test_an_open_end_that_lies_elsewhere_is_told_with_its_turn(
    tmp_path: Path, turn: tuple[int, int], back: str
) -> None:
    """The x axis of the finger is turned to `turn` in the plane of x and y."""
    mesh = fingertip(14, 10, 14, 2.0).copy()
    c, s = turn
    mesh.vertices = mesh.vertices @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]], dtype=float)
    with pytest.raises(InputError, match=f"if it is the proximal end, .* about {back} degrees"):
        read_surface(written(mesh, tmp_path / "scan.ply"))


def test_a_flat_surface_is_called_open(tmp_path: Path) -> None:
    """It has no thickness, which its place in the box is divided by."""
    corners = np.array([[0, 0, 0], [15, 0, 0], [15, 15, 0], [0, 15, 0]], dtype=float)
    plane = trimesh.Trimesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    with pytest.raises(InputError, match="expected a closed surface"):
        read_surface(written(plane, tmp_path / "scan.ply"))


@pytest.mark.parametrize("text", ["", "hello", "solid x\nendsolid x\n"])
def test_an_empty_file_or_text_is_refused_and_nothing_printed(
    tmp_path: Path, text: str, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("scan.stl", "scan.obj", "scan.ply", "scan.vtk"):
        (tmp_path / name).write_text(text)
        with pytest.raises(
            InputError, match=r"scan\.\w+('?, which cannot be read| has no triangles)"
        ):
            read_surface(tmp_path / name)
    assert capfd.readouterr() == ("", "")


def test_a_vtk_file_without_a_surface_is_refused(tmp_path: Path) -> None:
    pv = pytest.importorskip("pyvista")
    pv.PolyData(np.zeros((3, 3))).save(tmp_path / "points.vtk")
    with pytest.raises(InputError, match="has no triangles"):
        read_surface(tmp_path / "points.vtk")


def test_a_simple_surface_does_not_cross_itself_and_a_folded_one_does() -> None:
    assert crossings(egg()) is None
    found = crossings(pinched(egg()))
    assert found is not None
    assert found[2] > 0


def test_a_finger_takes_its_size_from_its_surface(tmp_path: Path) -> None:
    path = written(egg(), tmp_path / "scan.stl")
    finger = ff.Finger.from_surface(path, pad_radius=12.0)
    assert (finger.width, finger.thickness) == pytest.approx((14.0, 10.0), rel=1e-3)
    assert finger.surface == str(path)
    given = '[finger]\nsurface = "scan.stl"\npad_radius = 12.0\n'
    motion = '[motion]\nkind = "ramp"\nspeed = 10\ndepth = 1\n'
    (tmp_path / "mine.toml").write_text(given + motion)
    scene = ff.Scene.from_toml(tmp_path / "mine.toml")
    assert scene.finger == finger
    assert ff.Scene.from_toml(scene.to_toml()) == scene  # exact: TOML keeps every digit


def test_missing_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"finger\.surface: .*'none\.stl', which does not exist"):
        ff.Finger.from_surface("none.stl", tissue="maeno1998")
    path = written(egg(), tmp_path / "scan.stl")
    with pytest.raises(InputError, match=r"finger\.bone_surface: .*'none\.stl', which does not"):
        ff.Finger.from_surface(path, bone_surface="none.stl", tissue="maeno1998")
    with pytest.raises(InputError, match=r"expected finger\.surface beside it"):
        ff.Finger(14, 10, bone_surface=str(path), tissue="maeno1998")
    both = {"surface": str(path), "bone_surface": str(path), "tip_tissue": 4.0}
    with refused("finger.tip_tissue"):
        ff.Finger(14, 10, tissue="maeno1998", **both)
    with refused("finger.tip_radius"):
        ff.Finger(14, 10, tissue="maeno1998", surface=str(path), tip_radius=2.0)
    scan = ff.Finger(14, 10, tissue="calibrated_ah", surface=str(path))
    assert (scan.tip_tissue, scan.tip_radius) == (6.2, None)

"""Surface files of a finger: every format, repaired where that is safe, refused with what to do."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from refusals import refused

import fefinger as ff
from fefinger.geometry import scan_axes, scan_fit
from fefinger.geometry.scan_axes import fingertip_axes
from fefinger.geometry.surface_file import SurfaceFile, read_surface
from fefinger.geometry.surface_repair import close, crossings, read_welded
from fefinger.mesh import mesh_record
from fefinger.mesh import shell as surface
from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe, data_folder
from fefinger.support.checks import InputError


trimesh = pytest.importorskip("trimesh")


@pytest.fixture(scope="module", autouse=True)
def _few_harmonics() -> Iterator[None]:
    """Smooth by few harmonics: how well they do it is asked in test_scan_fit.py."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(scan_fit, "DEGREE", 10)
        yield


@pytest.fixture
def straight(monkeypatch: pytest.MonkeyPatch) -> None:
    """Seek the axes of a scan from those of its file alone, where it lies along them."""
    monkeypatch.setattr(scan_axes, "_directions", lambda _: [np.eye(3)])


@cache
def fingertip(width: float, thickness: float, pad_radius: float, widths: float) -> Any:
    """Return the skin of a parametric finger, open where it was cut so many widths from its tip."""
    skin = parametric(Recipe(width, thickness, pad_radius)).skin
    points, faces = surface.without_caps(surface.half(skin, 0.9))
    both = np.concatenate([faces, faces[:, ::-1] + len(points)])
    mesh = trimesh.Trimesh(np.concatenate([points, points * [1, -1, 1]]), both)
    mesh.merge_vertices()
    mesh.update_faces(mesh.triangles_center[:, 0] > mesh.bounds[1, 0] - widths * width)
    mesh.remove_unreferenced_vertices()
    return mesh


def egg() -> Any:
    """Return the skin of a finger of 14 x 10 mm, tip ahead, open behind."""
    mesh = fingertip(14, 10, 14, 1.7).copy()
    mesh.vertices += [90.0, 3.0, -4.0]
    return mesh


def written(mesh: Any, path: Path) -> Path:
    if path.suffix in (".vtk", ".vtp"):
        pv = pytest.importorskip("pyvista")
        pv.PolyData.from_regular_faces(mesh.vertices, mesh.faces).save(path)
    else:
        mesh.export(path)
    return path


def doubled(mesh: Any) -> Any:
    faces = np.vstack([mesh.faces, mesh.faces[:7], [[0, 1, 1]]])
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def turned(mesh: Any) -> Any:
    mesh.faces[::2] = mesh.faces[::2, ::-1]
    return mesh


def holed(mesh: Any) -> Any:
    mesh.update_faces(np.arange(len(mesh.faces)) != 100)
    return mesh


@pytest.mark.usefixtures("straight")
@pytest.mark.parametrize(
    ("fault", "said"),
    [(doubled, "8 flat or double triangles"), (turned, "that faced inward"), (holed, "hole of 3")],
)
def test_what_can_be_repaired_is_repaired_and_said(
    tmp_path: Path, fault: Callable[[Any], Any], said: str
) -> None:
    found = read_surface(written(fault(egg()), tmp_path / "scan.ply"))
    assert found.mesh.is_watertight
    assert any(said in note for note in found.notes[1:])


@pytest.mark.usefixtures("straight")
def test_an_inward_scan_is_turned_outward_whatever_its_last_digits_are(tmp_path: Path) -> None:
    """VTK judges by one triangle of the flat end, which in 6 of 30 such scans rounding made it."""
    pv = pytest.importorskip("pyvista")
    mesh = mesh_record.read(data_folder() / "ah-coarse.vtu")
    half = pv.UnstructuredGrid({pv.CellType.TETRA: mesh.cells}, mesh.points)
    whole = half.merge(half.reflect((0, 1, 0)), merge_points=True)
    skin = whole.extract_surface(algorithm=None).triangulate().clean()
    skin.points[:, 1] *= 1.06
    skin.save(tmp_path / "scan.stl")
    scan, _ = read_welded(tmp_path / "scan.stl", "surface")
    assert scan.volume < 0
    place, rng = fingertip_axes(scan).place, np.random.default_rng(0)
    for _ in range(20):
        near = place.copy()
        near[:3] += 1e-10 * rng.normal(size=(3, 4))
        each = scan.copy()
        each.apply_transform(near)
        notes, _ = close(each, "surface: scan", behind=0.0, place=near)
        assert notes == ("Triangles that faced inward were turned outward.",)
        assert each.volume == pytest.approx(-scan.volume, rel=1e-6)
        corners = each.vertices[each.faces]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (np.einsum("ij,ij->i", each.face_normals, across) > 0.0).all()
    inward = read_surface(tmp_path / "scan.stl")
    scan.faces = scan.faces[:, ::-1].copy()
    scan.export(tmp_path / "outward.stl")
    outward = read_surface(tmp_path / "outward.stl")
    assert inward.width == pytest.approx(outward.width, rel=1e-3)
    assert inward.thickness == pytest.approx(outward.thickness, rel=1e-3)


def cut_open(mesh: Any) -> Any:
    mesh.update_faces(mesh.triangles_center[:, 2] < mesh.bounds[1, 2] - 1.0)
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


def flattened(mesh: Any) -> Any:
    mesh.vertices[:, 2] = 0.3 * mesh.vertices[:, 1]
    return mesh


REFUSED = [
    (cut_open, r"has a hole \d+\.?\d* mm wide near \("),
    (two, "has 2 separate ones"),
    (moved(1e-3), "seems to be in m: scale it by 1000"),
    (moved(0.1), "seems to be in cm: scale it by 10"),
    (moved(1.2 / 25.4), "seems to be in inches: scale it by 25.4"),  # or 6.6 mm in cm
    (flattened, "lie in one plane"),
    (moved(1e-6), "expected a fingertip in mm, 6 to 40 mm wide"),
]


@pytest.mark.usefixtures("straight")
@pytest.mark.parametrize(("fault", "message"), REFUSED)
def test_what_is_no_finger_is_refused_with_what_to_do(
    tmp_path: Path, fault: Callable[[Any], Any], message: str
) -> None:
    path = written(fault(egg()), tmp_path / "scan.ply")
    with pytest.raises(InputError, match=message):
        read_surface(path)


@pytest.fixture(scope="module")
def wanted(tmp_path_factory: pytest.TempPathFactory) -> SurfaceFile:
    """Return what is read of the finger's surface."""
    return read_surface(written(egg(), tmp_path_factory.mktemp("whole") / "whole.ply"))


@pytest.mark.usefixtures("straight")
@pytest.mark.parametrize("suffix", [".stl", ".obj", ".vtk", ".vtp"])
def test_every_format_gives_the_same_surface(
    tmp_path: Path, suffix: str, wanted: SurfaceFile
) -> None:
    found = read_surface(written(egg(), tmp_path / f"scan{suffix}"))
    assert found.mesh.is_watertight
    assert found.mesh.volume == pytest.approx(wanted.mesh.volume, rel=1e-4)
    assert (found.width, found.thickness) == pytest.approx((14.0, 10.0), rel=0.01)
    assert [note.partition(":")[2] for note in found.notes] == [
        note.partition(":")[2] for note in wanted.notes
    ]
    assert any("fefinger mesh --picture" in note for note in found.notes)
    assert not egg().is_watertight  # open at its proximal end
    assert "near (69" in found.notes[-1]
    assert found.notes[-1].endswith("mm was filled.")


@pytest.mark.usefixtures("straight")
def test_skin_over_a_hole_is_curved_as_around_it(tmp_path: Path, wanted: SurfaceFile) -> None:
    """A flat lid of a hole in the pad took 7 % more force under a plate, with an edge around it."""
    torn, middle = egg(), egg().vertices[np.argmin(egg().vertices[:, 2])]
    torn.update_faces(np.linalg.norm(torn.triangles_center - middle, axis=1) > 0.9)
    torn.remove_unreferenced_vertices()
    lid = read_surface(written(torn, tmp_path / "scan.ply")).mesh
    sag = 0.9**2 / (2 * 7.0)  # of a flat lid, at the radius across the finger
    assert lid.bounds[0, 2] == pytest.approx(wanted.mesh.bounds[0, 2], abs=0.3 * sag)


def test_a_simple_surface_does_not_cross_itself_and_a_folded_one_does() -> None:
    assert crossings(egg()) is None
    found = crossings(pinched(egg()))
    assert found is not None
    assert found[2] > 0


@pytest.mark.usefixtures("straight")
def test_a_finger_takes_its_size_from_its_surface(tmp_path: Path) -> None:
    path = written(egg(), tmp_path / "scan.stl")
    finger = ff.Finger.from_surface(path, pad_radius=12.0)
    assert (finger.width, finger.thickness) == pytest.approx((14.0, 10.0), rel=0.01)
    assert finger.surface == str(path)
    given = '[finger]\nsurface = "scan.stl"\npad_radius = 12.0\n'
    motion = '[motion]\nkind = "ramp"\nspeed = 10\ndepth = 1\n'
    (tmp_path / "mine.toml").write_text(given + motion)
    scene = ff.Scene.from_toml(tmp_path / "mine.toml")
    assert scene.finger == finger  # exact: both are of the one reading of this file
    assert ff.Scene.from_toml(scene.to_toml()) == scene  # exact: TOML keeps every digit


@pytest.mark.parametrize(
    "fault", [pinched, lambda _: trimesh.creation.icosphere(3, 7.0)], ids=["pinched", "ball"]
)
def test_what_has_no_form_of_a_fingertip_is_refused(
    tmp_path: Path, fault: Callable[[Any], Any]
) -> None:
    with pytest.raises(InputError, match="is not shaped as a fingertip"):
        read_surface(written(fault(egg()), tmp_path / "scan.ply"))


def test_a_box_is_refused(tmp_path: Path) -> None:
    """It would keep the mesher busy without end."""
    mesh = trimesh.creation.box((25, 15, 12)).subdivide().subdivide().subdivide()
    with pytest.raises(InputError, match=r"has a flat side, as a box|is not shaped as a fingertip"):
        read_surface(written(mesh, tmp_path / "box.ply"))


@pytest.mark.parametrize("turn", [(180, 0, 0), (0, 90, 0), (8, -15, 10), (0, 0, 180)])
def test_the_axes_are_found_however_a_scan_lies(tmp_path: Path, turn: tuple[float, ...]) -> None:
    """Its back is level and its sides symmetric to half a degree; the size is the finger's."""
    mesh = egg()
    turned = trimesh.transformations.euler_matrix(*np.radians(turn))
    mesh.apply_transform(turned)
    found = read_surface(written(mesh, tmp_path / "scan.ply"))
    back = found.place[:3, :3] @ turned[:3, :3]
    angle = np.degrees(np.arccos(np.clip((np.trace(back) - 1) / 2, -1, 1)))
    assert angle < 0.7
    assert (found.width, found.thickness) == pytest.approx((14.0, 10.0), rel=0.01)
    assert "It was turned by" in found.notes[0]


def test_the_axes_of_a_file_are_kept_where_asked(tmp_path: Path) -> None:
    """Tilted by 5 degrees it stays so, with a note; on its side it is refused."""
    mesh = egg()
    mesh.apply_transform(trimesh.transformations.euler_matrix(0.0, np.radians(5.0), 0.0))
    path = written(mesh, tmp_path / "scan.ply")
    finger = ff.Finger.from_surface(path, axes="file", tissue="maeno1998")
    found = read_surface(str(path), "finger.surface", axes="file")
    assert found.place[:3, :3] == pytest.approx(np.eye(3))
    assert found.mesh.bounds[1, 0] == pytest.approx(0.0, abs=0.5)  # its tip
    assert "those of the file" in found.notes[0]
    scene = ff.Scene(finger=finger, indenter=ff.Flat(30), motion=ff.Ramp(speed=1, depth=1))
    assert ff.Scene.from_toml(scene.to_toml()).finger.axes == "file"
    assert Recipe.of(finger).key() != Recipe.of(replace(finger, axes="shape")).key()
    mesh.apply_transform(trimesh.transformations.euler_matrix(np.pi / 2, 0.0, 0.0))
    with refused("finger.surface"):
        ff.Finger.from_surface(written(mesh, tmp_path / "side.ply"), axes="file")
    with refused("finger.axes"):
        ff.Finger(14, 10, axes="file")


def stl(tmp_path: Path) -> bytes:
    """Return a binary STL of the finger."""
    return written(egg(), tmp_path / "whole.stl").read_bytes()


@pytest.mark.usefixtures("straight")
@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda data: data + b"x" * 64, "64 bytes of scan.stl after its last triangle"),
        (lambda data: data[:80] + bytes(4) + data[84:], "says that it has 0 triangles"),
    ],
)
def test_an_stl_that_does_not_fit_is_read_with_a_note(
    tmp_path: Path, change: Callable[[bytes], bytes], said: str
) -> None:
    (tmp_path / "scan.stl").write_bytes(change(stl(tmp_path)))
    found = read_surface(tmp_path / "scan.stl")
    assert any(said in note for note in found.notes)


@pytest.mark.usefixtures("straight")
def test_an_stl_that_was_cut_short_is_said(tmp_path: Path) -> None:
    data = stl(tmp_path)
    (tmp_path / "half.stl").write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match=r"which hold \d+: it was cut short"):
        read_surface(tmp_path / "half.stl")
    text = trimesh.exchange.stl.export_stl_ascii(egg())
    (tmp_path / "text.stl").write_text(text[: text.rindex("endsolid")])
    assert any("no line `endsolid`" in note for note in read_surface(tmp_path / "text.stl").notes)
    (tmp_path / "text.stl").write_text(text[: text.index("endfacet", len(text) // 2)])
    with pytest.raises(InputError, match=r"as many `endfacet` as `facet normal`"):
        read_surface(tmp_path / "text.stl")


@pytest.mark.usefixtures("straight")
def test_a_good_finger_with_its_triangles_inside_out_is_taken(tmp_path: Path) -> None:
    mesh = fingertip(14, 10, 14, 2.0).copy()
    mesh.faces = mesh.faces[:, ::-1]
    assert read_surface(written(mesh, tmp_path / "scan.ply")).mesh.volume > 0


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


@pytest.mark.usefixtures("straight")
def test_missing_files_are_named(tmp_path: Path) -> None:
    with refused("finger.surface"):
        ff.Finger.from_surface("none.stl", tissue="maeno1998")
    path = written(egg(), tmp_path / "scan.stl")
    with refused("finger.bone_surface"):
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


@pytest.mark.parametrize("size", [(24.0, 14.0, 11.0), (24.0, 14.0, 12.0), (14.0, 11.0, 24.0)])
def test_a_surface_without_cut_or_nail_is_wider_than_thick(size: tuple[float, ...]) -> None:
    """Rolled by 90 degrees and tilted by 8, an ellipsoid was as near to a fingertip."""
    mesh = trimesh.creation.icosphere(4)
    mesh.vertices *= np.array(size) / 2.0
    tip, side, nail = np.abs(fingertip_axes(mesh).place[:3, :3])
    long, wide, thick = np.argsort(size)[::-1]
    assert tip[long] > 0.99
    assert side[wide] > 0.99
    assert nail[thick] > 0.99

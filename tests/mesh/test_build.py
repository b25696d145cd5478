"""The builder from end to end on a very coarse finger, and the gate that judges it."""

import signal
from dataclasses import replace

import numpy as np
import pytest
from oracles.solids import assert_closed
from refusals import refused

from fefinger.geometry.finger_mesh import FACETS, FingerMesh, volumes
from fefinger.mesh import smooth, tetrahedralize
from fefinger.mesh.build import SETTINGS, build, promising, sizes
from fefinger.mesh.finger_shape import touch_point, touch_within
from fefinger.mesh.mesh_record import dihedral_angles, gate, measure, scan_notes
from fefinger.mesh.morph import Draft
from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe
from fefinger.mesh.tetrahedralize import MesherSettings, tetrahedra
from fefinger.support.checks import ConvergenceError


ROUGH = MesherSettings(pad=1.0, deep=0.8, far=1.0, largest=4.0, envelope=6e-3, facet=1.2)


@pytest.fixture(scope="module")
def rough() -> FingerMesh:
    """Return a real mesh of about two thousand cells."""
    return build(Recipe(13, 10, 13, resolution="coarse"), settings=ROUGH, name="rough")


def test_rough_finger_passes_the_gate(rough: FingerMesh) -> None:
    gate(rough.quality)
    assert rough.half
    assert rough.quality["n_cells"] == len(rough.cells) > 500
    assert volumes(rough.points, rough.cells).min() > 0
    assert all(len(rough.facets[name]) for name in FACETS)


def test_rough_finger_is_conforming(rough: FingerMesh) -> None:
    assert_closed(rough, "bone")


def test_a_mesher_that_fails_is_an_error_and_not_the_end(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """In this process it would end us, print, and put the handler of SIGINT back."""

    def stop(signum, frame):
        raise KeyboardInterrupt

    handler = signal.signal(signal.SIGINT, stop)
    try:
        with pytest.raises(ConvergenceError, match="mesher: it ended with status"):
            tetrahedra([(np.eye(3), np.empty((0, 3), int))], lambda p: np.ones(len(p)), ROUGH)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, handler)
    assert capfd.readouterr() == ("", "")


def test_a_mesher_without_an_end_is_ended_and_not_called_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tetrahedralize, "LIMIT", 0.0)
    with pytest.raises(ConvergenceError, match="not done after 0 s in 1 attempt; use another"):
        build(Recipe(13, 10, 13, resolution="coarse"), settings=ROUGH)


def test_morphs_with_many_poor_cells_are_not_tried(rough: FingerMesh) -> None:
    """Of a scan with a needle for a tip, eight morphs took 63 s before the mesher was called."""
    count, no_supports = len(rough.cells), smooth.Supports(np.empty(0), np.empty(0), ())
    source = parametric(Recipe(13, 10, 13))
    shares = (0.01, 0.35, 0.15, 0.19, 0.18, 0.05)
    drafts = [
        Draft(rough, source, rough.points, no_supports, int(share * count), stretch)
        for stretch, share in enumerate(shares)
    ]
    scan = [made.stretch for made in promising(drafts, scanned=True)]
    assert scan == [0, 2, 3]  # up to half of the cells of a mesh in all
    assert [made.stretch for made in promising(drafts, scanned=False)] == [0, 5, 2]


def test_a_pad_that_is_hollow_where_it_should_be_round_is_said(rough: FingerMesh) -> None:
    """The fourth root of a negative product is complex, which no text formats."""
    notes = [
        *scan_notes(rough.quality | {"radii_errors": [-1.3, 0.1]}),
        *scan_notes(rough.quality | {"radii_errors": [-0.3, 0.1]}),
    ]
    assert "hollow" in notes[0]
    assert "light touch is -6.3% off" in notes[1]


def faulty(mesh: FingerMesh, fault: str) -> FingerMesh:
    """Return the mesh with one thing wrong."""
    points = mesh.points.copy()
    if fault == "inverted":
        return replace(mesh, cells=mesh.cells[:, [1, 0, 2, 3]])
    if fault == "flat":
        cell = mesh.cells[np.argmin(np.linalg.norm(points[mesh.cells].mean(1) + 8, axis=1))]
        points[cell[0]] = points[cell[1:]].mean(axis=0) * 0.999 + points[cell[0]] * 0.001
    if fault == "bone lost":
        return replace(mesh, region=np.where(mesh.region == 3, 2, mesh.region).astype(np.int8))
    if fault == "stray":
        region = mesh.region.copy()
        region[np.argmin(points[mesh.cells].mean(axis=1)[:, 2])] = 2
        return replace(mesh, region=region)
    if fault == "stretched":
        points *= [1.0, 1.1, 1.0]
    return replace(mesh, points=points)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("inverted", "inverted or flat"),
        ("flat", "dihedral angle of .* wanted 8 or more"),
        ("bone lost", "bone volume -100.0% off"),
        ("stray", "subcutaneous in 2 parts, wanted one"),
        ("stretched", "pad radius across the finger"),
    ],
)
def test_gate_refuses_a_bad_mesh(rough: FingerMesh, fault: str, message: str) -> None:
    quality = measure(
        faulty(rough, fault),
        radii=tuple(rough.quality["radii_wanted"]),
        surface_volumes=rough.quality["surface_volumes"],
        gap=0.0,
    )
    with pytest.raises(ConvergenceError, match=message):
        gate(quality)


def test_dihedral_angles_of_the_regular_and_the_corner_tetrahedron() -> None:
    regular = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    cell = np.array([[0, 1, 2, 3]])
    assert dihedral_angles(regular, cell) == pytest.approx(np.degrees(np.arccos(1 / 3)))
    expected = sorted([90] * 3 + [np.degrees(np.arccos(1 / np.sqrt(3)))] * 3)
    assert np.sort(dihedral_angles(corner, cell)[0]) == pytest.approx(expected)


def test_sines_are_those_of_the_angles_and_change_sign_with_orientation() -> None:
    points = np.random.default_rng(0).normal(size=(40, 4, 3))
    cells = np.arange(160).reshape(40, 4)
    angles = np.sort(np.sin(np.radians(dihedral_angles(points.reshape(-1, 3), cells))), axis=1)
    sines = smooth.sines(points)
    assert np.sort(np.abs(sines), axis=1) == pytest.approx(angles, abs=1e-7)
    assert smooth.sines(points[:, [1, 0, 2, 3]]).sum() == pytest.approx(-sines.sum())
    signs = np.sign(volumes(points.reshape(-1, 3), cells))
    assert np.all(np.sign(sines) == signs[:, None])


def test_improving_lifts_the_worst_angle_and_leaves_planes_alone() -> None:
    # A vertex of a divided cube pushed almost onto a face comes back to the middle.
    grid = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    points = np.concatenate([grid, [[0.5, 0.02, 0.5]]])
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    cells = np.array([[a, b, c, 8] for q in squares for a, b, c in (q[:3], (q[0], *q[2:]))])
    turned = volumes(points, cells) < 0
    cells[turned] = cells[turned][:, [1, 0, 2, 3]]
    supports = smooth.Supports(np.full(9, -1), np.ones((9, 3), dtype=bool), ())
    better = smooth.improve(points, cells, supports, wanted=0.7, pinned=np.arange(8), sweeps=12)
    assert np.array_equal(better[:8], points[:8])
    assert smooth.sines(better[cells]).min() > 10 * smooth.sines(points[cells]).min()


def test_the_facets_are_fine_where_the_indenter_touches() -> None:
    shape = parametric(Recipe(14, 10, 14))
    settings = SETTINGS["coarse"]
    standard, below = touch_point(shape, 30.0), touch_point(shape, 0.0)
    assert standard == pytest.approx(np.zeros(3), abs=0.05)
    assert shape.skin.level(below[None]) == pytest.approx(0.0, abs=1e-6)
    assert below[2] == pytest.approx(-2.7, abs=0.5)
    assert below[0] < -5
    plain = sizes(shape, settings)(np.array([standard, below]))
    moved = sizes(shape, settings, 0.0)(np.array([standard, below]))
    assert moved[0] == pytest.approx(settings.pad)  # the reference press stays resolved
    assert moved[1] == pytest.approx(settings.pad)
    assert plain[1] > 1.5 * settings.pad
    aside = touch_point(shape, (-2.0, -4.0))
    assert aside[:2] == pytest.approx([-2.0, 4.0])
    with refused("indenter.at"):
        touch_point(shape, (30.0, 0.0))


def test_a_rounded_place_beside_the_pad_stands_for_the_nearest_one_on_it() -> None:
    shape, settings = parametric(Recipe(14, 10, 14)), SETTINGS["coarse"]
    on_pad = touch_point(shape, (0.0, 5.3))
    with refused("indenter.at"):
        touch_point(shape, (0.0, 6.0))
    assert sizes(shape, settings, (0.0, 6.0))(on_pad[None]) == pytest.approx(settings.pad)
    ahead = touch_within(shape, (30.0, 0.0), np.inf)
    assert sizes(shape, settings, (30.0, 0.0))(ahead[None]) == pytest.approx(settings.pad)
    with refused("indenter.at"):
        touch_within(shape, (30.0, 0.0), 5.0)


def test_a_recipe_without_a_touch_is_that_of_the_shipped_meshes() -> None:
    plain = Recipe(14, 10, 14)
    assert "touch" not in plain.to_dict()
    assert Recipe(14, 10, 14, touch=0.0).to_dict()["touch"] == 0.0
    assert Recipe(14, 10, 14, touch=(2.0, 0.0)).to_dict()["touch"] == [2.0, 0.0]
    assert Recipe(14, 10, 14, touch=0.0).key() != plain.key()
    assert Recipe(14, 10, 14, tip_radius=2.5).key() != plain.key()

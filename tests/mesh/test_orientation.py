"""A scan that is turned out of its frame is refused with what turns it back, a good one is not."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from fefinger.geometry.scan_orientation import SLENDER, UNSURE, check, lie
from fefinger.mesh import shell_triangles
from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe
from fefinger.support.checks import InputError


trimesh = pytest.importorskip("trimesh")

SUBJECTS = {  # width, thickness and pad radius in mm
    "d.p.": (12, 9.5, 15),
    "d.s.": (14, 11.5, 12),
    "a.h.": (14, 10, 14),
    "p.w.": (17, 13, 17),
}


@cache
def finger(name: str, widths: float = 2.0, askew: float = 0.0) -> Any:
    """Return a closed finger, cut so many widths from its tip and askew by degrees about y."""
    width, thickness, radius = SUBJECTS[name]
    points, faces = shell_triangles.half(parametric(Recipe(width, thickness, radius)).skin, 0.6)
    faces = faces[~np.all(points[faces][:, :, 1] == 0.0, axis=1)]
    both = np.concatenate([faces, faces[:, ::-1] + len(points)])
    whole = trimesh.Trimesh(np.concatenate([points, points * [1, -1, 1]]), both)
    whole.merge_vertices()
    normal = np.array([np.cos(np.radians(askew)), 0.0, np.sin(np.radians(askew))])
    at = whole.bounds.mean(axis=0)
    at[0] = whole.bounds[1, 0] - min(widths * width, np.ptp(whole.bounds[:, 0]) - 0.5)
    points, faces, *_ = trimesh.intersections.slice_faces_plane(
        whole.vertices, whole.faces, normal, at
    )
    mesh = trimesh.Trimesh(points, faces)
    mesh.merge_vertices()
    edges, count = np.unique(mesh.edges_sorted, axis=0, return_counts=True)
    rim = edges[count == 1]
    fan = np.column_stack([rim, np.full(len(rim), len(mesh.vertices))])
    middle = mesh.vertices[np.unique(rim)].mean(axis=0)
    return trimesh.Trimesh(np.vstack([mesh.vertices, middle]), np.vstack([mesh.faces, fan]))


def turned(mesh: Any, axis: str, degrees: float) -> Any:
    mesh = mesh.copy()
    mesh.vertices = Rotation.from_euler(axis, degrees, degrees=True).apply(mesh.vertices)
    return mesh


@pytest.mark.parametrize(
    ("name", "widths", "askew", "noise"),
    [("d.p.", 1.5, -20.0, 0.0), ("a.h.", 2.0, 0.0, 0.1), ("p.w.", 1.5, 20.0, 0.1)],
)
def test_a_good_scan_gets_no_word(name: str, widths: float, askew: float, noise: float) -> None:
    mesh = finger(name, widths, askew).copy()
    mesh.vertices += np.random.default_rng(7).normal(scale=noise, size=mesh.vertices.shape)
    assert check(mesh, "surface") == ()
    assert lie(mesh).rise > UNSURE
    assert lie(mesh).slender > SLENDER


@pytest.mark.parametrize("askew", [-20.0, 20.0])
def test_a_short_piece_is_not_taken_for_a_turned_one(askew: float) -> None:
    assert check(finger("d.s.", 1.1, askew), "surface") == ()


@pytest.mark.parametrize(
    ("axis", "degrees"), [("x", -45), ("x", 180), ("y", 30), ("y", 120), ("z", -90), ("z", 45)]
)
def test_a_turned_scan_is_refused_with_what_turns_it_back(axis: str, degrees: float) -> None:
    mesh = turned(finger("a.h."), axis, degrees)
    found = lie(mesh)
    back = Rotation.from_matrix(found.axes) * Rotation.from_euler(axis, degrees, degrees=True)
    assert np.degrees(back.magnitude()) < 5.0
    with pytest.raises(InputError, match=f"is turned by .*turn it about {axis} by -?[0-9]+ degre"):
        check(mesh, "surface")


def test_a_scan_turned_about_two_axes_gets_both_in_order() -> None:
    mesh = turned(turned(finger("d.s."), "x", 40.0), "z", 30.0)
    with pytest.raises(InputError, match=r"turn it about z by -30 degrees, then .*x by -40 degr"):
        check(mesh, "surface")


@pytest.mark.parametrize(("axis", "degrees"), [("x", 13), ("y", -13), ("z", 20)])
def test_a_scan_that_may_be_turned_gets_a_note(axis: str, degrees: float) -> None:
    (note,) = check(turned(finger("p.w."), axis, degrees), "surface")
    assert "may be turned: to bring its symmetry and its axis into the frame" in note
    assert f"turn it about {axis} by" in note


def test_a_long_scan_is_judged_by_its_end() -> None:
    mesh = finger("a.h.").copy()
    behind = np.minimum(mesh.vertices[:, 0] - mesh.bounds[1, 0] + 20.0, 0.0)
    mesh.vertices[:, 0] += 4.0 * behind
    assert check(mesh, "surface") == ()
    with pytest.raises(InputError, match="about z by -30"):
        check(turned(mesh, "z", 30.0), "surface")

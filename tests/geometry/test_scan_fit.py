"""Smooth surface of a scan: an ellipsoid comes back, and its noise is what the fit says."""

from typing import Any

import numpy as np
import pytest

from fefinger.geometry.scan_fit import SmoothSkin, smooth_skin
from fefinger.support.arrays import Array


trimesh = pytest.importorskip("trimesh")

AXES = np.array([16.0, 7.0, 5.6])
CENTER = np.array([2.0, 0.0, 0.3])  # of the fit, beside that of the ellipsoid


def ellipsoid(noise: float = 0.0, seed: int = 0, subdivisions: int = 4) -> Any:
    mesh = trimesh.creation.icosphere(subdivisions, 1.0)
    outward = mesh.vertices / AXES
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    mesh.vertices *= AXES
    mesh.vertices += noise * np.random.default_rng(seed).normal(size=(len(outward), 1)) * outward
    return mesh


def fitted(mesh: Any, size: tuple[float, ...] = (14.0, 7.5, 5.0)) -> SmoothSkin:
    return smooth_skin(mesh, -8.0, CENTER, np.array(size))


def off(points: Array) -> Array:
    """Return distances (n,) mm of points (n, 3) from the ellipsoid, of the first order."""
    scaled = points / AXES
    return (np.sum(scaled**2, axis=1) - 1.0) / (2.0 * np.linalg.norm(scaled / AXES, axis=1))


def parabola(points: Array, middle: Array, at: Array) -> Array:
    """Return distances (n,) mm from the ellipsoid by a fit to those of points up to 5 mm away."""
    near = points[np.linalg.norm(points - middle, axis=1) < 5.0]
    rows = [
        np.stack([np.ones(len(x)), x, x**2, y**2], axis=1)
        for x, y in ((each - middle)[:, :2].T for each in (near, at))
    ]
    return np.asarray(rows[1] @ np.linalg.lstsq(rows[0], off(near), rcond=None)[0])


def test_an_ellipsoid_comes_back_from_another_center_and_size() -> None:
    """Its facets are inscribed: their middles lie up to 30 um inside, where the tip is sharpest."""
    skin = fitted(ellipsoid())
    points, normals = skin.sampled(0.5)
    assert points[:, 0].min() < -7.5
    points, normals = (each[points[:, 0] > -8.0] for each in (points, normals))
    assert np.abs(off(points)).max() < 0.02
    expected = points / AXES**2
    expected /= np.linalg.norm(expected, axis=1)[:, None]
    turned = np.degrees(np.arccos(np.clip(np.sum(normals * expected, axis=1), -1.0, 1.0)))
    assert np.sqrt(np.mean(turned**2)) < 0.2
    assert skin.asymmetry < 0.002
    assert np.sort(points @ [1.0, 7.0, 0.1]) == pytest.approx(np.sort(points @ [1.0, -7.0, 0.1]))


def test_the_normals_are_those_of_the_surface() -> None:
    """Against differences of places that the center sees to both sides, also at the pole."""
    skin = fitted(ellipsoid(0.1))
    aims = CENTER + np.array([[5.0, 0.0, 0.0], [3.0, 1.0, -4.0], [-2.0, 3.0, 1.0]])
    normals = skin.toward(aims)[1]
    for step in 1e-4 * np.eye(3):
        along = skin.toward(aims + step)[0] - skin.toward(aims - step)[0]
        assert np.sum(along * normals, axis=1) == pytest.approx(np.zeros(3), abs=1e-8)


def test_noise_and_what_it_leaves_uncertain_are_as_found_in_other_noise() -> None:
    """The scatter of six fits is that which each states, to what six values can tell.

    It is no more than that of parabolas through the vertices up to 5 mm away, to which the rest of
    the true shape is told: a limit of what such a scan can tell.
    """
    meshes = [ellipsoid(0.1, seed, 3) for seed in range(6)]
    skins = [fitted(mesh) for mesh in meshes]
    assert [skin.noise for skin in skins] == pytest.approx([0.1] * 6, rel=0.25)
    angle = np.arange(12) * np.pi / 6.0
    aims = np.array([4.0, 0.0, -5.0]) + 2.5 * np.column_stack(
        [np.cos(angle), np.sin(angle), 0.0 * angle]
    )
    aims = np.append(aims, [[4.0, 0.0, -5.0]], axis=0)
    weights = np.append(np.full(12, 1.0 / 12.0), -1.0)
    found = np.array([weights @ off(skin.toward(aims)[0]) for skin in skins])
    stated = np.sqrt(np.mean([skin.spread(aims, weights) ** 2 for skin in skins]))
    assert 0.4 < np.sqrt(np.mean(found**2)) / stated < 1.7
    told = [weights @ parabola(mesh.vertices, aims[-1], aims) for mesh in meshes]
    assert np.mean(found**2) < np.mean(np.square(told))
    raw = np.sqrt(np.mean([np.mean(off(skin.toward(aims)[0]) ** 2) for skin in skins]))
    assert raw < 0.04


def test_the_asymmetry_is_the_distance_from_the_mirror_image() -> None:
    """Moved aside by 0.1 mm, each place lies 0.2 mm times its normal's y from its image."""
    mesh = ellipsoid()
    mesh.vertices += [0.0, 0.1, 0.0]
    seen = mesh.triangles_center[:, 0] > -8.0
    aside = np.abs(mesh.face_normals[seen, 1])
    expected = 0.2 * np.average(aside, weights=mesh.area_faces[seen])
    assert fitted(mesh).asymmetry == pytest.approx(expected, rel=0.1)

"""Meshes on disk: exact round trip, hash, and where ready meshes come from."""

import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from threading import Event

import numpy as np
import pytest
from damage import flip
from refusals import refused

from fefinger.geometry.finger_mesh import FingerMesh, whole
from fefinger.mesh import mesh_record, store
from fefinger.mesh.recipe import Recipe, data_folder
from fefinger.scene.finger import Finger
from fefinger.support.checks import InputError


@pytest.fixture(scope="module")
def mesh() -> FingerMesh:
    """Return the smallest shipped half."""
    return mesh_record.read(data_folder() / "ah-coarse.vtu")


@pytest.fixture
def no_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Send the user's cache to an empty folder."""
    monkeypatch.setattr("platformdirs.user_cache_path", lambda _: tmp_path / "cache")
    return tmp_path / "cache"


@pytest.fixture
def builds(mesh: FingerMesh, monkeypatch: pytest.MonkeyPatch) -> list[FingerMesh]:
    """Build meshes that differ as if a mesher had drawn them at random; return them."""
    built: list[FingerMesh] = []

    def build(recipe: Recipe, **_: object) -> FingerMesh:
        built.append(replace(mesh, points=(1 + 1e-3 * len(built)) * mesh.points))
        return built[-1]

    monkeypatch.setattr("fefinger.mesh.build.build", build)
    return built


@pytest.mark.parametrize("make", [lambda mesh: mesh, whole], ids=["half", "whole"])
def test_round_trip_is_exact(mesh: FingerMesh, tmp_path: Path, make) -> None:
    given = make(mesh)
    back = mesh_record.read(mesh_record.write(given, tmp_path / "deep" / "finger.vtu"))
    for name in ("points", "cells", "region", "pad_normals"):
        # exact: a file keeps every bit
        assert np.array_equal(getattr(back, name), getattr(given, name)), name
    assert set(back.facets) == set(given.facets)
    for name, facets in given.facets.items():
        assert np.array_equal(back.facets[name], facets), name
    assert (back.half, back.name, back.recipe) == (given.half, given.name, given.recipe)
    assert back.quality == given.quality  # exact: a file keeps every bit


def test_nothing_temporary_is_left_behind(mesh: FingerMesh, tmp_path: Path) -> None:
    mesh_record.write(mesh, tmp_path / "finger.vtu")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["finger.json", "finger.vtu"]


def test_changed_mesh_is_refused(mesh: FingerMesh, tmp_path: Path) -> None:
    path = mesh_record.write(mesh, tmp_path / "finger.vtu")
    path.write_bytes(path.read_bytes() + b"\n")
    with pytest.raises(InputError, match=r"expected .*finger\.vtu to have the hash"):
        mesh_record.read(path)


@pytest.mark.parametrize("suffix", [".vtu", ".json"])
def test_missing_part_is_named(mesh: FingerMesh, tmp_path: Path, suffix: str) -> None:
    path = mesh_record.write(mesh, tmp_path / "finger.vtu")
    path.with_suffix(suffix).unlink()
    with pytest.raises(InputError, match=rf"expected the file .*finger\{suffix}"):
        mesh_record.read(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", r"expected JSON in .*finger\.json"),
        ("[]", "expected layout 1 .* received None"),
        ('{"layout": 99}', "expected layout 1 .* received 99"),
        ('{"layout": 1}', "expected 'name' in .*json"),
    ],
)
def test_a_sidecar_of_something_else_is_refused(
    mesh: FingerMesh, tmp_path: Path, text: str, said: str
) -> None:
    path = mesh_record.write(mesh, tmp_path / "finger.vtu")
    path.with_suffix(".json").write_text(text)
    with pytest.raises(InputError, match=said):
        mesh_record.read(path)


@pytest.mark.parametrize("text", ["", "{", "[]", "{}"])
def test_hash_in_a_damaged_sidecar_counts_as_none(no_cache: Path, text: str) -> None:
    finger = Finger(15, 11, tissue="maeno1998")
    sidecar = store.cached_path(Recipe.of(finger)) / "mesh.json"
    sidecar.parent.mkdir(parents=True)
    sidecar.write_text(text)
    assert store.sha256(finger) is None


def test_other_suffix_is_refused(mesh: FingerMesh, tmp_path: Path) -> None:
    with refused("mesh"):
        mesh_record.write(mesh, tmp_path / "finger.stl")


def test_sidecar_says_recipe_versions_and_quality(mesh: FingerMesh, tmp_path: Path) -> None:
    path = mesh_record.write(mesh, tmp_path / "finger.vtu")
    sidecar = json.loads(path.with_suffix(".json").read_text())
    assert sidecar["recipe"] == mesh.recipe
    assert {"pytetwild", "fefinger"} <= set(sidecar["versions"])
    assert sidecar["quality"]["min_dihedral_deg"] > 8


def test_surface_that_is_gone_is_named() -> None:
    with pytest.raises(
        InputError, match=r"finger\.surface: expected a file .*'gone\.stl' \(No such"
    ):
        Recipe(14, 10, 14, surface="gone.stl").key()


def test_shipped_mesh_is_used_without_meshing(no_cache: Path) -> None:
    half = store.load_or_build(Recipe(14, 10, 14, resolution="coarse"), half=True)
    assert half.name == "ah-coarse"
    assert half.half
    assert not store.load_or_build(Recipe(14, 10, 14, resolution="coarse"), half=False).half
    assert not no_cache.exists()


def test_new_mesh_is_built_once_and_cached(
    mesh: FingerMesh, no_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def build(recipe: Recipe, **_: object) -> FingerMesh:
        calls.append(recipe)
        return mesh

    monkeypatch.setattr("fefinger.mesh.build.build", build)
    recipe = Recipe(15, 11, 14)
    for _ in range(2):
        # exact: a file keeps every bit
        assert np.array_equal(store.load_or_build(recipe, half=True).points, mesh.points)
    assert calls == [recipe]
    (place,) = (no_cache / "meshes").iterdir()
    for number, name in enumerate(("mesh.vtu", "mesh.json"), start=2):
        flip(place / name)
        found = store.load_or_build(recipe, half=True)
        np.testing.assert_allclose(found.points, mesh.points, rtol=1e-12)
        assert len(calls) == number


def test_mesh_is_given_even_if_it_cannot_be_cached(
    mesh: FingerMesh, no_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    no_cache.write_text("a file where the folder should be")
    monkeypatch.setattr("fefinger.mesh.build.build", lambda recipe, **_: mesh)
    said: list[str] = []
    assert store.load_or_build(Recipe(15, 11, 14), half=True, progress=said.append) is mesh
    assert "could not be cached" in said[-1]


def test_mesh_that_cannot_be_cached_is_not_drawn_again(
    no_cache: Path, builds: list[FingerMesh]
) -> None:
    no_cache.write_text("a file where the folder should be")
    for _ in range(2):
        found = store.load_or_build(Recipe(15, 11, 14), half=True)
        assert found.fingerprint == builds[0].fingerprint
    assert len(builds) == 1


def test_first_mesh_that_is_kept_is_that_of_all(
    mesh: FingerMesh, no_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recipe, first = Recipe(15, 11, 14), replace(mesh, points=1.1 * mesh.points)

    def build(recipe: Recipe, **_: object) -> FingerMesh:
        store.keep(first, recipe)  # another process is done before
        return mesh

    monkeypatch.setattr("fefinger.mesh.build.build", build)
    for _ in range(2):
        assert store.load_or_build(recipe, half=True).fingerprint == first.fingerprint


def test_who_needs_a_mesh_that_is_being_built_waits_for_it(
    no_cache: Path, builds: list[FingerMesh], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("fcntl", reason="this system has no locks of files")
    building, another, build = Event(), Event(), import_module("fefinger.mesh.build").build

    def slowly(recipe: Recipe, **options: object) -> FingerMesh:
        if building.is_set():
            another.set()  # nobody waited
        building.set()
        assert another.wait(60)
        return build(recipe, **options)

    monkeypatch.setattr("fefinger.mesh.build.build", slowly)
    said: list[str] = []

    def say(sentence: str) -> None:
        said.append(sentence)
        another.set()

    recipe = Recipe(15, 11, 14)
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(store.load_or_build, recipe, half=True)
        assert building.wait(60)
        second = pool.submit(store.load_or_build, recipe, half=True, progress=say)
        assert first.result().fingerprint == second.result().fingerprint
    assert len(builds) == 1
    assert said == ["another process builds this mesh; waiting for it"]
    assert list((no_cache / "meshes").iterdir()) == [store.cached_path(Recipe(15, 11, 14))]

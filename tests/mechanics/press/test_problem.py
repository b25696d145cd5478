"""A press as the solvers see it: what of a scene is placed on a body, and what is left out."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import fefinger as ff
from fefinger.fem.contact.patch import smooth_places
from fefinger.fem.elements.spaces import trace
from fefinger.fem.linalg.system import System
from fefinger.mechanics.press.finite_strain import FINITE_STRAIN
from fefinger.mechanics.press.mesh_limits import FORCE_DEPTH
from fefinger.mechanics.press.operator import METHOD
from fefinger.mechanics.press.problem import Press, SolutionMethod, of_texture
from fefinger.mechanics.press.small_strain import WHOLE_MESH
from fefinger.support.progress import Stages


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
LEAN = ff.Ask(pressure=False, strain=False, fields=False)


@cache
def press(method=FINITE_STRAIN, indenter=None, motion=None, ask=LEAN, **options) -> Press:
    scene = ff.Scene(
        finger=FINGER,
        indenter=indenter or ff.Flat(30),
        motion=motion or ff.RampHold(20, 0.4, hold=0.1),
        ask=ask,
    )
    return Press.of(scene, method, Stages(), mechanics="linear", notes=("a note",), **options)


@pytest.fixture(scope="module", autouse=True)
def _forget_the_presses() -> Iterator[None]:
    """Free the factors of the presses that these tests share."""
    yield
    press.cache_clear()


def test_sites_are_placed_for_strain_and_the_reference_plate_for_spikes() -> None:
    lean = press()
    assert (lean.sites, lean.reference, lean.pressure, lean.fields) == (None, None, False, False)
    strained = press(ask=replace(LEAN, strain=True))
    assert len(strained.sites.types) == 4
    assert strained.reference is None
    fired = press(ask=replace(LEAN, spikes=("SAI",)), indenter=ff.Sphere(5, at=(2.0, 1.0)))
    assert fired.sites.types == fired.reference.sites.types == ("SAI",)
    assert not np.allclose(fired.sites.points, fired.reference.sites.points)
    assert not fired.standard


def test_the_indenter_is_at_first_touch() -> None:
    placed = press(indenter=ff.Sphere(5, at=(2.0, 1.0)))
    body = placed.body
    places = smooth_places(body.space.points, body.normals, trace(body.space, body.pad))
    assert placed.obstacle.gap(places)[0].min() == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(placed.obstacle.origin[:2], (2.0, 1.0), atol=0.05)


def test_loads_are_those_of_the_meshed_part() -> None:
    by_force = ff.Ramp(loading_rate=1.0, force=0.5)
    half, whole = (press(motion=by_force, indenter=ff.Flat(30, tilt)) for tilt in (0.0, 10.0))
    assert (half.body.sides, half.load_unit) == (2, 500.0)
    assert (whole.body.sides, whole.load_unit) == (1, 1000.0)
    assert half.expected_depth == FORCE_DEPTH * FINGER.thickness
    by_depth = press()
    assert (by_depth.load_unit, by_depth.expected_depth) == (1.0, 0.4)


def test_refining_divides_every_time_step() -> None:
    once, twice = press().time, press(refine=2).time
    np.testing.assert_allclose(once, twice[::2], rtol=1e-12)


@pytest.mark.usefixtures("operators")
def test_every_mechanics_makes_its_press_in_the_same_way() -> None:
    ask = replace(LEAN, spikes=("SAI", "FAI"))
    whole, finite, reduced = (press(each, ask=ask) for each in (WHOLE_MESH, FINITE_STRAIN, METHOD))
    for other in (finite, reduced):
        np.testing.assert_allclose(other.time, whole.time, rtol=1e-12)
        np.testing.assert_allclose(other.sites.points, whole.sites.points, atol=1e-12)
        np.testing.assert_allclose(other.obstacle.origin, whole.obstacle.origin, atol=1e-12)
        assert other.notes == whole.notes
        assert other.notes[0] == "a note"


def test_a_texture_that_first_touches_far_from_the_pad_is_held_against_the_nearest_facet() -> None:
    """Waves 45 mm high touch first where no facet is; a mean of none was a warning of NumPy."""
    placed = press()
    textured = ff.Scene(finger=FINGER, indenter=ff.Fabric(), motion=placed.motion)
    away = placed.obstacle.first_touch + np.array([0.0, 0.0, -20.0])
    (note,) = of_texture(textured, placed.body, replace(placed.obstacle, touched=away))
    assert "finer than the mesh resolves" in note


@pytest.mark.usefixtures("operators")
def test_a_reduced_body_has_no_system() -> None:
    assert len(press().system.free)
    with pytest.raises(TypeError, match="expected a Body with a system, received Operator"):
        _ = press(METHOD).system


@pytest.mark.parametrize(
    ("method", "factor"), [(WHOLE_MESH, "solver"), (FINITE_STRAIN, "approximate_factor")]
)
def test_the_body_of_a_finger_is_kept_for_its_next_press(
    method: SolutionMethod, factor: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of another tissue, or with another cache, there is another; failures are of one press."""
    mesh = press(method).mesh

    def system(finger: ff.Finger = FINGER) -> System:
        return method.body(finger, mesh, lambda fraction: None).system

    first = system()
    first.failed.append("in single precision")
    next_one = system()
    assert getattr(next_one, factor) is getattr(first, factor)
    assert next_one.failed == []
    other = system(ff.Finger.subject("a.h.", resolution="coarse", tissue="dandekar2003"))
    assert getattr(other, factor) is not getattr(first, factor)
    assert abs(other.matrix - first.matrix).max() > 0.0
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert getattr(system(), factor) is not getattr(first, factor)

"""Bone and nail: rigid, elastic or left out."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from fefinger.validation.problems import published
from fefinger.validation.problems.grids import box
from refusals import refused

from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.elements.spaces import Space
from fefinger.fem.hyperelastic.continuum import continuum
from fefinger.fem.hyperelastic.material import material_of
from fefinger.mechanics import get, linear, names, solid
from fefinger.mechanics.press import finite_strain, problem
from fefinger.mechanics.press.operator import operator
from fefinger.mechanics.situation import Situation
from fefinger.mesh.store import load_or_build
from fefinger.pipeline import run
from fefinger.results.records import Response
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motion import Motion
from fefinger.scene.motions import Ramp
from fefinger.scene.samples import Sampled
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Hard
from fefinger.support.checks import InputError
from fefinger.theory.relaxation import Prony


BONE, NAIL = Hard(17e6), Hard(2e6)
FINGER = replace(published.load("flat-press").finger, resolution="coarse")


def scene(depth: float = 0.5, motion: Motion | None = None, **parts: object) -> Scene:
    asked = published.load("flat-press").ask
    ask = replace(asked, spikes=(), fields=False, strain=False, rel_error=0.5)
    motion = motion or Ramp(60, depth, corner=0.0)
    return Scene(finger=replace(FINGER, **parts), indenter=Flat(30), motion=motion, ask=ask)


def light(depth: float, **parts: object) -> Scene:
    """Return a press of tissue that does not relax, which stands at its depth."""
    press = Sampled((0.0, 0.01), (depth, depth))
    return scene(motion=press, prony=Prony([1.0], []), **parts)


@cache
def response(**parts: object) -> Response:
    return linear.respond(scene(**parts))


def force(**parts: object) -> float:
    return float(response(**parts).force[-1])


def test_the_most_pressed_cell_may_lie_in_the_nail() -> None:
    even = box(*3 * (np.linspace(0.0, 1.0, 2),))
    space = Space(even.points, even.cells, np.full_like(even.tissue, problem.NAIL))
    elements = continuum(space, {problem.NAIL: material_of(Elastic(2e6, 0.3))})
    stretch, _, tissue = finite_strain.most_compressed(elements, np.zeros(space.n_unknowns))
    assert (stretch, tissue) == (pytest.approx(1.0), "nail")


def test_a_stiffer_and_stiffer_bone_becomes_rigid() -> None:
    rigid = force()
    apart = [1 - force(bone=Hard(modulus)) / rigid for modulus in (1e6, 1e8, 1e9)]
    assert 0.003 < apart[0] < 0.03
    assert apart[2] == pytest.approx(apart[1] / 10, rel=0.03)
    assert 0 < apart[2] < 1e-4


def test_a_nail_of_tissue_is_no_nail_and_a_stiff_one_moves_as_one_piece() -> None:
    free, glued = force(nail="free"), force()
    assert force(nail=Hard(FINGER.skin.modulus, FINGER.skin.poisson)) == pytest.approx(
        free, rel=1e-3
    )
    assert free < 0.8 * glued
    floating = force(nail=NAIL)
    assert floating == pytest.approx(glued, rel=0.05)
    assert force(nail=Hard(1e8)) == pytest.approx(floating, rel=2e-3)


def test_the_nail_is_a_layer_of_skin_under_its_outline() -> None:
    mesh = load_or_build(FINGER, half=True)
    found = problem.with_nail(replace(FINGER, nail=NAIL), mesh)
    nail = found.region == problem.NAIL
    assert (mesh.region[nail] == 1).all()
    assert np.array_equal(found.region[~nail], mesh.region[~nail])
    under = np.isin(mesh.cells[nail], mesh.facets["nail"]).any(axis=1)
    assert under.mean() > 0.6
    corners = mesh.points[mesh.facets["nail"]]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    outline = np.linalg.norm(sides, axis=1).sum() / 2
    cells = mesh.points[mesh.cells[nail]]
    volume = np.abs(np.linalg.det(cells[:, 1:] - cells[:, :1])).sum() / 6
    assert volume / outline == pytest.approx(FINGER.skin.thickness, rel=0.15)


@pytest.mark.usefixtures("few_steps")
def test_solid_becomes_linear_in_small_presses_on_an_elastic_bone() -> None:
    asked = light(0.05, bone=Hard(1e5), nail=NAIL)
    forces = [float(m.respond(asked).force[-1]) for m in (linear, solid)]
    assert forces[1] == pytest.approx(forces[0], rel=0.03)


@pytest.mark.parametrize("parts", [{"bone": BONE}, {"nail": NAIL}, {"nail": "free"}])
def test_mechanics_with_a_rigid_bone_refuse(parts: dict[str, object]) -> None:
    asked = scene(**parts)
    for name in names():
        unable = [r.reason for r in get(name).refuse(Situation.of(asked)) if r.about == "ability"]
        told = [reason for reason in unable if reason.startswith(f"finger.{next(iter(parts))}")]
        assert bool(told) == (name not in ("linear", "solid")), name
    with pytest.raises(InputError, match=r"finger\.(bone.modulus = 1.7e\+07|nail).*'solid'"):
        operator(asked.finger, half=True)


def test_a_bone_as_soft_as_tissue_is_left_to_solid() -> None:
    reasons = [r.reason for r in linear.refuse(Situation.of(scene(bone=Hard(1e5), nail=Hard(1e4))))]
    assert any("finger.bone.modulus / finger.skin.modulus = 977 < 50000" in r for r in reasons)
    assert any("finger.nail.modulus / finger.skin.modulus = 97.7 < 1000" in r for r in reasons)
    assert not any(
        "modulus" in r.reason for r in linear.refuse(Situation.of(scene(bone=BONE, nail=NAIL)))
    )


def test_the_notes_say_what_is_hard() -> None:
    def told(**parts: object) -> str:
        return " ".join(response(**parts).notes)

    assert "The bone is rigid and the nail does not move. Bone of 17 GPa" in told()
    assert "elastic, of 1.7e+07 kPa, and is held at its cut. The nail is held" in told(bone=BONE)
    assert "The bone is rigid. The nail is left out" in told(nail="free")
    assert "has the 2e+06 kPa of the nail" in told(nail=NAIL)


def test_scenes_keep_hard_parts_and_others_are_written_as_before() -> None:
    given = {"name": "x", "finger": {"subject": "a.h."}, "motion": {"kind": "ramp", "speed": 1.0}}
    given["motion"]["depth"] = 1.0
    plain = Scene.from_dict(given)
    assert plain.to_dict()["finger"]["bone"] == "rigid"
    assert "nail" not in plain.to_dict()["finger"]
    given["finger"] |= {"bone": {"modulus": 17e6}, "nail": {"modulus": 2e6, "poisson": 0.4}}
    hard = Scene.from_dict(given)
    assert hard.finger.bone == BONE
    assert hard.finger.nail == Hard(2e6, 0.4)
    assert Scene.from_toml(hard.to_toml()) == hard  # exact: TOML keeps every digit


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("bone", {"modulus": -1.0}, r"finger\.bone\.modulus: expected .*above 0.* -1"),
        ("bone", {"modulus": 7.0}, r"finger\.bone\.modulus: .*of the skin.* 7 kPa; a GPa is 1e6"),
        ("bone", {}, r"finger\.bone\.modulus: missing"),
        ("nail", {"modulus": 1.0, "poisson": 0.6}, r"finger\.nail\.poisson: expected .*0\.6"),
        ("nail", {"modulus": 1.0, "length": 3}, r"finger\.nail"),
        ("nail", "glued", r"finger\.nail: expected one of 'free'.*'glued'"),
        ("bone", "elastic", r"finger\.bone: expected one of 'rigid'.*'elastic'"),
    ],
)
def test_bad_hard_parts_are_refused(field: str, value: object, told: str) -> None:
    table = {"finger": {"subject": "a.h.", field: value}}
    table["motion"] = {"kind": "ramp", "speed": 1.0, "depth": 1.0}
    with pytest.raises(InputError, match=told):
        Scene.from_dict(table)


def test_a_solved_scene_records_its_memory_by_stage() -> None:
    result = run(scene(depth=0.05), mechanics="linear")
    assert re.search(r"in MB, by stage: mesh \d+, factor \d+", result.provenance["memory"])


def test_a_stored_scene_may_name_a_solver_that_is_gone() -> None:
    text = scene().to_toml().replace("[ask]", '[ask]\nsolver = "iterative"')
    assert Scene.from_stored(text) == scene()
    with refused("solver"):
        Scene.from_toml(text)


@pytest.mark.usefixtures("iterated_far")
def test_single_precision_that_fails_gives_way_with_a_note(
    unsound: Callable[..., None],
) -> None:
    usual = solid.respond(light(0.02))
    unsound(np.float32)
    double = solid.respond(light(0.02))
    assert double.force == pytest.approx(usual.force, rel=1e-6)
    assert any("Single precision failed for" in note for note in double.notes)
    unsound(np.float32, np.float64)
    with pytest.raises(InputError, match="hold more facets or repair the mesh"):
        solid.respond(light(0.02))


def test_the_held_facets_follow_the_hard_parts() -> None:
    def held(**parts: object) -> tuple[str, ...]:
        return problem.fixed_facets(replace(FINGER, **parts))

    assert held() == ("bone", "nail", "cut")
    assert held(cut="nail") == ("bone", "nail")
    assert held(bone=BONE) == ("bone-cut", "nail", "cut")
    assert held(bone=BONE, nail=NAIL, cut="nail") == ("bone-cut",)
    assert isinstance(Finger.subject("a.h.", bone=BONE, tissue="maeno1998").bone, Hard)

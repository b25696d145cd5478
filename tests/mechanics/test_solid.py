"""The finite-strain finger: its limits, its balance and its place on the ladder."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fefinger.validation.problems import published
from fefinger.validation.problems.cube import cube

import fefinger as ff
from fefinger.__main__ import main
from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.fem.elements.assembly import Elastic
from fefinger.fem.hyperelastic.material import material_of
from fefinger.fem.hyperelastic.newton import Equilibrium
from fefinger.fem.hyperelastic.state import State, Target
from fefinger.mechanics import linear, solid
from fefinger.mechanics.press import finite_strain
from fefinger.mechanics.press.finite_strain import most_compressed
from fefinger.neural.drives import equivalent_displacements
from fefinger.results.records import Response
from fefinger.scene.motion import Motion
from fefinger.scene.scene import Scene
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.tolerances import EQUILIBRIUM


PRONY = {"c": [0.4, 0.6], "v": [50.0]}
ELASTIC = ff.Prony((1.0,), ())


def press(motion: Motion, *, strain: bool = False, **finger: object) -> Scene:
    """Return a plate on the coarse finger of flat-press."""
    scene = published.load("flat-press")
    asked = ff.Ask(strain=strain, fields=strain)
    coarse = replace(scene.finger, resolution="coarse", **finger)
    return Scene(finger=coarse, indenter=ff.Flat(30), motion=motion, ask=asked)


def at_once(depth: float) -> ff.Sampled:
    """Return a press that stands at its depth: what does not relax answers as after a ramp."""
    return ff.Sampled((0.0, 0.01), (depth, depth))


DEEP = press(at_once(1.2), prony=ELASTIC)


@pytest.fixture(scope="module")
def deep(stride_far: Callable[[pytest.MonkeyPatch], None]) -> Response:
    """Return a deep press of tissue that does not relax, iterated far."""
    with pytest.MonkeyPatch.context() as patched:
        stride_far(patched)
        patched.setattr(finite_strain, "PRESS_EQUILIBRIUM", EQUILIBRIUM)
        return solid.respond(DEEP)


@pytest.fixture(scope="module")
def held(stride_far: Callable[[pytest.MonkeyPatch], None]) -> Response:
    """Return a short press with a hold, and all that can be asked of it."""
    with pytest.MonkeyPatch.context() as patched:
        stride_far(patched)
        return solid.respond(press(ff.RampHold(20, 0.5, hold=0.5), strain=True))


@pytest.mark.usefixtures("few_steps", "iterated_far")
@pytest.mark.parametrize("spread", [1.4 * finite_strain.SPREAD, 0.35], ids=["wider", "to the rim"])
def test_the_answer_does_not_depend_on_which_vertices_may_touch(
    spread: float, deep: Response, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With more of them up the sides of the pad the area used to lose a fifth.

    A contact that meets the rim of too few is solved again with more.
    """
    reaches = []

    def seen(*parts: Any, **options: Any) -> ContactSurface:
        reaches.append(parts[-1])
        return contact_surface(*parts, **options)

    monkeypatch.setattr(finite_strain, "contact_surface", seen)
    monkeypatch.setattr(finite_strain, "SPREAD", spread)
    other = solid.respond(DEEP)
    assert (len(reaches) == 1) == (spread > 1)
    assert (other.numbers["candidates"] > deep.numbers["candidates"]) == (spread > 1)
    assert other.force == pytest.approx(deep.force, rel=1e-6, abs=1e-9)
    assert deep.contact_area is not None
    assert other.contact_area == pytest.approx(deep.contact_area, rel=1e-3)


@pytest.mark.usefixtures("few_steps")
def test_it_tends_to_small_strain_in_first_order_of_the_depth():
    gaps = []
    for depth in (0.02, 0.04):
        scene = press(at_once(depth), prony=ELASTIC)
        small, finite = linear.respond(scene), solid.respond(scene)
        gaps.append(finite.force[-1] / small.force[-1] - 1)
    assert abs(gaps[0]) < 0.005
    assert gaps[1] / gaps[0] == pytest.approx(2, rel=0.35)


def test_force_area_and_pressure_agree(held: Response):
    assert held.pad is not None
    assert held.pressure is not None
    assert held.contact_area is not None
    normal = held.pressure @ held.pad.areas * 1e-3
    assert normal == pytest.approx(held.force, rel=1e-9, abs=1e-12)
    assert (held.pressure >= 0).all()
    assert (held.contact_area[held.force > 0] > 0).all()


def test_the_force_relaxes_in_the_hold_while_the_strain_stays(held: Response):
    assert held.strain is not None
    start = int(np.argmax(held.depth))
    assert (np.diff(held.force[start + 1 :]) < 0).all()
    drift = np.abs(held.strain[start:] - held.strain[start]).max()
    assert drift < 0.02 * np.abs(held.strain).max()


@pytest.mark.usefixtures("few_steps")
def test_the_standard_plate_moves_end_organs_as_deep_as_the_reference_press():
    """At small strain the reference differed by up to 13 %: spikes were too many."""
    scene = press(at_once(0.5), strain=True, prony=ELASTIC)
    asked = replace(scene.ask, spikes=("SAI", "SAII", "FAI"))
    found = solid.respond(replace(scene, ask=asked))
    assert found.strain is not None
    assert found.sites is not None
    assert found.reference is not None
    moved = equivalent_displacements(
        found.strain[-1:],
        found.sites.normals,
        found.sites.types,
        found.reference,
    )
    assert moved == pytest.approx(0.5, rel=1e-5)


def test_fields_and_sites_tell_the_same_strain(held: Response):
    assert held.fields is not None
    assert held.sites is not None
    assert held.strain is not None
    site = held.sites.points[2]
    near = int(np.argmin(np.linalg.norm(held.fields.points - site, axis=1)))
    last = held.fields.strain[-1, near, 2]
    assert last == pytest.approx(held.strain[-1, 2, 2, 2], rel=0.5)
    assert np.linalg.norm(held.fields.displacement[-1], axis=1).max() < 1.0


@pytest.mark.usefixtures("few_steps")
def test_skin_that_is_pressed_together_in_contact_does_not_fold_through_the_plate():
    finger = ff.Finger.subject("d.p.", resolution="coarse", prony=ELASTIC, tissue="maeno1998")
    motion = ff.Ramp(60, 0.2 * finger.thickness, corner=0)
    ask = ff.Ask(strain=False, fields=False)
    found = solid.respond(Scene(finger=finger, indenter=ff.Flat(30), motion=motion, ask=ask))
    assert found.gap is not None
    assert found.pressure is not None
    # exact: prescribed
    assert found.depth[-1] == motion.depth
    assert found.force[-1] == pytest.approx(3.36, rel=0.01)
    assert found.gap[-1][found.pressure[-1] > 0].min() > -0.1  # mm, a tenth of a facet


@pytest.mark.usefixtures("few_steps")
def test_stiffening_tissue_pushes_back_harder():
    scene = press(at_once(0.4), prony=ELASTIC)
    skin, pulp = (
        replace(layer, law="demiray", exponent=10.0)
        for layer in (scene.finger.skin, scene.finger.subcutaneous)
    )
    stiffer = replace(scene, finger=replace(scene.finger, skin=skin, subcutaneous=pulp))
    assert solid.respond(stiffer).force[-1] > 1.05 * solid.respond(scene).force[-1]


@pytest.mark.usefixtures("few_steps")
def test_a_prescribed_force_is_what_it_tells_between_its_steps_as_well():
    scene = press(ff.Trapezoid(loading_rate=2.0, force=0.1, hold=0.02, corner=0.01))
    found = solid.respond(scene)
    wanted = scene.motion.value(found.time)
    assert len(found.time) > 2 * found.numbers["steps"]
    assert found.force == pytest.approx(wanted, abs=1e-5 * wanted.max())  # interpolated: .009
    assert found.force == pytest.approx(found.pressure @ found.pad.areas * 1e-3, rel=1e-9)
    held = found.depth[wanted > 0.1 * (1 - 1e-9)]
    assert held[-1] > held[0]


COMMON = {
    "finger.resolution": "coarse",
    "finger.prony": PRONY,
    "motion": {"kind": "ramp", "speed": 10, "depth": 0.2},
    "ask.spikes": [],
    "ask.fields": False,
}


@pytest.fixture(scope="module")
def plain(stride_far: Callable[[pytest.MonkeyPatch], None]) -> float:
    """Return the largest force where all tissue relaxes alike, and wholly."""
    with pytest.MonkeyPatch.context() as patched:
        stride_far(patched)
        return float(solid.respond(published.load("flat-press", COMMON)).force.max())


@pytest.mark.usefixtures("few_steps")
@pytest.mark.parametrize(
    ("settings", "reason", "note"),
    [
        (
            {"finger.relaxation": "deviatoric"},
            "relaxes the whole stress",
            "Only the deviatoric stress relaxes; the pressure is elastic.",
        ),
        (
            {"finger.skin.prony": {"c": [0.9, 0.1], "v": [100.0]}, "finger.prony": PRONY},
            "relaxes all tissue with one function",
            "The skin relaxes with a series of its own.",
        ),
    ],
)
def test_tissue_that_relaxes_otherwise_is_for_solid_alone(
    settings: dict[str, object], reason: str, note: str, plain: float
):
    asked = published.load("flat-press", COMMON | settings)
    plan = ff.explain(asked)
    assert plan.mechanics == "solid"
    for rung in plan.rungs[:-1]:
        assert any(reason in refusal.reason for refusal in rung.refusals)
    found = solid.respond(asked)
    assert note in found.notes
    assert 0 < abs(found.force.max() / plain - 1) < 0.5


@pytest.mark.usefixtures("few_steps", "plain_report")
def test_a_run_that_has_to_stop_keeps_and_saves_what_it_reached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    find = Equilibrium.find

    def limited(self: Equilibrium, start: State, target: Target) -> State:
        if target.value > 0.155:  # between two steps, so that rounding does not decide
            message = "equilibrium: not reached"
            raise ConvergenceError(message)
        return find(self, start, target)

    monkeypatch.setattr(Equilibrium, "find", limited)
    folder = tmp_path / "out"
    scene = ["flat-press", "--set", "finger.resolution=coarse", "--set", "motion.depth=0.3"]
    small = ["--set", "ask.fields=false", "--set", "ask.spikes=[]", "--set", "motion.corner=0.001"]
    assert main(["run", *scene, *small, "--mechanics", "solid", "-o", str(folder)]) == 1
    said = capsys.readouterr().err
    assert "saved up to there:" in said
    assert "failed: at" in said
    assert "At the last equilibrium the subcutaneous tissue at x = " in said
    kept = ff.load(str(folder))
    assert kept.status.startswith("Stopped: ")
    assert 0.1 < kept.depth[-1] < 0.155
    assert kept.force[-1] > 0
    assert kept.strain.shape[0] == len(kept.time)


def test_the_most_pressed_cell_of_a_squeezed_cube_has_the_stretch_of_the_cube():
    block = cube(material_of(Elastic(40.0, 0.5)), 1)
    state = State(np.zeros(block.body.space.n_unknowns), np.zeros(4), 0.0)
    for depth in (0.1, 0.2):
        target = Target("depth", depth, block.body.at_rest)
        state = block.equilibrium.find(state, target)
    stretch, place, tissue = most_compressed(block.body, state.values)
    assert stretch == pytest.approx(0.8, rel=1e-6)
    assert tissue == "skin"
    assert ((place > 0) & (place < 1)).all()


def test_a_press_through_the_bone_is_refused():
    with pytest.raises(InputError, match="tissue over the bone"):
        solid.respond(press(ff.Ramp(60, 4.95)))


def test_laws_travel_through_scene_files():
    settings = {"finger.skin.law": "demiray", "finger.skin.exponent": 4.0}
    scene = published.load("flat-press", settings)
    assert scene.finger.skin.exponent == 4.0
    assert Scene.from_toml(scene.to_toml()) == scene


@pytest.mark.parametrize(
    ("settings", "what"),
    [
        ({"finger.skin.law": "rubber"}, "finger.skin.law"),
        ({"finger.skin.law": "demiray"}, "finger.skin.exponent: missing"),
        ({"finger.skin.exponent": 2.0}, "finger.skin.exponent: expected none"),
        ({"finger.skin.law": "mooney-rivlin", "finger.skin.share": 2.0}, "finger.skin.share"),
    ],
)
def test_laws_are_checked(settings: dict[str, object], what: str):
    with pytest.raises(InputError, match=what):
        published.load("flat-press", settings)


@pytest.mark.parametrize("mechanics", [linear, solid], ids=["linear", "solid"])
def test_contact_that_reaches_the_rim_of_an_object_is_refused_with_what_to_do(mechanics: Any):
    lines = np.linspace(-2.0, 2.0, 9)
    tile = ff.Relief.of(lambda x, y: 0 * x * y, lines, lines)
    scene = replace(press(at_once(1.2), prony=ELASTIC), indenter=tile)
    with pytest.raises(InputError, match=r"the rim, .* with \d+ vertices .*; press less"):
        mechanics.respond(scene)

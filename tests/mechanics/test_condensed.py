"""The mechanics `condensed`: the answers of `linear`, its operator on disk, its refusals."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damage import flip

import fefinger as ff
from fefinger.fem.body import Reduced
from fefinger.fem.condensation import Compliance
from fefinger.mechanics import condensed, linear
from fefinger.mechanics.evidence.presses import read
from fefinger.mechanics.press import operator, operator_cache
from fefinger.mechanics.press.notes import RIGID_BONE
from fefinger.mechanics.situation import Situation
from fefinger.mesh.store import load_or_build
from fefinger.results.records import Response


FINGER = ff.Finger.subject("a.h.", resolution="coarse", tissue="maeno1998")
STIFFER = replace(FINGER, skin=replace(FINGER.skin, modulus=3 * FINGER.skin.modulus))
WAVE = ff.RampSinusoid(20, 0.5, amplitude=0.7, frequency=8, cycles=2)
PRESSES = {
    "hold": (ff.Flat(30), ff.RampHold(60, 1.2, hold=0.3)),
    "re-contact": (ff.Flat(25, 20), WAVE),  # on the mesh that `linear` takes too
    "force": (ff.Sphere(5, at=(1, 1)), ff.Trapezoid(loading_rate=2, force=0.3, hold=0.3)),
    # Its dots come near the sides of the finger, which the operator does not keep.
    "near the sides": (
        ff.Dots(3.0, height=0.4),
        ff.Slide(60, force=0.6, distance=6, direction=180),
    ),
}


def scene(press: str, **parts: object) -> ff.Scene:
    indenter, motion = PRESSES[press]
    return ff.Scene(**({"finger": FINGER, "indenter": indenter, "motion": motion} | parts))


pytestmark = pytest.mark.usefixtures("operators")


def same(found: Response, expected: Response, name: str) -> None:
    """Check agreement to 1e-10 of the largest value, at every step."""
    a, b = (np.nan_to_num(getattr(r, name)).reshape(len(r.time), -1) for r in (found, expected))
    assert (np.abs(a - b).max(axis=1) <= 1e-10 * np.abs(b).max(axis=1) + 1e-14 * b.max()).all()


@pytest.mark.parametrize("press", ["re-contact", "near the sides"])  # more in suite condensed
def test_every_step_is_that_of_linear(press: str) -> None:
    asked = scene(press, ask=ff.Ask(fields=press == "re-contact", spikes=("SAI", "FAI")))
    expected, found = linear.respond(asked), condensed.respond(asked)
    assert condensed.BEYOND not in found.notes
    for name in ("depth", "force", "contact_area", "centroid", "pressure", "strain"):
        same(found, expected, name)
    assert found.reference.strain == pytest.approx(expected.reference.strain, abs=1e-12)
    assert found.mechanics == "condensed"
    assert found.seconds["pressure"] > 0
    if found.fields is not None:
        for name in ("displacement", "strain", "pressure"):
            exact = getattr(expected.fields, name)
            assert np.abs(getattr(found.fields, name) - exact).max() < 1e-10 * np.abs(exact).max()


def test_one_operator_serves_every_modulus_of_the_same_ratio(operators: Path) -> None:
    condensed.respond(scene("hold"))
    before = sorted(operators.iterdir())
    twice = replace(
        FINGER,
        skin=replace(FINGER.skin, modulus=2 * FINGER.skin.modulus),
        subcutaneous=replace(FINGER.subcutaneous, modulus=2 * FINGER.subcutaneous.modulus),
    )
    asked = scene("hold", finger=twice, ask=ff.Ask(fields=False))
    same(condensed.respond(asked), linear.respond(asked), "pressure")
    assert sorted(operators.iterdir()) == before


def test_what_decides_the_operator_decides_its_folder() -> None:
    changed = [
        FINGER,
        STIFFER,
        replace(FINGER, cut="nail"),
        replace(FINGER, subcutaneous=replace(FINGER.subcutaneous, poisson=0.45)),
        replace(FINGER, resolution="standard"),
    ]
    folders = {
        operator_cache.folder(operator_cache.identity(f, odd=odd))
        for f in changed
        for odd in (False, True)
    }
    assert len(folders) == 10
    slower = replace(FINGER, prony=ff.Prony((0.5, 0.5), (1.0,)))
    assert operator_cache.identity(slower, odd=False) == operator_cache.identity(FINGER, odd=False)


def test_what_was_written_is_read_back_exactly(tmp_path: Path) -> None:
    built = operator.build(FINGER, load_or_build(FINGER, half=True), odd=False)
    operator.write(built, tmp_path / "kept", "an operator")
    operator.write(built, tmp_path / "kept", "another")  # the second one changes nothing
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]
    assert (tmp_path / "kept" / "what.txt").read_text() == "an operator"
    found = operator.read(tmp_path / "kept")
    assert np.array_equal(found.matrix, built.matrix)  # exact: a file keeps every bit
    assert np.array_equal(found.order, built.order)
    for a, b in zip(found.fronts, built.fronts, strict=True):
        for name in ("lower", "below", "signs"):
            # exact: a file keeps every bit
            assert np.array_equal(getattr(a, name), getattr(b, name))
        assert np.array_equal(a.front.rest, b.front.rest)


def test_damaged_entries_are_made_anew(
    operators: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    condensed.respond(scene("hold"))
    entry = operator_cache.folder(operator_cache.identity(FINGER, odd=False))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    place = operator_cache.folder(operator_cache.identity(FINGER, odd=False))
    shutil.copytree(entry, place)

    def force() -> float:
        return ff.Loop(FINGER, mechanics="condensed", deepest=0.6).step(0.0, depth=0.4).force

    sound, built = force(), []
    made, reduce = operator.build, operator.reduction.reduce

    def build(*given: Any, **options: Any) -> Compliance:
        built.append("operator")
        return made(*given, **options)

    def reduced(*given: Any) -> Reduced:
        built.append("patch")
        return reduce(*given)

    monkeypatch.setattr(operator, "build", build)
    monkeypatch.setattr(operator.reduction, "reduce", reduced)
    assert force() == pytest.approx(sound, rel=1e-9)  # a flipped bit changes it by 1e-4
    assert built == []
    (patch,) = (tmp_path / "fefinger" / "patches").iterdir()
    for name in ("flexibility", "strain", "normal_displacement"):
        flip(patch / f"{name}.npy")
        assert force() == pytest.approx(sound, rel=1e-12)
    assert built == 3 * ["patch"]
    flip(place / "values.npy")
    assert force() == pytest.approx(sound, rel=1e-12)
    assert built == [*(3 * ["patch"]), "operator"]


def test_contact_beyond_the_palmar_part_is_solved_on_the_whole_mesh() -> None:
    asked = scene("hold", indenter=ff.Flat(55), motion=ff.Ramp(60, 1.6))
    found, expected = condensed.respond(asked), linear.respond(asked)
    assert {RIGID_BONE, condensed.BEYOND} < set(found.notes)
    assert found.mechanics == "condensed"
    assert found.force[-1] == pytest.approx(expected.force[-1], rel=0.03)  # on another mesh


def test_accuracy_is_refused_as_linear_does() -> None:
    (refusal,) = condensed.refuse(Situation.of(scene("hold", indenter=ff.Sphere(radius=0.3))))
    assert (refusal.mechanics, refusal.about) == ("condensed", "accuracy")


def test_the_error_is_that_of_a_mesh_that_does_not_follow_the_touch() -> None:
    steep = Situation.of(scene("hold", indenter=ff.Flat(45)))
    error, source = condensed.error(steep)
    assert error > linear.error(steep)[0]
    assert "reports/evidence.json, maeno1998/flat-45" in source


def test_the_cost_knows_whether_the_operator_is_at_hand() -> None:
    finger = replace(FINGER, resolution="standard")
    row = read("small-strain-cost.json")["rows"]["condensed standard"]
    asked = scene("hold", finger=finger)
    assert condensed.cost(Situation.of(asked)) > row["build_seconds"]
    operator_cache.folder(operator_cache.identity(finger, odd=False)).mkdir(parents=True)
    assert condensed.cost(Situation.of(asked)) < row["build_seconds"]
    assert not operator_cache.available(replace(finger, width=60.0), half=True)

"""Which tissue a finger has that names none."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.mesh.parametric import parametric
from fefinger.mesh.recipe import Recipe
from fefinger.scene import library
from fefinger.scene.finger import Finger
from fefinger.scene.scene import Scene
from fefinger.scene.tissue import Tissue


@pytest.mark.parametrize("subject", ["a.h.", "d.p.", "d.s.", "p.w."])
def test_a_subject_has_the_tissue_that_was_fitted_to_its_curves(subject: str) -> None:
    fitted = library.tissue_set(library.calibrated_name(subject))
    finger = Finger.subject(subject)
    assert (finger.skin, finger.subcutaneous) == (fitted.skin, fitted.subcutaneous)
    assert (finger.pad_radius, finger.prony) == (fitted.pad_radius, fitted.prony)


@pytest.mark.parametrize(
    "finger", [Finger(15.0, 12.0), Finger.subject("f.c.", width=13.0, thickness=10.0)]
)
def test_any_other_finger_has_the_tissue_of_the_means(finger: Finger) -> None:
    assert finger.tissue == "calibrated_means"


def _with_skin(line: str) -> Finger:
    return Scene.from_toml(
        f'[finger]\nsubject = "a.h."\n[finger.skin]\n{line}\n'
        '[motion]\nkind = "ramp"\nspeed = 1\ndepth = 1\n'
    ).finger


def test_values_of_a_layer_change_the_tissue_of_the_finger_and_nothing_else() -> None:
    own = Finger.subject("a.h.")
    assert _with_skin(f"poisson = {own.skin.poisson}") == own
    assert _with_skin("modulus = 100") == replace(own, skin=replace(own.skin, modulus=100))
    soft = replace(own.skin, law="neo-hookean", exponent=None)
    assert _with_skin('law = "neo-hookean"') == replace(own, skin=soft)
    skin = Tissue(100, 0.48, 1.0)
    assert Finger.subject("a.h.", skin=skin) == replace(own, skin=skin)


def test_the_set_of_the_means_is_that_of_its_report() -> None:
    from fefinger.mechanics.evidence.presses import read

    row, tissue = read("calibrated-means.json"), library.tissue_set("calibrated_means")
    assert tissue.skin.modulus == pytest.approx(row["skin"]["modulus"], rel=1e-3)
    assert tissue.subcutaneous.exponent == pytest.approx(row["subcutaneous"]["exponent"], rel=1e-3)
    assert tissue.pad_radius == pytest.approx(row["finger"]["pad_radius"], rel=1e-3)
    assert tissue.prony.c == pytest.approx(row["prony"]["c"], rel=1e-3)


@pytest.mark.parametrize("size", [(9.0, 7.0), (12.0, 10.5), (16.0, 11.0), (20.0, 16.0)])
def test_a_finger_of_any_size_keeps_the_profile_of_the_mean_one(size: tuple[float, float]) -> None:
    finger, mean = Finger(*size), Finger(14.0, 11.0)
    thicker = finger.thickness / mean.thickness
    own, large = (parametric(Recipe.of(each)).skin for each in (finger, mean))
    x = np.linspace(-5.0, large.tip - 0.1, 40)
    apart = own.heights(thicker * x)[1] - thicker * large.heights(x)[1]
    assert np.abs(apart).max() < 0.02 * finger.thickness
    assert finger.tip_radius == pytest.approx(thicker * mean.tip_radius)
    assert finger.pad_radius == pytest.approx(finger.width / mean.width * mean.pad_radius)

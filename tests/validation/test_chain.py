"""The chain of models from Hertz to finite strain, and the split of their difference."""

import numpy as np
import pytest
from fefinger.validation.finger import causes
from fefinger.validation.finger import split as finger_split
from fefinger.validation.problems import chain

from fefinger.theory.contact.hertz import Hertz
from fefinger.theory.lumped.spring import Spring


def test_the_first_model_of_the_chain_is_hertz_of_the_relaxed_tissue() -> None:
    depth, force, _ = chain.reaching("hertz", chain.scene("d.s.", "flat-30"))
    finger = chain.scene("d.s.", "flat-30").finger
    skin, rest = finger.skin, finger.subcutaneous
    part = skin.thickness / (0.5 * finger.thickness)
    modulus = 1 / (part / skin.modulus + (1 - part) / rest.modulus)
    expected = Hertz(12.0, float(depth[-1]), modulus, 0.48).force
    assert 1e3 * force[-1] == pytest.approx(expected, rel=1e-9)
    assert depth == pytest.approx(0.2 * 11.5 * np.arange(1, 13) / 12)


def test_one_tissue_makes_the_layers_alike_and_nothing_else() -> None:
    pressed = chain.scene("a.h.", "sphere-5")
    alike = chain.one_tissue(pressed)
    assert alike.finger.skin.modulus == alike.finger.subcutaneous.modulus
    forces = [chain.reaching("hertz", each)[1] for each in (alike, pressed)]
    assert forces[0] == pytest.approx(forces[1])


def test_a_ball_has_no_angle() -> None:
    assert "level" not in chain.models("sphere-5")
    assert chain.models("flat-30") == tuple(chain.CHAIN)


def test_the_factors_multiply_to_finite_strain_over_hertz() -> None:
    for subject in chain.SUBJECTS:
        split = finger_split.factors(subject, "sphere-5")
        first, last = (
            finger_split.force(subject, "sphere-5", model)[5] for model in ("hertz", "solid")
        )
        assert np.prod(list(split.values())) == pytest.approx(last / first)
        swapped = finger_split.other_order(subject, "sphere-5")
        assert swapped["whole"] * swapped["layered"] == pytest.approx(
            split["layered"] * split["linear"]
        )


def test_steepness_finds_m_of_an_exponential_spring(monkeypatch: pytest.MonkeyPatch) -> None:
    depth = 2.0 * np.arange(1, 13) / 12
    force = Spring(m=2.1, b=0.18).force(depth)
    springs = {"solid": force.tolist()}
    made = {"depth_mm": depth.tolist(), "thickness_mm": 10.0, "force_N": springs}
    monkeypatch.setattr(finger_split, "rows", lambda: {"a.h./flat-30": made})
    assert finger_split.steepness("a.h.", "solid") == pytest.approx(2.1, rel=1e-9)
    springs["solid"] = (depth**1.5).tolist()
    assert finger_split.steepness("a.h.", "solid") == pytest.approx(np.log(2**1.5 - 1), rel=1e-9)


def test_a_stale_report_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    assert causes.stale("hertz", "a.h.", "flat-30") < 1e-4
    kept = finger_split.force
    monkeypatch.setattr(causes, "force", lambda *which: kept(*which) * np.linspace(1, 1.01, 12))
    assert causes.stale("hertz", "a.h.", "flat-30") == pytest.approx(0.0099, rel=0.01)

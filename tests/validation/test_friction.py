"""Suite `friction`: its measures converge, and its checks can fail."""

from pathlib import Path

import numpy as np
import pytest
from fefinger.validation.friction import bonded, dots, layers, sheared, waves


@pytest.fixture(autouse=True)
def _own_cache(operators: Path) -> None:
    """Keep to the operators of this session."""


def test_stick_and_force_converge_with_the_squares():
    for measure in (sheared.stick_error, sheared.force_error):
        coarse, fine = (measure("squares", size) for size in (8, 16))
        assert fine < 0.8 * coarse


def test_the_checks_see_a_wrong_flexibility_and_a_wrong_coefficient():
    matrix, rest = bonded.offset(0.7 * sheared.limit())
    x = bonded.solved(matrix, rest, 0.5)
    n = len(rest) // 3
    wrong = matrix.copy()
    wrong[n:, n:] *= 1.02
    assert np.abs(bonded.solved(wrong, rest, 0.5) - x).max() > 1e-3 * x.max()
    assert np.abs(bonded.solved(matrix, rest, 0.51) - x).max() > 1e-3 * x.max()


def test_drag_vanishes_with_the_memory_and_peaks_between_its_rates():
    drags = [waves.exact(speed) for speed in (1e-6, 1.0, 20.0, 1e6)]
    assert max(drags[0], drags[3]) < 1e-3 * drags[2]


def test_dots_on_layers_that_have_gone_more_than_half_their_way_are_mirrored(monkeypatch):
    monkeypatch.setattr(layers, "POINTS", 128)
    monkeypatch.setattr(layers, "SPACING", 0.12)
    monkeypatch.setattr(layers, "STEP", 0.5)
    layers.fine.cache_clear()
    scene = dots.scene(2.0, 0.7)
    organs, pad = layers.sites(scene), layers.fine()
    strains = layers.strains(scene, organs)
    moved = np.array([1.5, 0.0])
    pressure = pad.pressure_by_force(
        lambda at: scene.indenter.profile.rise(at - moved), 600.0, np.ones(pad.places.shape[:2])
    )
    shallow = organs.depths == organs.depths.min()
    found = pad.strain(pressure, float(organs.depths.min()), organs.points[shallow, :2])
    assert strains[3, shallow] == pytest.approx(found, abs=1e-3 * np.abs(found).max())
    assert np.abs(strains[1, shallow] - found).max() > 0.1 * np.abs(found).max()
    layers.fine.cache_clear()


def test_recorded_rates_are_those_of_three_types_over_rising_spacings():
    recorded = dots.recorded()
    assert set(recorded) == {"SAI", "FAI", "FAII"}
    for spacing, rate in recorded.values():
        assert (np.diff(spacing) > 0).all()
        assert spacing[0] <= dots.SPACINGS[0]
        assert dots.SPACINGS[-1] <= spacing[-1]
        assert (rate > 0).all()

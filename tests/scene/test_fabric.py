"""The fabric: its stated spectrum, what repeats, and what makes no fabric."""

import numpy as np
import pytest
from refusals import refused

import fefinger as ff


def spectrum(fabric):
    """Return wavenumbers (n, n) in 1/mm, and the power there of the heights."""
    heights = fabric.heights
    waves = np.abs(np.fft.fft2(heights) / heights.size) ** 2
    line = np.fft.fftfreq(len(heights), fabric.tile / len(heights))
    return np.hypot(*np.meshgrid(line, line)), waves


def test_a_weave_has_lines_at_one_over_the_yarn_alone():
    q, power = spectrum(ff.Fabric(1.25, height=0.2, roughness=0.0))
    wanted = {0.0: 0.05**2, 0.8: 4 * (0.05 / 2) ** 2, 0.8 * 2**0.5: 4 * (0.05 / 4) ** 2}
    found = {line: power[np.abs(q - line) < 1e-9].sum() for line in wanted}
    assert found == pytest.approx(wanted)
    assert power.sum() == pytest.approx(sum(wanted.values()))


def test_fibers_are_as_rough_as_asked_and_fall_with_the_wavenumber():
    fabric, smooth = (ff.Fabric(roughness=each, seed=3) for each in (0.01, 0.0))
    assert (fabric.heights - smooth.heights).std() == pytest.approx(0.01)
    q, power = spectrum(fabric)
    bands = [power[(q > low) & (q < low + 1.0)].mean() for low in (1.6, 3.6)]
    assert np.log(bands[1] / bands[0]) / np.log(4.1 / 2.1) == pytest.approx(-3.6, abs=0.4)
    assert power[q > 5.0 * 1.001].max() < 1e-12 * power.max()
    assert np.abs(ff.Fabric(seed=4).heights - ff.Fabric(seed=3).heights).max() > 0.005


def test_the_profile_is_the_heights_and_repeats_after_eight_yarns():
    fabric = ff.Fabric(seed=1)
    n, step = len(fabric.heights), fabric.tile / len(fabric.heights)
    at = step * np.array([[0, 0], [7, 100], [n - 1, n // 2]])
    wanted = [fabric.heights[tuple(each)] for each in ((0, 0), (7, 100), (n - 1, n // 2))]
    drop = -fabric.profile.rise(np.vstack([at, at + fabric.tile]))
    assert drop - drop[0] == pytest.approx(np.tile(wanted, 2) - wanted[0], abs=1e-6)


@pytest.mark.parametrize(
    ("field", "value"),
    [("yarn", 0.1), ("height", 0.0), ("fiber", 0.01), ("roughness", -1.0), ("roughness", 0.51)],
)
def test_what_is_no_fabric_gets_a_sentence(field, value):
    with refused(f"indenter.{field}"):
        ff.Fabric(**{field: value})

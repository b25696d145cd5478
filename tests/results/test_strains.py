"""The Green-Lagrange strain of a result, against known deformation gradients."""

from dataclasses import replace

import numpy as np
import pytest

from fefinger.geometry.voigt import logarithmic


def test_a_result_of_solid_has_the_green_lagrange_strain_of_its_deformation(synthetic):
    shape = synthetic.strain.shape
    gradient = 0.3 * np.random.default_rng(1).normal(size=shape)
    gradient[0] = 0.0
    gradient[0, 0, 0, 1] = 0.8  # simple shear: E_xy = 0.4, E_yy = 0.32 and nothing else
    own = replace(synthetic.response, mechanics="solid", strain=logarithmic(gradient))
    found = replace(synthetic, response=own).green_lagrange
    f = np.eye(3) + gradient
    assert found == pytest.approx((np.swapaxes(f, -1, -2) @ f - np.eye(3)) / 2, abs=1e-12)
    assert found[0, 0] == pytest.approx(np.array([[0, 0.4, 0], [0.4, 0.32, 0], [0, 0, 0]]))


def test_small_strain_is_no_green_lagrange_strain(synthetic):
    assert synthetic.response.mechanics == "linear"
    assert synthetic.green_lagrange is None
    unasked = replace(synthetic.response, mechanics="solid", strain=None)
    assert replace(synthetic, response=unasked).green_lagrange is None

"""Principal values of symmetric tensors, against LAPACK."""

import numpy as np
import pytest

from fefinger.support.tensors import extremes


def tensors(values):
    """Return tensors (n, 3, 3) of these principal values in random directions."""
    turns = np.linalg.qr(np.random.default_rng(3).normal(size=(200, 3, 3)))[0]
    return (turns * np.asarray(values)) @ np.swapaxes(turns, 1, 2)


@pytest.mark.parametrize("apart", [1.0, 0.1, 1e-2, 1e-4, 1e-8, 0.0])
@pytest.mark.parametrize("size", [1e-20, 1.0, 1e6])
def test_extremes_are_the_principal_values_however_close_two_of_them_are(apart, size):
    for values in ([-1.0, -1.0 + apart, 2.0], [-2.0, 1.0 - apart, 1.0], [1.0, 1.0, 1.0 + apart]):
        given = size * tensors(values)
        low, high = extremes(given.reshape(2, 100, 3, 3))
        expected = np.linalg.eigvalsh(given).reshape(2, 100, 3)
        np.testing.assert_allclose(low, expected[..., 0], rtol=0, atol=2e-14 * size)
        np.testing.assert_allclose(high, expected[..., 2], rtol=0, atol=2e-14 * size)


def test_extremes_of_nothing_and_of_diagonal_tensors():
    assert extremes(np.zeros((0, 3, 3)))[0].shape == (0,)
    low, high = extremes(np.stack([np.zeros((3, 3)), np.diag([3.0, -1.0, 0.5])]))
    assert low == pytest.approx([0.0, -1.0], abs=1e-14)
    assert high == pytest.approx([0.0, 3.0], abs=1e-14)

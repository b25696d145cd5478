"""Work of the stress of one depth on the deformation of another."""

from typing import cast

import numpy as np
import pytest

from fefinger.fem.hyperelastic.continuum import Continuum
from fefinger.mechanics.press.elastic_press import work_ratios
from fefinger.support.arrays import Array


DEPTH = 0.5 * np.linspace(0.0, 1.0, 21) ** 2


class Bar:
    """A bar of unit length and section, its stretch as state: closed forms of all it does."""

    def stress(self, stretch: Array) -> tuple[Array, Array]:
        """Second Piola-Kirchhoff stress of an incompressible neo-Hookean solid, pushed."""
        return -(1 - stretch**-3), np.zeros(1)

    def weighted_strain(self, stretch: Array) -> Array:
        """Green-Lagrange strain, times a volume of 1."""
        return -(stretch**2 - 1) / 2


BAR = cast(Continuum, Bar())
"""It has the two methods of a body that are called."""


def test_the_ratios_of_a_bar_are_those_of_its_stretches() -> None:
    stretch = 1 - DEPTH
    force = stretch**-2 - stretch
    ratio = work_ratios(BAR, list(stretch[:, None]), DEPTH, force)
    exact = stretch / stretch[:, None]  # F = stretch S, so K(a, d) / F(a)
    above = np.triu_indices(len(DEPTH), 1)
    touched = above[0] > 0
    rows, columns = above[0][touched], above[1][touched]
    assert ratio[rows, columns] == pytest.approx(exact[rows, columns], abs=1e-5)
    assert np.array_equal(ratio.diagonal(), np.ones(len(DEPTH)))
    assert ratio[columns, rows] == pytest.approx(2 - ratio[rows, columns], abs=1e-12)


def test_where_no_contact_is_resolved_the_first_resolved_depth_stands_for_it() -> None:
    stretch = 1 - DEPTH
    force = np.where(DEPTH < DEPTH[3], 0.0, stretch**-2 - stretch)
    ratio = work_ratios(BAR, list(stretch[:, None]), DEPTH, force)
    assert np.array_equal(np.triu(ratio[:3, :3]), np.triu(np.ones((3, 3))))
    np.testing.assert_allclose(ratio[:3, 4:], np.tile(ratio[3, 4:], (3, 1)), rtol=1e-12)
    assert np.isfinite(ratio).all()

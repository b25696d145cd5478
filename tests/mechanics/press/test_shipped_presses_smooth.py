"""Shipped presses at their deepest: the skin lies flat on the plate, its pressure is smooth.

Two things that a press with buckled facets does not do, though all of its weighted gaps are zero.
"""

from functools import cache

import numpy as np
import pytest

import fefinger as ff
from fefinger.fem.contact.deformed_gap import ContactSurface, contact_surface
from fefinger.mechanics.press import depth_table
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.press.tabulated_press import METHOD
from fefinger.support.arrays import Array, Flags
from fefinger.support.progress import Stages


SUBJECTS = ("a.h.", "d.p.", "d.s.", "p.w.")


@cache
def deepest(subject: str, mesh: str) -> tuple[ContactSurface, Array, Array, Flags]:
    """Return the contact of a shipped press by a plate, the distance at its points, its pressure.

    And which facets are closed: all three corners bear pressure.
    """
    scene = ff.Scene(
        finger=ff.Finger.subject(subject, resolution=mesh),
        indenter=ff.Flat(30),
        motion=ff.Ramp(60, 1.0, corner=0.0),
        ask=ff.Ask(fields=False),
    )
    press = Press.of(scene, METHOD, Stages(), mechanics="pressed", notes=())
    source = press.mesh.source_sha256
    (path,) = depth_table.shipped(depth_table.key(scene.finger, scene.indenter, source))
    table, body = depth_table.read(path), press.body
    contact = contact_surface(body.space, body.pad, body.normals, press.obstacle, table.reach)
    values = table.unknowns(table.modes.amplitudes[len(table.depth) - 1], body.space.n_unknowns)
    distance, _ = press.obstacle.implicit(contact.deformed(values), table.deepest)
    pressure, owner = table.pressure[-1], contact.on.owner
    closed = ((owner >= 0) & (pressure[owner] > 0)).all(axis=1)
    return contact, distance, pressure, closed


@pytest.mark.parametrize("mesh", ["coarse", "standard"])
@pytest.mark.parametrize("subject", SUBJECTS)
def test_closed_facets_lie_flat_on_the_plate(subject: str, mesh: str):
    contact, distance, _, closed = deepest(subject, mesh)
    apart = (distance / contact.sizes)[closed]
    assert closed.sum() > 50
    assert np.sqrt((apart**2).mean()) < 0.01
    assert np.abs(apart).max() < 0.15


@pytest.mark.parametrize("subject", ["a.h.", "d.s."])
def test_the_pressure_of_a_vertex_is_that_of_the_smooth_pressure_around_it(subject: str):
    """Of a quadratic surface fitted to two rings of vertices around it, without itself.

    Where facets are large, far from first touch, a tenth of the largest pressure falls to none
    within two of them.
    """
    contact, _, pressure, closed = deepest(subject, "standard")
    at = contact.at_rest[: len(contact)]
    rings = [set() for _ in at]
    for corners in contact.on.owner[closed]:
        for corner in corners:
            rings[corner] |= set(corners.tolist()) - {corner}
    at_rim = set(contact.on.owner[~closed].ravel().tolist())
    off = []
    for vertex, ring in enumerate(rings):
        near = sorted(ring.union(*(rings[other] for other in ring)) - {vertex}) if ring else []
        light = pressure[near].mean() < 0.1 * pressure.max() if near else True
        if vertex in at_rim or len(near) < 9 or light:
            continue
        place = at[near] - at[vertex]
        place = place @ np.linalg.svd(place, full_matrices=False)[2][:2].T
        basis = np.column_stack([np.ones(len(near)), place, place**2, place[:, :1] * place[:, 1:]])
        smooth = np.linalg.lstsq(basis, pressure[near], rcond=None)[0][0]
        off.append((pressure[vertex] - smooth) / pressure[near].mean())
    assert len(off) > 100
    assert np.sqrt(np.mean(np.square(off))) < 0.1

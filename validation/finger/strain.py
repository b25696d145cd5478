"""Strain at the end organs of a finger on two meshes: recovered, and as it stands in the cells."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cache, partial

import numpy as np
from fefinger.validation.case import Case, Expected, Noted
from fefinger.validation.problems import published
from scipy import sparse

from fefinger.contact.complementarity import Complementarity
from fefinger.fem.body import body, reduce
from fefinger.fem.contact.patch import patch
from fefinger.fem.elements.probe import recovered_strain_at, strain_at
from fefinger.mechanics.press import placement
from fefinger.mechanics.press.mesh_limits import refinement_location
from fefinger.mechanics.press.problem import fixed_facets, tissues
from fefinger.mechanics.press.sites import central_sites
from fefinger.mesh.store import load_or_build
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.support.arrays import Array


DEPTH = 1.0  # mm
INDENTERS: dict[str, Indenter] = {"plate at 30 degrees": Flat(30), "ball of 5 mm": Sphere(5.0)}


@cache
def strains(resolution: str, name: str) -> Array:
    """Return the strain (2, 4, 6) at the central end organs, recovered and in the cells."""
    scene = replace(published.load("flat-press"), indenter=INDENTERS[name])
    finger = replace(scene.finger, resolution=resolution)
    mesh = load_or_build(finger, half=True, touch=refinement_location(scene.indenter))
    whole = body(mesh, tissues(finger), fixed_facets(finger))
    touch = placement.obstacle(scene.indenter, whole)
    points = central_sites(scene.ask, scene.finger.pulp, touch.origin, touch.axis).points
    probes = (
        recovered_strain_at(whole.space, points, whole.planes),
        strain_at(whole.space, points, whole.planes),
    )
    on_pad = patch(whole.space, whole.pad, whole.normals, touch, 1.25 * DEPTH)
    small = reduce(whole, on_pad, sparse.vstack(probes).tocsr())
    pressure = Complementarity(small.flexibility).solve(on_pad.gap - DEPTH * on_pad.projected)
    return np.asarray(small.strain_operator @ pressure).reshape(2, len(points), 6)


def apart(name: str) -> Noted:
    """Return by how much the two meshes differ in %, RMS over the organs, recovered."""
    coarse, standard = (strains(resolution, name) for resolution in ("coarse", "standard"))
    size = np.linalg.norm(standard, axis=2)
    each = 100 * np.linalg.norm(coarse - standard, axis=2) / size
    recovered, cells = np.sqrt(np.mean(each**2, axis=1))
    return Noted(float(recovered), f"As it stands in the cells: {cells:.2g} %.")


def cases() -> Iterator[Case]:
    """Yield the cases on mesh dependence of the strain at the end organs."""
    for name, limit in zip(INDENTERS, (1.5, 3.0), strict=True):
        title = f"{name}: strain at the end organs, coarse against standard mesh, RMS"
        source = "the mesh of half the cell length"
        reason = "less than what the strain as it stands in the cells differs by"
        yield Case(title, partial(apart, name), Expected(0.0, limit, "%"), source, reason=reason)

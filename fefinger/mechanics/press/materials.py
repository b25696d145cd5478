"""Materials of each region of the mesh, as arguments of the finite elements.

Soft tissue, and bone and nail that are rigid and fixed, elastic, or left out.
"""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from fefinger.fem.elements.forms import Elastic
from fefinger.fem.hyperelastic.load_path import Series
from fefinger.fem.hyperelastic.material import Material, material_of
from fefinger.geometry.finger_mesh import BONE, SKIN, FingerMesh
from fefinger.laws import LAWS
from fefinger.scene.finger import Finger
from fefinger.scene.tissue import Hard


NAIL = 4
"""Region of the skin under an elastic nail; other regions are those of the mesh."""


def elastic(finger: Finger) -> dict[int, Elastic]:
    """Return the elasticity of the regions that are hard and not rigid."""
    parts = {BONE: finger.bone, NAIL: finger.nail}
    return {
        region: Elastic(part.modulus, part.poisson)
        for region, part in parts.items()
        if isinstance(part, Hard)
    }


def fixed_facets(finger: Finger) -> tuple[str, ...]:
    """Return the facets that do not move."""
    bone = "bone-cut" if isinstance(finger.bone, Hard) else "bone"
    nail = ("nail",) if finger.nail is None else ()
    return (bone, *nail, *(("cut",) if finger.cut == "fixed" else ()))


def with_nail(finger: Finger, mesh: FingerMesh) -> FingerMesh:
    """Return the mesh with an elastic nail: the skin that lies nearest to its facets."""
    if not isinstance(finger.nail, Hard):
        return mesh
    skin = np.flatnonzero(mesh.region == SKIN)
    outside = [mesh.points[mesh.facets[name]].mean(axis=1) for name in ("nail", "pad")]
    _, nearest = cKDTree(np.concatenate(outside)).query(mesh.points[mesh.cells[skin]].mean(axis=1))
    region = mesh.region.copy()
    region[skin[nearest < len(outside[0])]] = NAIL
    return replace(mesh, region=region)


def tissues(finger: Finger) -> dict[int, Elastic]:
    """Return the relaxed elasticity of the regions that deform."""
    layers = {1: finger.skin, 2: finger.subcutaneous}
    soft = {region: Elastic(layer.modulus, layer.poisson) for region, layer in layers.items()}
    return soft | elastic(finger)


def materials(finger: Finger) -> dict[int, Material]:
    """Return the relaxed materials at finite strain of the regions that deform."""
    by_region = {region: material_of(each) for region, each in tissues(finger).items()}
    for region, layer in ((1, finger.skin), (2, finger.subcutaneous)):
        law, soft = LAWS[layer.law], by_region[region]
        by_region[region] = replace(soft, law=law, values=layer.law_values)
    return by_region


def relaxations(finger: Finger) -> dict[int, Series]:
    """Return the Prony series of the soft regions, by region."""
    layers = {1: finger.skin.prony, 2: finger.subcutaneous.prony}
    series = {region: prony or finger.prony for region, prony in layers.items()}
    return {
        region: Series(np.array(prony.weights), np.array(prony.v))
        for region, prony in series.items()
    }

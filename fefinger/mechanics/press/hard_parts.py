"""Bone and nail of a meshed finger: rigid and fixed, elastic, or left out."""

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from fefinger.fem.elements.forms import Elastic
from fefinger.geometry.finger_mesh import BONE, SKIN, FingerMesh
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

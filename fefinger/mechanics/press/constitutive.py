"""Constitutive laws of each region of the mesh, as arguments of the finite elements."""

import numpy as np

from fefinger.fem.elements.forms import Elastic
from fefinger.fem.hyperelastic.laws import Law, law, neo_hookean
from fefinger.fem.hyperelastic.load_path import Series
from fefinger.mechanics.press.hard_parts import elastic
from fefinger.scene.finger import Finger


def tissues(finger: Finger) -> dict[int, Elastic]:
    """Return the relaxed elasticity of the regions that deform."""
    layers = {1: finger.skin, 2: finger.subcutaneous}
    soft = {region: Elastic(layer.modulus, layer.poisson) for region, layer in layers.items()}
    return soft | elastic(finger)


def laws(finger: Finger) -> dict[int, Law]:
    """Return the relaxed hyperelastic laws of the regions that deform."""
    layers = {1: finger.skin, 2: finger.subcutaneous}
    small_strain = tissues(finger)
    by_region = {
        region: neo_hookean(small_strain[region]) for region in small_strain.keys() - layers.keys()
    }
    for region, layer in layers.items():
        by_region[region] = law(layer.law, small_strain[region], layer.exponent, layer.share)
    return by_region


def relaxations(finger: Finger) -> dict[int, Series]:
    """Return the Prony series of the soft regions, by region."""
    layers = {1: finger.skin.prony, 2: finger.subcutaneous.prony}
    series = {region: prony or finger.prony for region, prony in layers.items()}
    return {
        region: Series(np.array(prony.weights), np.array(prony.v))
        for region, prony in series.items()
    }

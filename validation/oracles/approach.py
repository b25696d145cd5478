"""Exact contact of a paraboloid with a layered body at a given approach.

`indentation.py` solves it for a contact radius. Lengths in mm.
"""

import math

from scipy.optimize import brentq

from fefinger.theory.contact import elastic
from fefinger.theory.contact.indentation import Contact, LayeredBody, paraboloid


def paraboloid_at(body: LayeredBody, radius: float, *, depth: float) -> Contact:
    """Solve the contact of a rigid paraboloid at an approach of `depth` mm, by a root in a.

    ValueError as `indentation.paraboloid`.
    """
    elastic.require_positive("paraboloid", radius=radius, depth=depth)
    guess = min(radius, math.sqrt(radius * depth))
    widest = radius * (1 - 1e-12)

    def excess(log_a: float) -> float:
        contact = paraboloid(body, radius, contact_radius=min(math.exp(log_a), widest))
        return math.log(contact.depth / depth)

    low, high = math.log(guess) - 0.7, math.log(guess) + 0.7
    # On a thin layer a tends to twice the Hertz value; under a stiff skin it falls far below it.
    while excess(low) > 0:
        low -= 0.7
    while excess(high) < 0:
        if high >= math.log(widest):
            raise ValueError(
                "paraboloid: expected a depth whose contact is at most as wide as the radius "
                f"{radius:g} mm (small strain), received {depth:g}"
            )
        high += 0.7
    a = math.exp(brentq(excess, low, high, xtol=1e-13, rtol=1e-13))
    return paraboloid(body, radius, contact_radius=min(a, widest))

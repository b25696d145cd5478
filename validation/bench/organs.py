"""As many end organs as a fingertip has, for steps of a finger in a loop."""

import numpy as np

from fefinger.results.records import Sites


COUNT = 1000


def crowd(central: Sites) -> Sites:
    """Return COUNT end organs at random places around the first of the central ones."""
    rng = np.random.default_rng(1)
    places = rng.uniform(-0.4, 0.4, (COUNT, 3)) * [1.0, 1.0, 0.25]
    return Sites(
        np.repeat(central.points[:1], COUNT, axis=0) + places,
        np.repeat(central.normals[:1], COUNT, axis=0),
        np.repeat(central.depths[:1], COUNT),
        ("SAI",) * COUNT,
    )

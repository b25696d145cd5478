"""Names and parameters of the hyperelastic laws; `fem/hyperelastic/laws.py` has their equations."""

SHARES = {"neo-hookean": 1.0, "mooney-rivlin": 0.5, "demiray": 1.0, "veronda-westmann": 2.0}
"""Default fraction of the shear modulus that the first invariant I1 carries, by law."""

EXPONENTIAL = ("demiray", "veronda-westmann")
"""Laws that stiffen exponentially; they need an exponent."""

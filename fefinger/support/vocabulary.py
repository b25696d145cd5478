"""The hyperelastic laws by name; `fem/laws.py` is their form, `energy.py` what they store."""

SHARES = {"neo-hookean": 1.0, "mooney-rivlin": 0.5, "demiray": 1.0, "veronda-westmann": 2.0}
"""Part of the shear modulus that the first invariant carries, where the tissue does not say."""

EXPONENTIAL = ("demiray", "veronda-westmann")
"""Laws that stiffen exponentially and need an exponent."""

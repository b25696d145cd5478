"""Names that a scene chooses from, each with its one home here.

The neural and the finite-element rooms hold what the names do: `neural/endorgans.py`,
`neural/drives.py`, `neural/generators.py`, `neural/units.py` and `fem/hyperelastic/laws.py`.
"""

TYPES = ("SAI", "SAII", "FAI", "FAII")
"""Types of afferent units: slowly and fast adapting, of small and of large receptive fields."""

DRIVES = ("compressive", "tensile", "tangent", "energy", "von_mises")
"""Parts of the strain at an end organ that may move it."""

GENERATORS = ("saturating", "linear")
"""Generator currents as functions of the end organ's output, the default first."""

RULES = ("mean", "max", "first")
"""How the generator currents of a unit's end organs meet.

"mean": the mean current on one membrane, the spatial summation of generator current. "max": at
every time the largest one on one membrane. "first": a membrane for each branch; the first to fire
fires the unit and its impulse invades the others, which take over its state (that branches of SAI
units reset each other: Lesniak et al. 2014, doi:10.7554/eLife.01488, and PMC4332704). It costs one
integration per branch, the others one per unit. With one input to all branches the three agree.
"""

LONGEST_RUN = 3600.0
"""s that spikes are computed for at once: an hour is 72 million steps of every membrane."""

SHARES = {"neo-hookean": 1.0, "mooney-rivlin": 0.5, "demiray": 1.0, "veronda-westmann": 2.0}
"""Hyperelastic laws, and the part of the shear modulus that the first invariant carries where the
tissue has no share of its own."""

EXPONENTIAL = ("demiray", "veronda-westmann")
"""Laws that stiffen exponentially and need an exponent."""

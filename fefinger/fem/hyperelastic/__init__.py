"""Finite strain: hyperelastic laws, elements, equilibrium in contact, and its path through time.

material.py                      a law with its moduli, and its stress and moduli at a point
continuum.py, element_kernels.py    the body: residual and tangent of its elements
linearized.py, newton.py         the factored tangent, and equilibrium in contact by it
iterate.py                       the error of an iterate, and the acceleration of the iteration
stored_energy.py                 the strain energy, for pictures
load_path.py                     all load steps, with the relaxing stress; `state.py`: one of them
"""

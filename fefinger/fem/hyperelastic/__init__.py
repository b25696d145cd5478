"""Finite strain: hyperelastic laws, kernels, equilibrium and the path of the load."""

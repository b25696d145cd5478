"""Frictionless contact: obstacles, gaps, complementarity, and its viscoelastic history."""

"""Finite elements on tetrahedra: spaces and forms, solution, contact, time, fields at points."""

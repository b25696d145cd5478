"""Closed-form and semi-analytical solutions, independent of the finite elements that they check."""

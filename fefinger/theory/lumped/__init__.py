"""Lumped finger of the source document: a nonlinear spring with stress relaxation."""

"""Fingers that are stepped one instant at a time."""

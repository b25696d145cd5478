"""Closed forms in numpy and scipy: the oracles that the rest of fefinger is checked against."""

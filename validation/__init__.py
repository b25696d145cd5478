"""Validation: each suite is a file that compares fefinger with something independent of it.

A source such as "section 2.3, recomputed" is a number that the thesis states there, or that follows
from what it prints, computed again without fefinger and before it.
"""

"""The proofs: each suite is a file that compares fefinger with something independent of it.

A source such as "recomputed A5-3" names an item of the recomputation of the thesis (A) and of exact
contact theory (B) that was made without fefinger, before it: A5 claims, A6 errors of the print, B1
half-space, B2 ellipse, B3 punches, B5 viscoelastic contact, B6 layer, B7 stack.
"""

"""The proofs: each suite is a file that compares fefinger with something independent of it."""

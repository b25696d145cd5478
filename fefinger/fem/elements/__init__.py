"""Finite-element spaces, forms, assembly, and fields read back from them."""

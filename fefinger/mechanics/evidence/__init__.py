"""Measured error and cost of each mechanics, and the rules that read them."""

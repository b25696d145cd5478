"""Sparse factorizations, iterative solvers and their threads."""

"""Validation of sliding and friction."""

"""Closed forms and synthetic records that suites and tests compare the package with."""

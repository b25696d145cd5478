"""Afferents of the family `recorded` against published recordings: fitted, and predicted."""

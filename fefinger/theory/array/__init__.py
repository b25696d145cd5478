"""Tactile array sensor of the source document, and parameter fits to its readings."""

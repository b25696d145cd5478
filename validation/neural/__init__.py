"""Suite `neural`: membranes, end organs and afferents against their equations and tables."""

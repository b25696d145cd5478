"""Geometry without a mesher: indenter profiles, the mesh record, surface files and sections."""

"""Shapes that need no mesher: profiles of indenters, meshes as records, surfaces and sections."""

"""The lumped finger of the source document: a nonlinear spring that relaxes."""

"""Finger meshes: shapes, building with pytetwild, symmetric halves, files and the store."""

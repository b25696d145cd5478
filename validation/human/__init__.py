"""The default finger against what was measured on people."""

"""Conversion between internal and reported units: kPa mm² is mN, reported forces are in N."""

NEWTON_PER_MILLINEWTON = 1e-3

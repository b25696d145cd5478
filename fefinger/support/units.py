"""The one conversion between the units inside and outside: kPa mm² is mN, forces are told in N."""

NEWTON_PER_MILLINEWTON = 1e-3

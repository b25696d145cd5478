"""Numbers that the family `recorded` does not reach: what it gives, and why."""

MISSES: dict[str, tuple[float, str]] = {}
"""By the name of a case: the known value, and the reason."""

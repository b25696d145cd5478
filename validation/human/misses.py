"""Numbers that the default finger does not reach: what it gives, and why."""

REASONS: dict[str, str] = {}

MISSES: dict[str, tuple[float, str]] = {}

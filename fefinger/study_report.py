"""The report."""


def html(study: object) -> str:
    """Return."""
    return "x"

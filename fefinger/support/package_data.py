"""Access to the reports that are installed with the package, through importlib.resources."""

from importlib import resources


def report(name: str) -> str:
    """Text of a report that validation or a benchmark last produced."""
    return resources.files("fefinger.reports").joinpath(name).read_text(encoding="utf-8")

"""Data that is installed with the package: meshes and reports, read through importlib.resources."""

from importlib import resources


def report(name: str) -> str:
    """Return the text of a report that validation or a benchmark last produced."""
    return resources.files("fefinger.reports").joinpath(name).read_text(encoding="utf-8")

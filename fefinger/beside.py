"""Processes of Python beside this one, which import what it does."""

import os
import sys


def command(*words: str) -> list[str]:
    """Return the command of one: this Python, that takes nothing from the folder it starts in."""
    return [sys.executable, "-P", *words]


def environment() -> dict[str, str]:
    """Return its environment: this one's, with what this process imports from."""
    path = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
    return {**os.environ, "PYTHONPATH": path}

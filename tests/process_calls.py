"""Functions that tests have called in child processes, which import them by this name."""

import os
import time

from fefinger.scene.indenters import INDENTERS


def square(number: float) -> float:
    """Return the square."""
    return number * number


def process(_: object) -> int:
    """Return the process that this runs in."""
    return os.getpid()


def end_for_odd(number: int) -> dict[str, list]:
    """End the process with status 3 for an odd number."""
    if number % 2:
        os._exit(3)
    return {"rows": []}


def fail(number: float) -> float:
    """Raise an error that names the number."""
    message = f"number {number}"
    raise ValueError(message)


def print_and_sleep(seconds: float) -> None:
    """Print where an answer would go, then sleep."""
    print("a print", flush=True)
    time.sleep(seconds)


def read(file: str) -> int:
    """Read a file or a pipe to its end, and return how long it is."""
    with open(file) as opened:
        return len(opened.read())


def kinds(_: object) -> list[str]:
    """Return the kinds of indenters that this process knows."""
    return list(INDENTERS)

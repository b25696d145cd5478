"""The command line: its commands, error messages and exit status.

Exit status: 0 done, 1 the answer failed its check, 2 invalid input, 130 interrupted. The answer
alone goes to standard output; progress, warnings and errors go to standard error.
"""

import errno
import os
import sys
from collections.abc import Callable
from contextlib import suppress

import click

from fefinger.commands.calibrate import calibrate, fit
from fefinger.commands.console import DONE, FAILED, UNUSABLE
from fefinger.commands.resources import cache, mesh, scenes
from fefinger.commands.run import explain, live, view
from fefinger.commands.run import run as run_scene
from fefinger.commands.spikes import field, spikes
from fefinger.commands.study import study
from fefinger.commands.validate import bench, validate
from fefinger.support import VERSION
from fefinger.support.atomic_write import FULL, write_error
from fefinger.support.checks import ConvergenceError, InputError, address_space, printable
from fefinger.support.compiled import notice
from fefinger.support.interrupt import INTERRUPTED, MESSAGE
from fefinger.support.processes import threads


LEAST_MEMORY = 800
"""MB of address space below which compiled libraries end the process or wait forever."""

NO_ROOM = "failed to map segment"
"""Words of the loader of glibc where there is no memory for a library."""


def run(arguments: list[str]) -> int:
    """Run the command line and return its exit status."""
    # Figures are drawn without a window, and matplotlib refuses the name of a window it lacks.
    os.environ.pop("MPLBACKEND", None)
    try:
        _check_memory()
        threads()  # numba takes a wrong number for its own, or ends with a traceback
        status = cli.main(args=arguments, prog_name="fefinger", standalone_mode=False)
    except (KeyboardInterrupt, click.Abort):
        _say(MESSAGE)
        return INTERRUPTED
    except click.ClickException as error:
        vars(error)["message"] = printable(error.message)  # it may quote a word of any length
        _unless_full(error.show)
        return error.exit_code
    except Exception as error:
        status, sentence = _failure(error)
        if not sentence:
            raise
        _say(sentence)
        return status
    if notice():
        _say(f"note: {notice()}")
    return int(status or DONE)


def _check_memory() -> None:
    """Raise InputError where the address space is limited to less than LEAST_MEMORY."""
    if address_space() < LEAST_MEMORY:
        raise InputError(
            f"memory: expected an address space of at least {LEAST_MEMORY} MB, received a limit "
            f"of {address_space():.0f} MB; raise it (ulimit -v)"
        )


def _failure(error: Exception) -> tuple[int, str]:
    """Return the exit status of an error and its sentence; "" for a bug of fefinger."""
    if isinstance(error, InputError):
        return UNUSABLE, f"error: {error}"
    if isinstance(error, ConvergenceError):
        return FAILED, f"failed: {error}"
    if isinstance(error, OSError) and error.errno in FULL:
        return UNUSABLE, f"error: {write_error(error, error.filename)}"
    if (
        isinstance(error, MemoryError)
        or getattr(error, "errno", None) == errno.ENOMEM
        or (isinstance(error, ImportError) and NO_ROOM in str(error))
    ):
        return FAILED, (
            "failed: memory ran out; close other programs, raise the limit (ulimit -v), or ask for "
            "a coarser mesh (finger.resolution)"
        )
    return FAILED, ""


def _say(sentence: str) -> None:
    """Print a line on standard error, unless that is full or closed too."""
    _unless_full(lambda: click.echo(sentence, err=True))


def _unless_full(write: Callable[[], object]) -> None:
    """Write to standard error, and close streams that are full.

    Else Python writes to them when it ends, and exits with 120.
    """
    with suppress(OSError):
        write()
    for name in ("stdout", "stderr"):
        try:
            getattr(sys, name).flush()
        except OSError:
            setattr(sys, name, open(os.devnull, "w"))


SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100, "show_default": True}


@click.group(context_settings=SETTINGS)
@click.version_option(VERSION)
def cli() -> None:
    """Simulate a touch with a finite-element fingertip: force, pressure, strain and spikes.

    SCENE is the name of a built-in scene (`fefinger scenes` lists them) or a TOML file.
    """


COMMANDS = (
    *(run_scene, explain, scenes, study, mesh, spikes, field, view, live, fit, calibrate, validate),
    *(bench, cache),
)
"""All commands, in the order of the help text."""

for command in COMMANDS:
    cli.add_command(command)

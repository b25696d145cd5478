"""The command line: group of commands, error messages and exit status.

Exit status: 0 done, 1 the answer failed its check, 2 invalid input, 130 interrupted. Standard
output holds the answer alone; progress, warnings and errors go to standard error.
"""

import click

from fefinger.commands import COMMANDS
from fefinger.commands.options import DONE, FAILED, UNUSABLE
from fefinger.support.atomic_write import FULL, write_error
from fefinger.support.checks import ConvergenceError, InputError
from fefinger.support.interrupt import INTERRUPTED, MESSAGE
from fefinger.support.version import VERSION


def run(arguments: list[str]) -> int:
    """Run the command line and return its exit status."""
    try:
        status = cli.main(args=arguments, prog_name="fefinger", standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return error.exit_code
    except InputError as error:
        click.echo(f"error: {error}", err=True)
        return UNUSABLE
    except ConvergenceError as error:
        click.echo(f"failed: {error}", err=True)
        return FAILED
    except OSError as error:
        if error.errno not in FULL:
            raise
        click.echo(f"error: {write_error(error, error.filename)}", err=True)
        return UNUSABLE
    except (KeyboardInterrupt, click.Abort):
        click.echo(MESSAGE, err=True)
        return INTERRUPTED
    return int(status or DONE)


SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100, "show_default": True}


@click.group(context_settings=SETTINGS)
@click.version_option(VERSION)
def cli() -> None:
    """Simulate a touch with a finite-element fingertip: force, pressure, strain and spikes.

    SCENE is the name of a built-in scene (`fefinger scenes` lists them) or a TOML file.
    """


for command in COMMANDS:
    cli.add_command(command)

"""Entry point of the command line: `fefinger ...` and `python -m fefinger ...`.

The commands are imported after signals are blocked: Ctrl-C would end an import with a traceback.
"""

import gc
import io
import os
import sys


def _not_begun() -> int:
    """Say that Ctrl-C came before the signals were blocked, and return the exit status."""
    sys.stderr.write("interrupted; nothing was begun\n")
    return 130


try:
    from fefinger.support.interrupt import interruptible
except KeyboardInterrupt:
    sys.exit(_not_begun())


def _open_streams() -> None:
    """Open standard streams that were closed, as by `2>&-`, and let all print what they cannot.

    What is written to closed ones is dropped. The next file would else take their number, and
    messages of libraries would go into it.
    """
    for name in ("stdin", "stdout", "stderr"):
        if getattr(sys, name) is None:
            stream = open(os.devnull, "r" if name == "stdin" else "w")
            os.set_inheritable(stream.fileno(), True)  # for the workers of a study
            setattr(sys, name, stream)
    if isinstance(sys.stdout, io.TextIOWrapper):  # bytes in the name of a file, as on stderr
        sys.stdout.reconfigure(errors="backslashreplace")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit status; by default with the process's arguments."""
    if arguments is None:
        try:
            _open_streams()
            # New objects per garbage collection: imports make 400,000 that stay, and to look
            # through them as often as by default takes a second of a run.
            collect = 20_000
            gc.set_threshold(collect)
            return interruptible(lambda: main(sys.argv[1:]))
        except KeyboardInterrupt:
            return _not_begun()
    from fefinger.commands.cli import run

    return run(arguments)


if __name__ == "__main__":
    sys.exit(main())

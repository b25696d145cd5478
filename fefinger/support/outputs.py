"""Checks of output files and folders before a computation starts."""

import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from os import PathLike
from pathlib import Path

from fefinger.support.checks import InputError
from fefinger.support.interrupt import on_end


def check_ending(path: str | PathLike[str], option: str, ending: str) -> None:
    """Raise InputError unless the file given as `option` has the suffix `ending`."""
    if Path(path).suffix.lower() != ending:
        message = f"{option}: expected a file that ends in {ending}, received {os.fspath(path)!r}"
        raise InputError(message)


def output_file(path: str | PathLike[str], option: str, ending: str = "") -> Path:
    """Check the file given as `option` and create its folder; InputError where it is unusable."""
    if ending:
        check_ending(path, option, ending)
    if os.path.isdir(path):
        message = f"{option}: expected a file, received the folder {str(path)!r}; choose another"
        raise InputError(message)
    output_folder(Path(path).parent)
    return Path(path)


def output_folder(folder: str | PathLike[str]) -> Path:
    """Create `folder` if needed and return it; InputError where files cannot be written to it."""
    if not os.fspath(folder).strip():
        raise InputError(
            "output folder: expected a name, received an empty one; write . for the current one"
        )
    path = Path(folder)
    advice = "choose another"
    if os.path.exists(path) and not os.path.isdir(path):
        message = f"output folder: expected a folder, received the file {str(path)!r}; {advice}"
        raise InputError(message)
    try:
        for each in reversed(_missing(path)):  # mkdir(parents=True) recurses
            each.mkdir(exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            pass
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"output folder: expected a folder that can be written, received {str(path)!r} "
            f"({reason}); {advice}"
        ) from None
    return path


def _missing(path: Path) -> list[Path]:
    """List a folder and those around it that do not exist, the innermost first."""
    return [each for each in (path, *path.parents) if not os.path.lexists(each)]


def keep(foreign: Sequence[str], folder: str | PathLike[str], ours: str) -> None:
    """Raise InputError where writing `ours` would replace files of another origin.

    foreign: names of these files in `folder`: the user or another command wrote them.
    """
    if foreign:
        raise InputError(
            f"output folder: {', '.join(map(repr, foreign))} in {os.fspath(folder)!r} would be "
            f"overwritten, and no {ours} of fefinger there holds it; move it away or choose "
            "another folder"
        )


@contextmanager
def output(folder: str | PathLike[str] | None) -> Iterator[Path | None]:
    """Create an output folder for the enclosed block; after an error remove it if it is empty."""
    if folder is None:
        yield None
        return
    made = _missing(Path(folder))

    def remove_empty() -> None:
        for path in made:
            with suppress(OSError, ValueError):  # something is in it, or it has no name
                path.rmdir()

    try:
        with on_end(remove_empty):
            yield output_folder(folder)
    except BaseException:  # as KeyboardInterrupt
        remove_empty()
        raise

"""An empty cache of the user, for measurements that build everything anew."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory


VARIABLE = "XDG_CACHE_HOME"


@contextmanager
def empty_cache() -> Iterator[Path]:
    """Let this process, and those it starts, have their caches in an empty folder: yield it."""
    before = os.environ.get(VARIABLE)
    with TemporaryDirectory() as folder:
        os.environ[VARIABLE] = folder
        try:
            yield Path(folder)
        finally:
            del os.environ[VARIABLE]
            if before is not None:
                os.environ[VARIABLE] = before

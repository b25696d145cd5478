"""An empty cache of the user, for measurements that build everything anew."""

import os
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from fefinger.support import cache, machine


VARIABLE = "XDG_CACHE_HOME"


@contextmanager
def empty_cache(*shared: Path) -> Iterator[Path]:
    """Let this process, and those it starts, have their caches in an empty folder: yield it.

    `shared` files and folders of the user's cache are in it too.
    """
    before = os.environ.get(VARIABLE)
    with TemporaryDirectory() as folder:
        for path in shared:
            link = Path(folder, "fefinger", path.name)
            link.parent.mkdir(exist_ok=True)
            link.symlink_to(path)
        os.environ[VARIABLE] = folder
        try:
            yield Path(folder)
        finally:
            del os.environ[VARIABLE]
            if before is not None:
                os.environ[VARIABLE] = before


def only_meshes() -> AbstractContextManager[Path]:
    """Let the cache have meshes and the speed of the machine alone."""
    shared = cache.root() / "meshes", machine.kept_path().parent
    for folder in shared:
        folder.mkdir(parents=True, exist_ok=True)
    return empty_cache(*shared)

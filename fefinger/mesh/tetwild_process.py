"""pytetwild in a process of its own: `python -m fefinger.mesh.tetwild_process FOLDER`.

In ours it would hold the interpreter, take Ctrl-C for itself, print, and end us where it fails.
"""

import sys
from pathlib import Path

import numpy as np

from fefinger.support.interrupt import unblock


GIVEN, FOUND = "given.npz", "found.npz"
"""Files of the folder: the arguments of `pytetwild.tetrahedralize`, and what it returns."""


def main(folder: Path) -> None:
    """Mesh what a folder holds."""
    import pytetwild

    with np.load(folder / GIVEN) as given:
        arguments = {key: given[key] if given[key].ndim else given[key].item() for key in given}
    vertices, cells = pytetwild.tetrahedralize(
        **arguments, coarsen=True, disable_filtering=True, num_threads=1
    )
    np.savez(folder / FOUND, vertices=vertices, cells=cells)


if __name__ == "__main__":
    unblock()
    main(Path(sys.argv[1]))

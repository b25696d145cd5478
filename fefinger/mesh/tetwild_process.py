"""pytetwild in a process of its own: `python -m fefinger.mesh.tetwild_process FOLDER`.

In the caller's process it would hold the interpreter lock, catch Ctrl-C, print, and on failure end
the process.
"""

import sys
from pathlib import Path

import numpy as np

from fefinger.support.interrupt import unblock


ARGUMENTS, MESH = "arguments.npz", "mesh.npz"
"""Files of the folder: the arguments of `pytetwild.tetrahedralize`, and its result."""


def main(folder: Path) -> None:
    """Mesh the surfaces in a folder; write the mesh there."""
    import pytetwild

    with np.load(folder / ARGUMENTS) as arrays:
        arguments = {key: arrays[key] if arrays[key].ndim else arrays[key].item() for key in arrays}
    vertices, cells = pytetwild.tetrahedralize(
        **arguments, coarsen=True, disable_filtering=True, num_threads=1
    )
    np.savez(folder / MESH, vertices=vertices, cells=cells)


if __name__ == "__main__":
    unblock()
    main(Path(sys.argv[1]))

"""Whether VTK can draw here, and an empty plotter."""

import functools
import os
import subprocess
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

from fefinger.support import processes
from fefinger.support.checks import InputError, address_space


if TYPE_CHECKING:
    from pyvista import Plotter


PROBE = """
from vtkmodules import vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(vtkRenderer())
window.Render()
"""

LEAST_MEMORY = 2000
"""MB of address space below which VTK or the renderer of Mesa may end the process."""


@functools.cache
def renderer_lacking() -> str:
    """Return "" if VTK can draw off-screen here, else a sentence that says what is missing."""
    if address_space() < LEAST_MEMORY:
        return (
            f"The address space is limited to {address_space():.0f} MB, of which "
            f"three-dimensional pictures need {LEAST_MEMORY}; raise the limit (ulimit -v)."
        )
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with suppress(OSError, subprocess.TimeoutExpired):
        with processes.running(processes.command("-c", PROBE), **quiet) as probe:
            if probe.wait(timeout=60) == 0:
                return ""
    return (
        "No renderer for three-dimensional pictures was found; on Debian or Ubuntu install the "
        "system package libegl1 or libosmesa6."
    )


def require() -> None:
    """Raise InputError where VTK cannot draw, naming the option that needs no renderer."""
    missing = renderer_lacking()
    if missing:
        message = f"{missing} Without one, `fefinger view DIR --html FILE` works: a browser draws."
        raise InputError(message)


def plotter(
    size: tuple[int, int], columns: int = 1, *, aside: int = 0, off_screen: bool | None = True
) -> "Plotter":
    """Return a white pyvista.Plotter, `size` pixels, equal columns and one of `aside` pixels."""
    import pyvista as pv
    from vtkmodules.vtkCommonCore import vtkLogger

    # Else VTK warns on every start that there is no X server, before it takes EGL.
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_ERROR)
    made = pv.Plotter(
        off_screen=off_screen,
        window_size=list(size),
        shape=(1, columns + (aside > 0)),
        col_weights=[(size[0] - aside) // columns] * columns + [aside] * (aside > 0),
        border=False,
    )
    made.set_background("white", all_renderers=True)  # type: ignore[arg-type]  # pyvista's decorator loses self
    return made


def has_display() -> bool:
    """Return whether a window can open. Other systems than Linux are taken to have a desktop."""
    names = ("DISPLAY", "WAYLAND_DISPLAY")
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in names)

"""Pictures of a Result and of a mesh with PyVista: sections, views in space, films, windows.

The only package that imports pyvista. VTK ends the process where no renderer exists, so
`renderer_lacking` asks in another process first. `webview` makes the page that needs no renderer.
"""

from fefinger.view.pictures import draw_mesh, movie, screenshot, section_figure, section_png
from fefinger.view.renderer import renderer_lacking
from fefinger.view.window import show


__all__ = [
    "draw_mesh",
    "movie",
    "renderer_lacking",
    "screenshot",
    "section_figure",
    "section_png",
    "show",
]

"""Pictures of a Result and of a mesh: sections, views in space, films, windows.

The only package that imports pyvista. VTK ends the process where no renderer exists, so
`renderer_lacking` tries in another process first. The page of `pages.viewer` needs no renderer.
"""

from fefinger.view.pictures import draw_mesh, movie, screenshot
from fefinger.view.renderer import renderer_lacking
from fefinger.view.window import show


__all__ = [
    "draw_mesh",
    "movie",
    "renderer_lacking",
    "screenshot",
    "show",
]

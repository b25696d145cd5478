"""A finger of finite elements under an object: from a scene to the Response of a press.

problem.py                  Press: mesh, body, obstacle, end organs, as a solver sees a scene; and
                            its solved contact
small_strain.py             contact of `linear` and `condensed` through time
finite_strain.py            contact of `solid` through load steps
elastic_press.py            the table over depth of `pressed` (depth_table.py): read, or solved
tabulated_press.py          contact of `pressed`: that table along a motion
modal_press.py, frequency_response.py
                            contact with inertia of `modal`, in time and by frequency
moving_contact.py, finite_sliding.py
                            contact under a path or with friction, at small and finite strain
axisymmetric.py             `hertz` and `layered`: contacts and fields of closed formulas
layer_press.py              `layered` of any object, on a grid: its gaps in layer_gap.py, its
                            compliance and strain in layer_grid.py
reference.py                the small press that converts strain to displacement
response.py, modal_response.py    the Response, from the solved contact

The other files are parts of these: where things lie (placement, sites), in which steps
(time_steps, load_steps), what the mesh allows (mesh_limits), and what is left out (notes).
"""

"""A finger of finite elements under an object: from a scene to the Response of a press.

problem.py                       Press: mesh, body, obstacle, end organs, as a solver sees a scene
small_strain.py                  contact of `linear` and `condensed` through time
finite_strain.py                 contact of `solid` through load steps
elastic_press.py, work_ratio.py  the table of elastic solutions over depth of `pressed`: solved, or
                                 read by depth_table_store.py
tabulated_press.py               contact of `pressed`: that table along a motion
modal_press.py, harmonic.py      contact with inertia of `modal`, in time and by frequency
sliding.py, dragged.py           contact under a path or with friction, at small and finite strain
axisymmetric.py                  `hertz` and `layered`: contacts and fields of closed formulas
reference.py, finite_reference.py    the small press that converts strain to displacement
response.py, modal_response.py   the Response, from the solved contact (`history.py`)

The other files are parts of these: where things lie (placement, sites, skin, population), of what
they are made (constitutive, hard_parts), in which steps (time_steps, load_steps, modal_steps), and
what is left out (limits, notes).
"""

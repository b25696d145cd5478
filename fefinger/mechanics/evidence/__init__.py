"""Measured error and cost of each mechanics, and the rules that read them.

table.py                         the measurements, as the files of `reports/` hold them
stated_errors.py                 the error that a mechanics states of a scene; from
press_mesh.py, tradeoff.py       the measured presses next to it,
pressed_objects.py               and the objects between which it lies
carrying.py, vibration.py        what time and inertia add
force_control.py, reached_depth.py    what changes where the force is prescribed
lumped_law.py, mesh_scatter.py   the force law of `lumped`; how answers differ between meshes
small_strain_cost.py, solid_cost.py    seconds of the mechanics, and of meshes
wall_time.py, machine.py         on the cores and at the speed of this machine
"""

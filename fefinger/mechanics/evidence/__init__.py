"""Measured error and cost of each mechanics, and the rules that read them.

reports.py, table.py             the measurements, as the files of `reports/` hold them
stated_errors.py                 the error that a mechanics states of a scene; from
press_mesh.py, tradeoff.py       the measured presses next to it,
pressed_objects.py               and the objects between which it lies
carrying.py, vibration.py        what time and inertia add
force_control.py, reached_depth.py    what changes where the force is prescribed
lumped_law.py, mesh_scatter.py   the force law of `lumped`; how answers differ between meshes
solid_cost.py, machine.py        seconds of `solid`, and the speed of this machine
"""

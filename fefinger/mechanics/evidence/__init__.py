"""Measured error and cost of each mechanics, and the rules that read them.

table.py                 the measurements, as the files of `reports/` hold them
stated_errors.py         the error that a mechanics states of a scene; from
press_mesh.py            the measured presses next to it,
pressed_objects.py       the objects between which it lies, and depths under a force,
press_mesh.py         and margins, from leaving presses out
measured_tissue.py       what tissue counts as measured
tabulation_error.py, vibration.py    what time and inertia add
costs.py, machine.py     seconds of the mechanics, and of meshes, at the speed of this machine
"""

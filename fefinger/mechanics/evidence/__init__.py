"""Measured error and cost of each mechanics, and the rules that read them.

stated_errors.py    the error that a mechanics states of a scene: one rule
presses.py          measured presses, as `reports/evidence.json` holds them, and what
                    compares two of them: form, tissue and object
vibration.py        what inertia adds
costs.py            seconds of the mechanics, and of meshes
"""

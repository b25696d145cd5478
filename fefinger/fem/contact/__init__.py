"""Contact of a body with a rigid obstacle, and its viscoelastic history.

obstacle.py, travel.py           the obstacle and its heights
patch.py, deformed_gap.py        gaps of the candidate vertices: undeformed, and at finite strain
step_compiled.py                 one step in time, on the complementarity solver `lcp_compiled.py`
friction_step.py, rolling_step.py, modal_step.py    the same with friction, under a rolling plate,
                                 with inertia; `march.py`: whole motions
complementarity.py               the same problem without time: for many loads and one flexibility
contact_area.py                  the area, from the gaps around the contact
"""

"""Contact of a body of known flexibility through time; needs no mesh.

stepper.py           what every kind of contact offers: a step, its state, its failure; and `march`,
                     a whole motion of any of them; a loop of one's own calls the same steps
frictionless.py, frictional.py, inertial.py    the kinds on vertices; a rolling plate
gridded.py           the kind on a periodic grid, solved in grid_solver.py
force_control.py     the depth at which a force is borne
prony_history.py     what the past leaves, by exponentials
active_set.py, coulomb.py (coulomb_kernels.py)    the solvers of one step: complementarity, Coulomb
complementarity.py   complementarity without time: many loads, one flexibility
posed_steps.py (posed.py, pad_worlds.py, pad_gaps.py, signed_distance.py)   objects at any pose, in
                     many worlds
oscillators.py       modes of a body: through time, and harmonic with a contact that stays closed
"""

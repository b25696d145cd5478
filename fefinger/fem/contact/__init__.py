"""Contact of meshed bodies with rigid obstacles: what the room `contact` needs of the elements.

obstacle.py, travel.py           the obstacle and its heights
patch.py, deformed_gap.py (deformed_kernels.py)
                                 gaps of the candidate vertices: undeformed, and at finite strain
contact_area.py                  the area, from the gaps around the contact
"""

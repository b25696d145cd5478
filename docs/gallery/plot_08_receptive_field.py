"""
A receptive field
=================

A pin is pressed at places around one unit, and its impulses are counted.
"""

import fefinger as ff


changes = {"finger.resolution": "coarse", "motion.hold": 0.3}
field = ff.receptive_field("pin-hold", ("SAI", "FAI"), changes=changes, reach=2, spacing=1)
for kind in field.kinds:
    most, area = field.of(kind).max(), field.area(kind)
    print(f"{kind}: at most {most} impulses, half of them within {area:g} mm²")
drawn = field.figure()

"""
A receptive field
=================

A pin is pressed at places around one unit, and its impulses are counted.
"""

import fefinger as ff
from fefinger.scene import builtin


scene = builtin.load("pin-hold", {"finger.tissue": "maeno1998", "motion.hold": 0.3})
field = ff.receptive_field(scene, ("SAI", "FAI"), reach=2, spacing=1)
for kind in field.kinds:
    most, area = field.of(kind).max(), field.area(kind)
    print(f"{kind}: at most {most} impulses, half of them within {area:g} mm²")
drawn = field.figure()

"""
Pressure on the ridges of the skin
==================================

A plate on a pad with the ridges of a whorl, on exact layers that no mesh blurs. The plate rests on
the crests: their pressure is several times that of a smooth pad, under about the same force.
"""

from dataclasses import replace

import matplotlib.pyplot as plt

import fefinger as ff


smooth = ff.Scene(
    name="ridges",
    finger=ff.Finger.subject("a.h.", tissue="maeno1998"),
    indenter=ff.Flat(30),
    motion=ff.Ramp(speed=60, depth=0.6),
    ask=ff.Ask(fields=False, strain=False),
)
ridges = ff.Ridges(pitch=0.45, height=0.1, shape="concentric")
ridged = replace(smooth, finger=replace(smooth.finger, ridges=ridges))

plain, result = (ff.run(scene, mechanics="layered") for scene in (smooth, ridged))
print(f"force {plain.force[-1]:.3f} N on a smooth pad, {result.force[-1]:.3f} N on ridges")
print(f"contact area {plain.contact_area[-1]:.1f} and {result.contact_area[-1]:.1f} mm²")

pad, pressure = result.pad, result.pressure[-1]
figure, axis = plt.subplots(figsize=(5.2, 4.2))
drawn = axis.tripcolor(*pad.points[:, :2].T, pad.triangles, pressure, shading="gouraud")
axis.set(aspect="equal", xlabel="x (distal) / mm", ylabel="y (radial) / mm")
bar = figure.colorbar(drawn, label="pressure / kPa")

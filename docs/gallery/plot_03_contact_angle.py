"""
The contact angle
=================

Does a plate press harder distally or proximally of first touch? The asymmetry is the difference of
both forces over their sum. On published tissue, with the tip and bone that go with it, it is distal
at 20 degrees and mostly proximal at 40: it changes sign. On the default finger, with tissue that
is fitted to the subject and a rounder tip, it does not. The sign depends on how much stiffer the
skin is than the pulp, and on the tip. Solving this study takes an hour; here its table is read from
``reports/contact-angle.csv``, and the default finger is three scenes of a study of its own.
"""

from pathlib import Path

import fefinger.reports
import matplotlib.pyplot as plt
import pandas as pd


table = pd.read_csv(Path(fefinger.reports.__path__[0]) / "contact-angle.csv")
peaks = table[table["at"] == "peak"].groupby("case")
cases = {
    "a.h. to 1 mm": "Maeno et al. 1998, linear",
    "dandekar2003": "Dandekar et al. 2003, linear",
    "saal2017": "Saal et al. 2017, linear",
    "finite strain": "Maeno et al. 1998, solid",
}  # all on the coarse mesh

# fefinger study flat-press --over indenter.angle=20,30,40 --set motion.depth=1
#     --set motion.hold=0.2
default = {"angle": [20, 30, 40], "asymmetry": [17.4, 24.6, 22.8], "area": [42.7, 53.1, 46.8]}

fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.4), layout="constrained")
for case, label in cases.items():
    rows = peaks.get_group(case)
    angle = rows["indenter.angle_deg"]
    left.plot(angle, 100 * rows["asymmetry"], ".-", label=label)
    right.plot(angle, rows["contact_area_mm2"], ".-")
label = "default (calibrated_ah), solid, standard mesh"
left.plot(default["angle"], default["asymmetry"], "k.--", label=label)
right.plot(default["angle"], default["area"], "k.--")
left.axhline(0, color="0.7")
left.set(xlabel="angle / degrees", ylabel="asymmetry of the load / %")
right.set(xlabel="angle / degrees", ylabel="contact area / mm²")
fig.legend(loc="outside lower center", ncols=2, fontsize=9)
plt.show()

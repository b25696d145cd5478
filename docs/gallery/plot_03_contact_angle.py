"""
The contact angle
=================

A plate at 20 degrees presses harder distally of first touch, one at 40 degrees proximally. The
asymmetry is the difference of both forces over their sum; its size depends on the tissue. Solving
this study takes an hour; here its table is read from ``reports/contact-angle.csv``.
"""

from pathlib import Path

import fefinger.reports
import matplotlib.pyplot as plt
import pandas as pd


table = pd.read_csv(Path(fefinger.reports.__path__[0]) / "contact-angle.csv")
peaks = table[table["at"] == "peak"].groupby("case")
cases = {
    "a.h. to 1 mm": "tissue of Maeno et al. 1998",
    "dandekar2003": "tissue of Dandekar et al. 2003",
    "saal2017": "tissue of Saal et al. 2017",
    "finite strain": "Maeno et al., finite strain",
}

fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.4), layout="constrained")
for case, label in cases.items():
    rows = peaks.get_group(case)
    angle = rows["indenter.angle_deg"]
    left.plot(angle, 100 * rows["asymmetry"], ".-", label=label)
    right.plot(angle, rows["contact_area_mm2"], ".-")
left.axhline(0, color="0.7")
left.set(xlabel="angle / degrees", ylabel="asymmetry of the load / %")
right.set(xlabel="angle / degrees", ylabel="contact area / mm²")
fig.legend(loc="outside lower center", ncols=2, fontsize=9)
plt.show()

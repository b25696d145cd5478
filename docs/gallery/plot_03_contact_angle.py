"""
The contact angle
=================

How the angle of a plate moves the load between the tip and the pad. Solving this study takes an
hour; here its table is read from ``reports/contact-angle.csv``.
"""

from pathlib import Path

import fefinger.reports
import matplotlib.pyplot as plt
import pandas as pd


table = pd.read_csv(Path(fefinger.reports.__path__[0]) / "contact-angle.csv")
deep = table[table["at"] == "peak"]
print(sorted(deep["case"].unique()))

fig, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.4), layout="constrained")
for case, rows in deep.groupby("case"):
    angle = rows["indenter.angle_deg"]
    left.plot(angle, 100 * rows["asymmetry"], ".-", label=case)
    right.plot(angle, rows["contact_area_mm2"], ".-")
left.axhline(0, color="0.7")
left.set(xlabel="angle / degrees", ylabel="asymmetry of the load / %")
right.set(xlabel="angle / degrees", ylabel="contact area / mm²")
fig.legend(loc="outside lower center", ncols=3, fontsize=7)
plt.show()

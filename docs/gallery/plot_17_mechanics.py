"""
The mechanics compared: error against time
==========================================

Pareto front of error and time: medians over the timed scenes of ``reports/held-out.json``,
which were drawn at random.
"""

import json
from pathlib import Path

import fefinger.reports
import matplotlib.pyplot as plt
import numpy as np

import fefinger as ff
from fefinger.results.candidate import MECHANICS


report = json.loads((Path(fefinger.reports.__path__[0]) / "held-out.json").read_text())
measured = {}
for scene, taken in report["taken"].items():
    for name, each in report["errors"][scene].items():
        measured.setdefault(name, []).append((taken[name], each["force"]))

fig, axis = plt.subplots(figsize=(7, 4), layout="constrained")
for name, rows in measured.items():
    seconds, error = np.median(rows, axis=0)
    mechanics, _, mesh = name.partition(" ")
    mark = {"coarse": "v", "standard": "o", "fine": "^"}.get(mesh, "s")
    color = f"C{list(MECHANICS).index(mechanics)}"
    axis.loglog(seconds, 100 * error, mark, color=color, label=name)
axis.set(xlabel="CPU time of a first answer / s (median)", ylabel="error of the force / % (median)")
axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
plt.show()

# %%
# What the planner expects for one scene: ``fefinger explain flat-press`` prints the same.
print(ff.explain("flat-press"))

"""
A Braille letter under the finger
=================================

The letter t is pressed 1 mm and held, over a grid of SAI units: which of them fire, and how fast.
``indenter.text`` takes any letters, and ``fefinger run slide-braille`` scans a word.
"""

import fefinger as ff
from fefinger.view import spatial_figures


letter = ff.Scene(
    name="letter",
    finger=ff.Finger.subject("a.h.", tissue="maeno1998", resolution="coarse"),
    indenter=ff.Braille("t", start=-1.2),
    motion=ff.RampHold(speed=20, depth=1.0, hold=1.0),
    ask=ff.Ask(spikes=("SAI",), rel_error=0.9, population=ff.Grid(spacing=0.7, radius=3)),
)
result = ff.run(letter, mechanics="condensed")

held = result.spikes.to_pandas().query("time_s > 0.1")
rates = held.groupby("unit").size() / (result.time[-1] - 0.1)  # of units that fire at all
print("fastest units, rate in the hold / Hz:", rates.nlargest(5).round().to_dict())
shown = spatial_figures.rate_map(result)

# %%
# Two letters pass under the units. Each spike is drawn at the place that was over the unit then.
# Without ``mechanics`` layers with ridges answer: finer than this mesh, and twenty times slower.
changes = {
    "indenter.text": "go",
    "finger.ridges": None,
    "finger.resolution": "coarse",
    "motion.distance": 24,
    "ask.spikes": ["SAI"],
}
scanned = ff.run("slide-braille", changes=changes, mechanics="condensed")
events = spatial_figures.events(scanned)

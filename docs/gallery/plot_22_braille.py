"""
Braille under the finger
========================

Two letters in Braille pass under a line of units.
"""

import fefinger as ff
from fefinger.view import event_plots


changes = {
    "indenter.text": "go",
    "finger.resolution": "coarse",
    "motion.distance": 24,
    "ask.spikes": ["SAI"],
    "ask.rel_error": 0.9,
}
result = ff.run("slide-braille", changes=changes)
print(result.spikes.summary())
events = event_plots.events(result)

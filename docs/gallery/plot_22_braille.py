"""
Braille under the finger
========================

Two letters in Braille pass under a line of units.
"""

import fefinger as ff
from fefinger.scene import builtin
from fefinger.view import event_plots


scene = builtin.load(
    "slide-braille",
    {
        "indenter.text": "go",
        "finger.resolution": "coarse",
        "motion.distance": 24,
        "ask.spikes": ["SAI"],
        "ask.rel_error": 0.9,
    },
)
result = ff.run(scene)
print(result.spikes.summary())
events = event_plots.events(result)

"""
Dots that slide under the pad
=============================

A plate of raised dots is scanned at 60 mm/s. Each spike is drawn at the place on the plate that was
over the unit then: a spatial event plot. The pad has ridges, which `finger.ridges` describes.
"""

import fefinger as ff
from fefinger.view import spatial_figures


changes = {
    "motion.force": 0.3,
    "ask.pressure": False,
    "ask.population.radius": 2,
    "motion.distance": 9,
    "motion.settle": 0.1,
}
result = ff.run("slide-dots", changes=changes)
print(result.spikes.summary())
events = spatial_figures.events(result)

# %%
# Mean rates along the plate.
lines = spatial_figures.scan_lines(result)

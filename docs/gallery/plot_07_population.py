"""
A population of afferents
=========================

SAI and FAI units at their published densities, under a plate that is pressed, held and withdrawn.
"""

import fefinger as ff
from fefinger.view import spatial_figures


result = ff.run("population-press")
print(result.spikes.summary())
raster = spatial_figures.raster(result)

# %%
# Mean rates at the places of the units, over the pressure at the largest force.
rates = spatial_figures.rate_map(result)

"""
Strain inside the finger
========================

The medial section of the deformed finger, and the pressure on its pad.
"""

import fefinger as ff
from fefinger.view import figures, section_figure, spatial_figures


result = ff.run("flat-press")
section = section_figure.draw(result, field="compressive strain")

# %%
# The plate presses hardest at the tip, where it squeezes the skin against the nail.
pressure = spatial_figures.pressure_map(result)

# %%
# Strain at the four end organs under first touch.
strain = figures.site_strain(result)

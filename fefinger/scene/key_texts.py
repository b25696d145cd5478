"""One line for each key of a scene file whose record describes it in prose, for the schema.

A key that means different things in two tables has its table before it.
"""

TEXTS = {
    "indenter": "The rigid object that touches the finger; a plate unless `kind` says otherwise",
    "motion": "How the object moves: its depth or its force in time",
    "ask.population": "Places of the afferent units; one of each type under first touch without it",
    # finger
    "subject_name": "Subject of the thesis: sizes, and the tissue fitted to the curves of it",
    "skin": "The skin; keys left out are those of the tissue set",
    "subcutaneous": "The tissue between skin and bone; keys left out are those of the tissue set",
    "c": "Weights c0, c1, ... of G(t) = c0 + c1 exp(-v1 t) + ..., which add up to 1",
    "v": "Rates v1, v2, ... in 1/s, one less than the weights",
    # indenters
    "angle": "Degrees of the plate about y: 0 lies along the bone, positive against the tip side",
    "tilt": "Degrees of the plate about x, positive against the side of positive y",
    "roll": "Turn in degrees about the direction of travel: 0 lies across the finger, 90 along it",
    "radius": "Radius in mm",
    "radii": "Half axes in mm along x, y and the direction of travel",
    "at": "Place [x, y] in mm; by default the point that the 30 degree plate touches first",
    "width": "Width over all in mm",
    "indenter.corner": "Radius in mm of the rounded corners or edge",
    "period": "Distance in mm of the ridges",
    "ridge": "Width in mm of a ridge at half its height",
    "indenter.depth": "Height in mm of the ridges over the grooves",
    "shift": "Shift in mm of the pattern along the plate",
    "indenter.x": "Grid lines in mm along x",
    "indenter.y": "Grid lines in mm along y",
    "heights": "Heights in mm towards the finger, one row for each x",
    # motions
    "speed": "Speed in mm/s",
    "motion.depth": "Travel in mm after first touch",
    "loading_rate": "Rate of the force in N/s",
    "motion.force": "Force in N",
    "hold": "Rest in s after the ramp",
    "motion.corner": "Time in s over which the speed changes at a corner; 0 makes it sharp",
    "amplitude": "Amplitude, in the unit of what is moved: mm or N",
    "frequency": "Frequency in Hz",
    "cycles": "Number of whole cycles",
    "settle": "Rest in s before the sine",
    "preload": "Depth in mm at which the probe waits",
    "seconds": "Length in s",
    "held": "Rest in s at the preload before the sine, in which units adapt",
    "time": "Times in s, from 0 on and rising",
    # populations
    "ask.population.radius": "Radius in mm about first touch within which units lie",
    "densities": "Units per cm² by type, where they differ from the published ones",
    "spacing": "Distance in mm of neighbors",
    "start": "One end [x, y] in mm",
    "stop": "Other end [x, y] in mm",
    "count": "Number of places",
    "places": "List of places [x, y] in mm",
}
"""Text by key, or by table and key."""

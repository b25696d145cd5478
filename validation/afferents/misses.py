"""Numbers that the family `recorded` does not reach: what it gives, and why."""

NARROW = (
    "the strain under a pin grows with the inverse of its width: twice that of the pin 2 mm wide, "
    "to which the bands belong and whose rates lie in them. Recorded SAI under spheres and along a "
    "bar (50 Hz at its edges) fire as much for such strains as this unit does; models of TouchSim "
    "under a pin 1 mm wide fire a third as much. Small strain, by which the pin is pressed, and "
    "the elements of 0.6 mm add a fifth at 1 mm; the mean over a disc of end organs takes a tenth "
    "to a half away, and makes the edges of the bar disappear"
)

BURST = (
    "one impulse more than the models of TouchSim fire. The least weight of a release, 0.4 of that "
    "of an onset, which recorded releases require, goes with a strong onset"
)

SHALLOW = (
    "fitted together with the fall at 1.3 mm (0.34): nearer to threshold, the same loss of current "
    "takes away a larger part of the rate"
)

MISSES: dict[str, tuple[float, str]] = {
    "predicted: SAI in a hold of the pin at 0.2 mm, 1 mm wide": (15.4, NARROW),
    "predicted: SAI in a hold of the pin at 0.5 mm, 1 mm wide": (59.7, NARROW),
    "predicted: SAI in a hold of the pin at 1 mm, 1 mm wide": (129.7, NARROW),
    "predicted: SAI in a hold of the pin at 1.5 mm, 1 mm wide": (189.1, NARROW),
    "predicted: impulses of FAI at the onset of a pin, 0.7 mm at 20 mm/s": (9.0, BURST),
    "fitted: fall of the SAI rate in 12 s of a hold at 0.65 mm": (0.413, SHALLOW),
}
"""By the name of a case: the known value, and the reason."""

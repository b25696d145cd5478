"""Numbers that the family `recorded` does not reach: what it gives, and why."""

NARROW = (
    "twice what the models of TouchSim fire under this pin. Strain near a narrow pin grows faster "
    "than the stress on a half-space that drives those models, and the small strain by which pins "
    "are pressed overestimates it: at finite strain, on the tissue of the spheres, the unit fires "
    "3, 33, 65 and 104 Hz at the four depths, and twice the bands under the pin 2 mm wide"
)

BURST = (
    "two impulses more than the models of TouchSim fire. The least weight of a release, 0.4 of "
    "that of an onset, which recorded releases require, goes with a strong onset"
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
    "predicted: impulses of FAI at the onset of a pin, 0.7 mm at 20 mm/s": (10.0, BURST),
    "fitted: fall of the SAI rate in 12 s of a hold at 0.65 mm": (0.413, SHALLOW),
}
"""By the name of a case: the known value, and the reason."""

"""Numbers that the family `recorded` does not reach: what it gives, and why."""

NARROW = (
    "the strain under a pin grows with the inverse of its width: twice that of the pin 2 mm wide, "
    "to which the bands belong. Recorded SAI under spheres (fitted) grow with the strain without "
    "a limit that would hold these rates down. Models of TouchSim under a pin 1 mm wide fire a "
    "third as much. Small strain, by which the pin is pressed, adds a fifth at 1 mm; the mean over "
    "a disc of end organs takes a tenth to a half away, and makes the edges of the bar disappear"
)

WIDE = (
    "SAI under spheres (fitted) fire up to twice as much, for a strain, as the four models behind "
    "these bands; part of that is their burst, which counts in the first second and not in the "
    "bands (0.3 to 0.9 s). The rate is half an impulse per second or less outside of the band"
)

NEIGHBORS = (
    "nearer to the surface (0.5 mm) an end organ sees less of the neighbors of its probe than at "
    "0.6 mm, where the fall is 0.13. Probes 0.7 mm wide, an estimate as good, suppress more"
)

MISSES: dict[str, tuple[float, str]] = {
    "predicted: SAI in a hold of the pin at 0.2 mm, 1 mm wide": (11.8, NARROW),
    "predicted: SAI in a hold of the pin at 0.5 mm, 1 mm wide": (45.5, NARROW),
    "predicted: SAI in a hold of the pin at 1 mm, 1 mm wide": (102.1, NARROW),
    "predicted: SAI in a hold of the pin at 1.5 mm, 1 mm wide": (153.1, NARROW),
    "predicted: SAI in a hold of the pin at 0.2 mm, 2 mm wide": (1.3, WIDE),
    "predicted: SAI in a hold of the pin at 1.5 mm, 2 mm wide": (45.3, WIDE),
    "predicted: fall of the response of SAI by each further probe, one to seven": (
        0.113,
        NEIGHBORS,
    ),
}
"""By the name of a case: the known value, and the reason."""

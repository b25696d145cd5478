"""Numbers that the family `recorded` does not reach: what it gives, and why."""

WIDE = (
    "more than the models of TouchSim fire, which the stress on a half-space drives. At finite "
    "strain, deeper than half its width, a pin 2 mm wide strains the end organ below its middle "
    "0.8 times as much as one half as wide; a unit of the gain of those models is within the bands"
)

SPHERES = (
    "rates of vibrations and spheres are weighed against each other; the strain at 0.45 mm under "
    "the lightest force is too small below a flat surface and too large below wide spheres, by a "
    "fourth"
)

BURST = (
    "one impulse more than the models of TouchSim fire. The least weight of a release, 0.4 of "
    "that of an onset, which recorded releases require, goes with a strong onset; fits with fewer "
    "impulses in slow ramps miss the recorded rates at 300 Hz or the best frequency"
)

MISSES: dict[str, tuple[float, str]] = {
    "fitted: RMS error of SAI by curvature and force": (0.157, SPHERES),
    "predicted: SAI in a hold of the pin at 1 mm, 2 mm wide": (35.4, WIDE),
    "predicted: SAI in a hold of the pin at 1.5 mm, 2 mm wide": (66.7, WIDE),
    "predicted: impulses of FAI at the onset of a pin, 0.7 mm at 20 mm/s": (9.0, BURST),
}
"""By the name of a case: the known value, and the reason."""

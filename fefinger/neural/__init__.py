"""From signals at end organs to spikes: drives, end-organ filters, generators and membranes.

Knows no mesh, no finite elements and no scene: it takes arrays. What is here by name works on the
answer of a run, `ff.run(scene).spikes`, and its `times`, or makes end organs of one's own:

    from fefinger.neural import locking, psth
"""

from fefinger.neural.chains import Chain, SpringDamper, fast_chain, realize, slow_chain
from fefinger.neural.maps import rate_profile, receptive_fields
from fefinger.neural.statistics import (
    interval_variation,
    intervals,
    locking,
    mean_rates,
    per_cycle,
    psth,
    van_rossum,
    victor_purpura,
)


__all__ = [
    "Chain",
    "SpringDamper",
    "fast_chain",
    "interval_variation",
    "intervals",
    "locking",
    "mean_rates",
    "per_cycle",
    "psth",
    "rate_profile",
    "realize",
    "receptive_fields",
    "slow_chain",
    "van_rossum",
    "victor_purpura",
]

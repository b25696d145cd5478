"""
A study on two workers
======================

A grid of scenes in parallel. With ``scheduler="tcp://host:8786"`` in place of ``workers`` the
same runs on a Dask cluster.
"""

import matplotlib.pyplot as plt

import fefinger as ff


if __name__ == "__main__":  # workers are processes of their own
    table = ff.study(
        "flat-press",
        {"indenter.angle": (0, 10, 20, 30), "motion.speed": (5, 60)},
        changes={
            "finger.tissue": "maeno1998",
            "finger.resolution": "coarse",
            "motion.depth": 1.0,
            "motion.hold": 0.1,
            "ask.spikes": [],
            "ask.rel_error": 0.9,
        },
        mechanics="condensed",
        workers=2,
        at=("0.5N",),
    )
    rows = [row for row in table.rows if row["at"] == "peak"]
    fig, axis = plt.subplots(figsize=(6, 3.2), layout="constrained")
    for speed in (5, 60):
        chosen = [row for row in rows if row["motion.speed_mm_per_s"] == speed]
        axis.plot(
            [row["indenter.angle_deg"] for row in chosen],
            [row["force_N"] for row in chosen],
            "o-",
            label=f"{speed} mm/s",
        )
    axis.set(xlabel="angle / degrees", ylabel="peak force / N", ylim=(0, None))
    axis.legend(loc="lower right")
    plt.show()

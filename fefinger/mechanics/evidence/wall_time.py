"""Expected wall time on the cores of this machine, of the CPU seconds that costs are in.

Finite strain is solved on all cores, in part. The rest of all that is expected takes one.
"""

from collections.abc import Callable, Mapping

from fefinger.mechanics.evidence import carrying, reports, solid_cost
from fefinger.mechanics.situation import Situation
from fefinger.support.processes import threads


SHARED = 0.64
"""Share of the CPU seconds of finite strain that threads divide among them: `flat-press` on the
standard mesh took 20.8 CPU s in two threads, of which the first took 14.2."""


def _solid(case: Situation) -> float:
    return solid_cost.seconds(case) - reports.mesh_seconds(case)


SOLVED: Mapping[str, Callable[[Situation], float]] = {
    "solid": _solid,
    "pressed": carrying.building,
    "modal": carrying.building,
}
"""CPU seconds of finite strain in what a mechanics is expected to take."""


def wall(mechanics: str, case: Situation, seconds: float) -> float:
    """Return the expected wall time in s of so many CPU seconds of a mechanics, on a free machine.

    As many threads work as this process may use (`processes.threads`).
    """
    if mechanics not in SOLVED:
        return seconds
    return seconds - SHARED * (1 - 1 / threads()) * min(SOLVED[mechanics](case), seconds)

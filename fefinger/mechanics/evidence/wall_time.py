"""Expected wall time on the cores of this machine, from expected CPU seconds.

A share of the solution at finite strain uses all cores; everything else uses one.
"""

from collections.abc import Callable, Mapping

from fefinger.mechanics.evidence import small_strain_cost, solid_cost, tabulation_error
from fefinger.mechanics.situation import Situation
from fefinger.support.processes import threads


SHARED = 0.64
"""Share of the CPU seconds of finite strain that threads divide among them: `flat-press` on the
standard mesh took 20.8 CPU s in two threads, of which the first took 14.2."""


SOLVED: Mapping[str, Callable[[Situation], float]] = {
    "solid": lambda case: solid_cost.seconds(case) - small_strain_cost.mesh_seconds(case),
    "pressed": tabulation_error.building,
    "modal": tabulation_error.building,
}
"""Expected CPU seconds of finite strain within the cost of a mechanics."""


def wall(mechanics: str, case: Situation, seconds: float) -> float:
    """Convert expected CPU seconds of a mechanics to wall time in s on an idle machine.

    As many threads work as this process may use (`processes.threads`).
    """
    if mechanics not in SOLVED:
        return seconds
    return seconds - SHARED * (1 - 1 / threads()) * min(SOLVED[mechanics](case), seconds)

"""What inertia changes, and what `modal` errs by and costs."""

import math

from fefinger.mechanics.refusals import Doubt
from fefinger.mechanics.situation import Situation


def doubts(case: Situation) -> list[Doubt]:
    return []


def seconds(case: Situation) -> float:
    return 1.0


def once(case: Situation) -> float:
    return 1.0


def modal_error(case: Situation) -> float:
    return 0.01


def sentence(left: float) -> str:
    return ""

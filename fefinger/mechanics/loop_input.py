"""Input of a step of a loop: checks of its numbers, and the errors of a step that failed."""

import math

from fefinger.contact.active_set import BEYOND, TURNED
from fefinger.contact.stepper import Target
from fefinger.mechanics.loop_setup import LoopOptions
from fefinger.mechanics.press import mesh_limits
from fefinger.mechanics.press.prepared import AnyContact
from fefinger.mechanics.press.prepared_contacts import TabulatedContact
from fefinger.support.checks import ConvergenceError, InputError, number


LEFT = (
    "shift: expected a place at which the pad stays on the object, received ({:.4g}, {:.4g}) mm, "
    "where contact reaches its end; move it less, or take a larger object"
)

FAR = (
    "shift: expected a place at most `reach` = {:g} mm from the first one, received "
    "({:.4g}, {:.4g}) mm; give a larger `reach`"
)

FIXED = (
    "{}: expected none, as this object only moves along its axis, received {!r}; make the loop "
    "with mechanics='condensed' and {}"
)

TOO_DEEP = (
    "step: expected contact inside the candidates for a depth of {:g} mm, received contact at "
    "their rim; make the finger with a larger `deepest`, or press less where the pad ends"
)

BEYOND_TABLE = (
    "step: expected at most the `deepest` = {:g} mm of this finger, or the force there, received "
    "{:g} {}; give a larger `deepest`"
)


def failed_step(
    outcome: int, target: Target, contact: AnyContact, options: LoopOptions, newton: float
) -> InputError | ConvergenceError:
    """Return the error of a step to a target that ended with an outcome other than DONE.

    newton: N of the whole finger per mN of the meshed part.
    """
    if isinstance(contact, TabulatedContact):
        value, unit = target.value, "mm"
        if target.by_force:
            value, unit = value * newton, "N"
        return InputError(BEYOND_TABLE.format(options.deepest, value, unit))
    if outcome == TURNED and options.reach is not None:
        return InputError(LEFT.format(*target.shift))
    if outcome == TURNED:
        return InputError(mesh_limits.rim_reached(len(contact.pressure)))
    if outcome == BEYOND:
        return InputError(TOO_DEEP.format(options.deepest))
    return ConvergenceError(f"{contact.failures[outcome]}; take shorter steps")


def quick_number(name: str, value: object, least: float = -math.inf, *, unit: str) -> float:
    """Check a finite number of at least `least` as `checks.number`, in no time if it is one."""
    if isinstance(value, float) and least <= value < math.inf and value > -math.inf:
        return value
    return number(name, value, at_least=None if least == -math.inf else least, unit=unit)


def place(shift: tuple[float, float]) -> tuple[float, float]:
    """Return the place (2,) mm of the object; InputError if it is not two finite numbers."""
    try:
        x, y = shift
        return quick_number("shift", x, unit="mm"), quick_number("shift", y, unit="mm")
    except (TypeError, ValueError) as error:
        message = f"shift: expected two finite numbers in mm, received {shift!r}"
        raise InputError(message) from error

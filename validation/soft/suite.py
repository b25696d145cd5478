"""Suite `soft`: what stands for a soft object, against meshed bodies at finite strain."""

from collections.abc import Iterator
from functools import cache, partial

from fefinger.validation.case import Case, Expected
from fefinger.validation.soft.meshed import DEPTHS, DOME, RADIUS, SoftBlock, errors_beside_a_dome

from fefinger.mechanics import condensed, solid
from fefinger.scene.ask import Ask
from fefinger.scene.finger import Finger
from fefinger.scene.indenters import Flat
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene


MESHED = "the body meshed: neo-Hookean, finite strain, contact on the deformed surface"
SOLID = "`solid`: the finger at finite strain, with the same object"

THICK = {"a layer of 6 mm": 6.0, "20 mm, near a half-space": 20.0}
"""Thickness of the soft body in mm."""

SIZE = 1.2
"""Edge of the cells under the ball in mm, a third of the largest contact radius."""

MIRRORED = "both bodies meshed: one under a rigid plate at half of the approach, by symmetry"

LAYER = 6.0
"""Thickness of the domes in mm."""

PLATES = {100.0: 0.03, 20.0: 0.01}
"""Moduli of soft plates in kPa, and the error that finite strain of the skin has under them."""


@cache
def errors(thickness: float) -> tuple[float, ...]:
    """Return the relative errors of the force of what stands for a soft body, at DEPTHS."""
    block = SoftBlock(thickness, SIZE)
    return tuple((block.stood_for() / block.meshed() - 1).tolist())


def small_strain(modulus: float) -> float:
    """Return the relative error of `condensed` beside `solid` under a soft plate, at 0.8 mm."""
    scene = Scene(
        finger=Finger.subject("a.h.", tissue="maeno1998", resolution="coarse"),
        indenter=Flat(30.0, modulus=modulus),
        motion=Ramp(10.0, 0.8),
        ask=Ask(fields=False),
    )
    small, finite = (each.respond(scene).force[-1] for each in (condensed, solid))
    return float(small / finite - 1)


def cases(*, quick: bool) -> Iterator[Case]:
    """Yield the errors of the force, of the object and of the skin."""
    for name, thickness in THICK.items():
        if quick and thickness > DEPTHS[-1] * RADIUS:
            continue
        for k, depth in enumerate(DEPTHS):
            yield Case(
                f"rigid ball of {RADIUS:g} mm, {depth:g} mm deep in {name}: force",
                partial(lambda t, k: errors(t)[k], thickness, k),
                Expected(0.0, 0.03),
                MESHED,
                reason="small strain on a flat body: contact reaches 0.4 of the radius of the ball",
            )
    for k, depth in enumerate(DEPTHS):
        if not quick:
            yield Case(
                f"two equal domes of {DOME:g} mm, {LAYER:g} mm thick, {depth:g} mm: force",
                partial(lambda k: errors_beside_a_dome(LAYER)[k], k),
                Expected(0.0, 0.07),
                MIRRORED,
                reason="small strain on a flat body, for a dome that is bonded to a round core",
            )
    for modulus, error in PLATES.items():
        if not quick:
            yield Case(
                f"plate of {modulus:g} kPa, 0.8 mm: force of condensed beside solid",
                partial(small_strain, modulus),
                Expected(0.0, error),
                SOLID,
                reason="under a rigid plate it is 9 %: a softer object deforms the skin less",
            )

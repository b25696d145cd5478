"""Compliance of a finger beyond flat layers on flat bone: its sides, its tip, and its bone.

Near a load a finger yields as the layers do; what it yields beyond them varies over lengths of its
thickness, so that in a contact it is nearly one displacement, in proportion to the force. That is
read from one press of the whole finger on the coarse mesh, at small strain and without relaxation:
by the plate of the object, or by a ball at its place.
"""

from dataclasses import replace

from fefinger.mechanics.press import small_strain
from fefinger.mechanics.press.layer_grid import LayerGrid
from fefinger.mechanics.press.operator import METHOD
from fefinger.scene.ask import Ask
from fefinger.scene.finger import RESOLUTIONS, Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.indenters import Flat, Sphere
from fefinger.scene.motions import Ramp
from fefinger.scene.scene import Scene
from fefinger.support.checks import InputError
from fefinger.support.units import NEWTON_PER_MILLINEWTON
from fefinger.theory.contact.contact_table import tabulate_to
from fefinger.theory.contact.stack import Stack
from fefinger.theory.relaxation import Prony


PART = 0.06
"""Depth of the press over the thickness of the finger: on a coarse mesh a shallower contact is a
few facets wide, a deeper one as wide as the layers are thick."""

BALL = 0.8
"""Radius of the ball over the thickness of the finger: its contact is narrower than a plate's."""

ELASTIC = Prony((1.0,), ())

BEYOND = (
    "What sides, tip and bone of the finger yield beyond that is one displacement of the whole "
    "contact, {compliance:.3g} mm/N, from a press {depth:.2g} mm deep by a {object} on the coarse "
    "mesh; it does not strain the skin."
)

NOTHING_BEYOND = (
    "Warning: what sides, tip and bone of the finger yield beyond that is left out, and the stated "
    "error does not hold, since its coarse mesh could not be pressed: {reason}."
)


def on_finger(grid: LayerGrid, finger: Finger, indenter: Indenter) -> tuple[LayerGrid, str]:
    """Return a grid of layers with what the finger yields beyond them, and a note on that.

    A finger whose mesh cannot be made or pressed leaves the layers alone, which the note warns of.
    """
    by = pressed_by(finger, indenter)
    try:
        beyond = compliance(alone(finger), grid.layers, by)
    except InputError as error:
        return grid, NOTHING_BEYOND.format(reason=error)
    note = BEYOND.format(
        compliance=beyond / NEWTON_PER_MILLINEWTON,
        depth=PART * finger.thickness,
        object="ball" if by.flat is None else "plate",
    )
    return replace(grid, beyond=beyond), note


def alone(finger: Finger) -> Finger:
    """Return the finger that is pressed: coarse, elastic, and with a smooth pad."""
    return replace(finger, resolution=RESOLUTIONS[0], prony=ELASTIC, ridges=None)


def pressed_by(finger: Finger, indenter: Indenter) -> Flat | Sphere:
    """Return the plate, or the ball, that stands for an object."""
    plate = indenter.plate
    if plate is None:
        return Sphere(BALL * finger.thickness, at=indenter.place)
    return Flat(plate.angle, plate.tilt)


def compliance(finger: Finger, layers: Stack, indenter: Flat | Sphere) -> float:
    """Return the displacement in mm per mN of the finger beyond that of its layers.

    finger, indenter: as of `alone` and `pressed_by`. InputError for a finger that has no mesh.
    """
    ask = Ask(spikes=(), fields=False, strain=False, pressure=False)
    motion = Ramp(speed=1.0, depth=PART * finger.thickness, corner=0.0)
    scene = Scene(finger=finger, indenter=indenter, motion=motion, ask=ask)
    # The mesh of the finger serves all objects; it is solved whole, as contact may leave its pad.
    method = replace(small_strain.WHOLE_MESH, touch=METHOD.touch)
    answer = small_strain.respond(scene, mechanics="linear", notes=(), method=method)
    force = float(answer.force[-1]) / NEWTON_PER_MILLINEWTON
    radius = 1 / (1 / finger.pad_radius + 1 / indenter.least_radius)
    sunk = float(tabulate_to(layers, radius, force=force).depth(force))
    return (float(answer.depth[-1]) - sunk) / force

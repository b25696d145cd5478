"""Notes, and reasons against a mechanics, that several mechanics share.

Also in words: whether a contact with friction stuck, slipped in part, or slid.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from fefinger.results.records import Refusal
from fefinger.scene.finger import Finger
from fefinger.scene.indenter import Indenter
from fefinger.scene.motion import Motion
from fefinger.scene.tissue import Hard
from fefinger.support.arrays import Array, Flags
from fefinger.support.text import percent
from fefinger.theory.relaxation import Prony


QUASISTATIC = "Quasi-static: no inertia and no waves."

LOGARITHMIC = (
    "Finite strain: strains are logarithmic, in the directions of the undeformed finger; pressures "
    "are per undeformed area, contact areas are those of the deformed skin."
)

SPHERICAL = (
    "The pad is a sphere of one effective radius; its pressure is symmetric about the first touch."
)

CONVOLVED = (
    "The whole stress relaxes with one function G(t); strain is the elastic field of the pressure "
    "convolved with the creep function."
)


RIGID_BONE = (
    "The bone is rigid and the nail does not move. Bone of 17 GPa would lower a relaxed force by "
    "0.2 % and a peak by 0.6 %."
)


RIGID_OBJECT = "The object is rigid."

SOFT_OBJECT = (
    "The object is soft: it gives way {}, at small strain and without friction, as a flat "
    "body does, {}. The skin sees the movement along its pressure, by distances along the "
    "undeformed skin. The depth is the approach, by which both bodies give way."
)
"""Note on every answer with a soft object: what stands for it, as in Hertz's theory."""


class Reason(NamedTuple):
    """A reason against a mechanics, and the field or part of the scene to change, "" for none."""

    field: str
    text: str


def refusals(mechanics: str, about: str, reasons: Iterable[Reason]) -> tuple[Refusal, ...]:
    """Return the refusals of a mechanics for reasons `about` "ability", "accuracy" or "time"."""
    return tuple(Refusal(mechanics, about, reason.text, reason.field) for reason in reasons)


def normalization_notes(prony: Prony) -> Iterator[str]:
    """Yield a note if the published Prony weights do not add up to 1."""
    total = sum(prony.c)
    rounded = 5e-4  # distance of a sum of weights from 1 that four digits of each explain
    if abs(total - 1) > rounded:
        yield f"Published Prony weights sum to {total:.4g}; here they are divided by that sum."


def separate_relaxation_reasons(finger: Finger) -> Iterator[Reason]:
    """Yield the options by which the tissues do not share one relaxation function."""
    if finger.relaxation != "whole":
        reason = (
            f"finger.relaxation = {finger.relaxation!r}: this mechanics relaxes the whole stress"
        )
        yield Reason("finger.relaxation", reason)
    for layer in ("skin", "subcutaneous"):
        field = f"finger.{layer}.prony"
        if getattr(finger, layer).prony not in (None, finger.prony):
            reason = f"{field}: set, but this mechanics relaxes all tissue with one function"
            yield Reason(field, reason)


def finger_notes(finger: Finger) -> tuple[str, ...]:
    """Return notes on how the tissue of a finger is held and relaxes."""
    cut = "held" if finger.cut == "fixed" else "free"
    notes = [f"At its proximal end the tissue is {cut}.", *normalization_notes(finger.prony)]
    if finger.relaxation == "deviatoric":
        notes.append("Only the deviatoric stress relaxes; the pressure is elastic.")
    for layer in ("skin", "subcutaneous"):
        prony = getattr(finger, layer).prony
        if prony not in (None, finger.prony):
            notes.append(f"The {layer} relaxes with a series of its own.")
            notes.extend(normalization_notes(prony))
    return tuple(notes)


def stiffens(finger: Finger) -> bool:
    """Return whether a tissue of a finger stiffens with strain by its law."""
    return any(layer.stiffens for layer in (finger.skin, finger.subcutaneous))


def elastic_hard_parts_reasons(finger: Finger) -> Iterator[Reason]:
    """Yield an elastic bone, and a nail that is not fixed."""
    if isinstance(finger.bone, Hard):
        reason = (
            f"finger.bone.modulus = {finger.bone.modulus:.3g} kPa: this mechanics has a rigid bone"
        )
        yield Reason("finger.bone", reason)
    if finger.nail is not None:
        reason = "finger.nail: set, but this mechanics holds the nail with the bone"
        yield Reason("finger.nail", reason)


def own_relaxation_reasons(finger: Finger) -> list[Reason]:
    """Reasons why a finger does not relax as one body about a rigid bone."""
    return [*elastic_hard_parts_reasons(finger), *separate_relaxation_reasons(finger)]


def tangential_reasons(motion: Motion, indenter: Indenter) -> Iterator[Reason]:
    """Yield the options of a scene beyond a frictionless press along one direction."""
    if motion.slides:
        kind = f"motion.kind = {motion.kind!r}"
        yield Reason(
            "motion.kind", f"{kind}: this mechanics has no sideways motion of the indenter"
        )
    yield from friction_reasons(indenter)


def friction_reasons(indenter: Indenter) -> Iterator[Reason]:
    """Yield the friction of an indenter, if it has any."""
    if indenter.friction != 0:
        value = f"indenter.friction = {indenter.friction:g} > 0"
        yield Reason("indenter.friction", f"{value}: this mechanics has frictionless contact")


def object_note(indenter: Indenter) -> str:
    """Return the note on what the object is made of."""
    body = indenter.soft_body
    if body is None:
        return RIGID_OBJECT
    kind = "a half-space"
    if body.thickness < np.inf:
        kind = f"a layer of {body.thickness:g} mm bonded to a rigid base"
    modulus, poisson = body.surface
    how = "at once"
    if (series := indenter.soft_prony).v:
        how = f"more as it relaxes, to {percent(series.long_time)} of its stress at once"
    body_ = f"{kind} of {modulus:g} kPa and Poisson's ratio {poisson:g}"
    return SOFT_OBJECT.format(how, body_)


def soft_reasons(indenter: Indenter) -> Iterator[Reason]:
    """Yield the modulus of an object, where it is soft."""
    body = indenter.soft_body
    if body is not None:
        reason = f"indenter.modulus = {body.surface[0]:g} kPa: this mechanics has rigid objects"
        yield Reason("indenter.modulus", reason)


def relaxing_object_reasons(indenter: Indenter) -> Iterator[Reason]:
    """Yield the relaxation of a soft object."""
    if indenter.soft_prony.v:
        yield Reason("indenter.prony", "indenter.prony: set, but soft objects are elastic here")


def finite_sliding_reasons(motion: Motion, indenter: Indenter) -> Iterator[Reason]:
    """Yield the options of sliding and friction that finite strain does not support."""
    if motion.turns_plate:
        reason = (
            f"motion.kind = {motion.kind!r}: its plate does not turn, as by motion.angle or tilt"
        )
        yield Reason("motion.angle", reason)
    if motion.slides:
        yield from soft_reasons(indenter)


def plate_alone_slides(motion: Motion, indenter: Indenter) -> Iterator[Reason]:
    """Yield the sliding of an object whose surface moves with it."""
    if motion.slides and indenter.flat is None:
        reason = (
            f"motion.kind = {motion.kind!r}, indenter.kind = {indenter.kind!r}: a smooth plate "
            "alone slides with this mechanics"
        )
        yield Reason("motion.kind", reason)


def turning_reasons(motion: Motion, indenter: Indenter) -> tuple[Reason, ...]:
    """Return the reason against a plate that turns more than small strain can represent."""
    if not motion.turns_plate:
        return ()
    if indenter.soft_body is not None:
        reason = f"motion.kind = {motion.kind!r}: a rigid plate alone turns, not a soft one"
        return (Reason("indenter.modulus", reason),)
    if indenter.flat is None:
        reason = f"indenter.kind = {indenter.kind!r}: a smooth plate alone turns along a path"
        return (Reason("motion.angle", reason),)
    # The turn is read at 201 times, and at the corners of the path.
    times = np.linspace(0.0, motion.duration, 201)
    slopes = motion.inclines(np.union1d(times, motion.breakpoints), indenter.flat)
    turn = float(np.degrees(np.arctan(np.linalg.norm(slopes, axis=1).max())))
    # Degrees by which a plate may turn from its travel, a convention: its pressure then has 0.18 of
    # itself across the travel, which moves the tissue no more than friction of that coefficient.
    max_turn_deg = 10.0
    if turn <= max_turn_deg:
        return ()
    reason = (
        f"motion.angle, motion.tilt: turn of the plate from its travel = {turn:.3g} degrees > "
        f"{max_turn_deg:g}: pressure acts along the travel; start from an angle in the middle"
    )
    return (Reason("motion.angle", reason),)


def hard_parts_notes(finger: Finger) -> tuple[str, ...]:
    """Return notes on how bone and nail are held, and on their materials."""
    if not any(elastic_hard_parts_reasons(finger)):
        return (RIGID_BONE,)
    bone, nail = "The bone is rigid.", "The nail is held, as glued in the experiment."
    if isinstance(finger.bone, Hard):
        bone = f"The bone is elastic, of {finger.bone.modulus:.3g} kPa, and is held at its cut."
    if isinstance(finger.nail, Hard):
        nail = (
            f"The skin under the nail has the {finger.nail.modulus:.3g} kPa of the nail, which "
            "floats on its bed."
        )
    elif finger.nail is not None:
        nail = "The nail is left out: the skin under it is free."
    return (bone, nail)


def told(time: Array, area: Array, stick: Array, shift: Array, moving: Flags, cone: float) -> str:
    """Return in words what a contact did, and since when.

    time (n_t,) s; area and stick (n_t,) mm²: of contact, and of what of it sticks; shift (n_t, 2)
    mm of the object; moving (n_t,): when it does; cone: the largest distance of a traction from
    Coulomb's law, over the largest pressure.
    """
    touching = area > 0
    law = f"with a residual of {cone:.1g} of the highest pressure"
    if moving.any():
        touching = touching & moving
        slips = stick[touching] == 0
        onsets = np.flatnonzero(touching)[slips & ~np.append(False, slips[:-1])]
        if len(onsets):
            first, last = time[onsets[[0, -1]]]
            path = np.linalg.norm(shift[onsets[0]] - shift[0])
            often = f"; {len(onsets)} times in all, as some stick in between"
            held = f"{often}, last from {last:.4g} s on" if len(onsets) > 1 else ""
            end = "" if slips[-1] else "; at the end of the path some stick"
            return (
                f"Gross slip: from {first:.4g} s on, with the indenter moved by {path:.3g} mm, "
                f"no point of the skin sticks{held}{end}, {law}."
            )
    if not touching.any():
        return f"Friction: no contact while the indenter moves, {law}."
    share = float((stick[touching] / area[touching]).min())
    if share < 1:
        return f"Partial slip: at least {100 * share:.0f} % of the contact area sticks, {law}."
    return f"Sticking: no part of the contact slips, {law}."

"""A press with inertia: its time steps, and small-strain contact on a body of modes."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy import sparse

from fefinger.contact.inertial import InertialContact
from fefinger.contact.stepper import History, Prescribed, march
from fefinger.fem.body import Reduced
from fefinger.fem.condensation import Operator, displaced
from fefinger.fem.elements.probe import recovered_strain_at
from fefinger.mechanics.press import modal_body
from fefinger.mechanics.press.modal_body import FingerModes, ModalBody
from fefinger.mechanics.press.problem import Press
from fefinger.mechanics.press.small_strain import solve_contact
from fefinger.mechanics.press.time_steps import FAST_STEP, MODAL_STEP, MOST, RESOLVED, time_grid
from fefinger.scene.motion import Motion
from fefinger.support.arrays import Array, Flags, Integers
from fefinger.support.checks import InputError
from fefinger.support.processes import one_thread
from fefinger.support.progress import Stages


RINGING = 0.1
"""Time in s in which tissue of a published relaxation stops ringing after a motion."""

RECORDED = 1e-3
"""Longest time in s between stored states while the finger rings; FAST_STEP for FAII."""


@dataclass(frozen=True)
class TimeGrid:
    """Times (n_t,) s of the steps, and the numbers (n_out,) of those that are stored.

    longest: length in s of the longest step in which the modes have inertia.
    """

    time: Array
    stored: Integers
    longest: float


def modal_grid(motion: Motion, *, fast: bool) -> TimeGrid:
    """Return the steps of a motion; stored are the steps of statics, and more while it rings.

    InputError if the motion takes more steps than memory holds.
    """
    outer = time_grid(motion, fast=fast)
    lengths, moves = np.diff(outer), _moving(motion, outer)
    cycle = 1 / motion.highest_frequency if motion.highest_frequency else np.inf
    shortest = lengths[moves].min(initial=np.inf)
    # Steps per cycle of a vibration: its force is then 0.3 % off, by the order of the steps.
    steps_per_cycle = 60
    longest = float(min(MODAL_STEP, cycle / steps_per_cycle, shortest))
    # A part of the motion whose steps would be this many times as long as the shortest is
    # quasi-static.
    slow = 25.0
    short = moves & (lengths <= slow * longest)
    last = np.maximum.accumulate(np.where(short, outer[1:], -np.inf))
    rings = ~short & (outer[:-1] < last + RINGING)
    parts = np.ones(len(lengths), dtype=np.int64)
    swings = short | rings
    parts[swings] = np.ceil(lengths[swings] / longest * (1 - 1e-9)).astype(np.int64)
    total = int(parts.sum())
    if total > MOST:
        raise InputError(
            f"motion: expected one of at most {MOST} time steps with inertia, received one of "
            f"{total}; take fewer cycles or a shorter motion"
        )
    every = np.ones(len(lengths), dtype=np.int64)
    interval = FAST_STEP if fast else RECORDED
    recorded = np.ceil(lengths / interval * (1 - 1e-9)).astype(np.int64)
    every[rings] = np.maximum(1, parts[rings] // np.maximum(recorded[rings], 1))
    time, stored = [np.zeros(1)], [np.zeros(1, dtype=np.int64)]
    done = 0
    for start, length, count, stride in zip(outer[:-1], lengths, parts, every, strict=True):
        time.append(start + length * np.arange(1, count + 1) / count)
        chosen = np.arange(count, 0, -stride)[::-1]
        stored.append(done + chosen)
        done += int(count)
    times = np.concatenate(time)
    times[np.cumsum(parts)] = outer[1:]  # exactly those of statics
    return TimeGrid(times, np.concatenate(stored), longest * (1 + 1e-6))


def _moving(motion: Motion, time: Array) -> Flags:
    """Whether the motion moves in each interval (n_t - 1,) of the times."""
    middles = (time[1:] + time[:-1]) / 2
    moves = np.zeros(len(middles), dtype=np.bool_)
    for start, stop in motion.moving:
        moves |= (middles > start) & (middles < stop)
    return moves


@dataclass(frozen=True)
class ModalHistory:
    """A press with inertia through time, at the stored times of its grid.

    modes: of the finger; body: on the candidates, with the modes that had inertia; contact: its
    history, elastic pressures on the residual flexibility followed by the amplitudes of the modes.
    """

    modes: FingerModes
    body: ModalBody
    contact: History


def solve_modal(
    press: Press, grid: TimeGrid, stages: Stages, stiffening: float = 1.0
) -> ModalHistory:
    """Solve the contact with inertia at the times of a grid.

    `stiffening` multiplies the moduli of the finger.

    Errors as `small_strain.respond`, and ConvergenceError if the modes do not converge.
    """
    solid = operator_of(press)
    with stages.stage("modes") as report:
        modes = modal_body.finger_modes(press.finger, solid, report)
    made: list[ModalBody] = []

    def advance(
        press: Press, reduced: Reduced, prescribed: Prescribed, report: Callable[[float], None]
    ) -> History:
        static, probe = modal_body.stiffened(reduced, stiffening), partial(probe_of, press)
        body = modal_body.body_of_modes(press.finger, modes, static, probe, stiffening)
        body = body.below(RESOLVED / grid.longest)  # the modes that the steps resolve
        made[:] = [body]
        value = press.load_unit * press.motion.value(grid.time)
        on_grid = Prescribed(press.motion.control, grid.time, value)
        return one_thread(march)(
            contact_of(body, grid.longest), on_grid, report, stored=grid.stored
        )

    _, contact = solve_contact(press, stages, advance)
    return ModalHistory(modes, made[0], contact)


def probe_of(press: Press) -> sparse.csr_matrix:
    """Return the strain at the sites of a press from its unknowns, as a sparse matrix."""
    return recovered_strain_at(press.body.space, press.site_points, press.body.planes)


def contact_of(body: ModalBody, longest: float, *limits: Integers) -> InertialContact:
    """Return the contact of a body at rest; `limits` as of `InertialContact`."""
    on_pad = body.static.patch
    modes = body.oscillators, body.participation, body.residual_flexibility
    pad = on_pad.gap, on_pad.projected, longest
    return body.static.object.inertial(*modes, *pad, *limits)


def operator_of(press: Press) -> Operator:
    """Return the operator that a press is solved with."""
    if not isinstance(press.body, Operator):
        raise TypeError(f"press: expected an Operator, received {type(press.body).__name__}")
    return press.body


def displacements(press: Press, history: ModalHistory, frames: Integers, scale: float) -> Array:
    """Unknowns (n_unknowns, n_frames) of the body at some of the stored times.

    scale: factor on the moduli, by which the displacement under a pressure is smaller.
    """
    on_pad = history.body.static.patch
    elastic = history.contact.elastic_pressure[frames]
    loads = on_pad.loads @ elastic[:, : len(on_pad.gap)].T
    unknowns = displaced(operator_of(press), np.asarray(loads)) / scale
    size, amplitudes = press.body.space.n_displacements, history.body.amplitudes(elastic)
    numbers = np.arange(amplitudes.shape[1])
    unknowns[:size] += history.modes.combined(size, numbers, amplitudes)
    return unknowns


def at_stored(press: Press, grid: TimeGrid) -> Press:
    """Return the press at the stored times of a grid."""
    return replace(press, time=grid.time[grid.stored])
